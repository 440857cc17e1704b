#pragma once
// The min-max pyramid of a depth map, also called hierarchical shadow map: over a rectangle of texels it answers "no
// depth here is nearer than, or farther than", which proves receivers fully lit or fully hidden with a handful of
// fetches. [Macedo 2018, 2.13 and eq. 5.4]
//
// Level rule: level 0 is (S, S), level l has ⌈n/2^l⌉ texels along an axis, down to 1×1, and its texel i covers texels
// [i·2^l, (i + 1)·2^l) of the map, cut off at the border. For powers of two this is n/2^l; for other sides rounding up
// is what keeps every texel covered with 2×2 fetches.
//
// Cost: one full-screen pass a level; a fragment fetches the (up to four) texels under it. A query fetches the texels
// of its level that overlap the rectangle: at most four at the level that min_max_level names.

#include <memory>
#include <vector>

#include "raster/target.h"

namespace gnomon {

struct MinMax {
    float minimum = infinity; // minimum > maximum: nothing there
    float maximum = -infinity;

    friend bool operator==(const MinMax&, const MinMax&) = default;
};

struct MinMaxPyramid {
    std::vector<Target> levels; // RG32F: minimum, maximum; [0] is as large as the map
};

// Of the first channel of `source` (a depth format or a colour format), in every layer. NaN counts as nothing.
MinMaxPyramid min_max_pyramid(Pass& pass, const Target& source, const std::shared_ptr<MemoryMeter>& meter = nullptr);

// The smallest level at which any rectangle of that many texels overlaps at most 2×2: ⌈log2(max(width, height))⌉.
// [Macedo 2018, 2.13.3: ρ texels either way are 2ρ + 1]
int min_max_level(int width, int height);

// Bounds on the map over texels first to last, both included: never tighter than the truth, exact at level 0. Texels
// outside the map count as nothing (a caller with a border adds it). `level` is cut off at the pyramid's top.
MinMax min_max_over(const MinMaxPyramid& pyramid, ivec2 first, ivec2 last, int level, PassCounters& counters,
                    int layer = 0);
inline MinMax min_max_over(const MinMaxPyramid& pyramid, ivec2 first, ivec2 last, PassCounters& counters) {
    return min_max_over(pyramid, first, last, min_max_level(last.x - first.x + 1, last.y - first.y + 1), counters);
}

} // namespace gnomon
