#pragma once
// The hard boundary of a shadow in an image: where visibility crosses one half.

#include <vector>

#include "core/distance_transform.h"
#include "eval/metrics.h"

namespace gnomon {

inline constexpr float boundary_level = 0.5f;

// Boundary pixels are the dark ones (visibility below one half) with a light neighbour to the left, right, below or
// above; both must take part, so that the border of the mask is no silhouette.
struct Silhouette {
    std::vector<ivec2> pixels; // row by row
    Image<Site> nearest;       // the boundary pixel nearest to each pixel; empty where there are none
};

struct Silhouettes {
    Silhouette test, reference;
};
Silhouettes find_silhouettes(const ImagePair& pair);

// Distances in pixels between the two boundaries, from each pixel of either to the other. Infinite where only one
// image has a boundary, NaN where none has.
struct SilhouetteDistances {
    double mean, percentile_95, largest;
};
SilhouetteDistances silhouette_distances(const Silhouettes& silhouettes);

// Mean over the reference's boundary pixels of |penumbra width there − at the nearest boundary pixel of the test|, in
// pixels. NaN where that is nowhere known.
double penumbra_width_error(const ImagePair& pair, const Silhouettes& silhouettes);

// How much the error varies along the reference's boundary, in pixels. NaN without a boundary.
double jaggedness(const ImagePair& pair, const Silhouettes& silhouettes);

} // namespace gnomon
