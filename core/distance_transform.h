#pragma once
// The exact Euclidean distance transform of a seed image, with the nearest seed of every pixel: what distances to
// silhouettes are measured with. Integers throughout. [Macedo 2018, 2.11; Meijster, Roerdink & Hesselink 2000;
// Felzenszwalb & Huttenlocher 2012]
//
// Tie rule: of the seeds nearest to a pixel, the one with the smallest x; of these, the one with the smallest y. (The
// parallel banding algorithm on GPUs rounds its parabola intersections, so its ties may differ; its distances do not.)

#include <cstdint>

#include "core/image.h"

namespace gnomon {

// A pixel's nearest seed, 4 bytes as on a GPU; (−1, −1) where the image has no seed at all.
struct Site {
    std::int16_t x = -1, y = -1;

    bool exists() const { return x >= 0; }
    friend bool operator==(const Site&, const Site&) = default;
};

// A non-zero pixel is a seed.
Image<Site> nearest_seeds(const Image<std::uint8_t>& seeds);

// Squared distance in pixels from each pixel to its site: at most 2·32767², which fits. `no_seed_distance` without one.
inline constexpr std::int32_t no_seed_distance = 0x7fffffff;
Image<std::int32_t> squared_distances(const Image<Site>& sites);

} // namespace gnomon
