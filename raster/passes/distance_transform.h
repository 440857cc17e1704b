#pragma once
// The exact Euclidean distance transform (core/distance_transform.h) as passes of a GPU: what image-space penumbra
// techniques measure distances to silhouettes with.
//
// Cost: as the parallel banding algorithm [Cao et al. 2010] has it, flood columns, transpose, stack proximate sites,
// colour, transpose back: five passes, in each of which a pixel fetches a 4-byte site and writes one. The walks along
// stacks, which depend on the data, are left out.

#include "core/distance_transform.h"
#include "raster/counters.h"

namespace gnomon {

Image<Site> nearest_seeds(Pass& pass, const Image<std::uint8_t>& seeds);
Image<std::int32_t> squared_distances(Pass& pass, const Image<Site>& sites);

} // namespace gnomon
