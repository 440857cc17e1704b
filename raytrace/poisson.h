#pragma once
// A sequence of points on the torus each of whose beginnings is spread evenly: Mitchell's best candidates.

#include <cstdint>
#include <vector>

namespace gnomon {

// Coordinates × 2³².
struct TorusPoint {
    std::uint32_t x = 0, y = 0;
};

// The first `count` points, always the same ones: each is, of 32 points drawn at random, the one farthest from all
// before it, distances measured around the unit square's edges [Mitchell 1991, "Spectrally Optimal Sampling for
// Distribution Ray Tracing", section 3; the number of candidates is constant, so that the cost is linear].
std::vector<TorusPoint> best_candidates(std::size_t count);

} // namespace gnomon
