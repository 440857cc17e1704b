#pragma once
// Mip chains by averaging: what a technique filters a map with when its footprint is larger than a kernel.
//
// Level rule: a level has max(1, ⌊n/2⌋) texels along an axis, as in OpenGL. A texel is the mean of the source texels it
// covers, by area: two equal taps where the source side is even (the 2×2 box); where it is odd, n = 2m + 1, texel i
// covers [i·n/m, (i + 1)·n/m), three taps weighted (m − i)/n, m/n, (i + 1)/n, so that every level keeps the mean of the
// map; one tap where the side is 1. [Guthe & Heckbert 2005, "Non-power-of-two mipmap creation", for the odd case]
// Float throughout: first along columns, bottom up, then along rows, left to right.
//
// Cost: one full-screen pass a level and layer; a fragment fetches its 1 to 3 × 1 to 3 taps one by one.

#include <memory>
#include <vector>

#include "raster/target.h"

namespace gnomon {

// Side of level `level` of a map with side `size`, and the number of levels down to 1×1, level 0 included.
constexpr int mip_side(int size, int level) { return size >> level > 1 ? size >> level : 1; }
int mip_levels(int width, int height);

// Fills `destination`, one level above `source`, in every layer: same layers and channels, sides mip_side(·, 1).
// Formats are read and written as a program would; depth is an averaged R32F or so, not a depth format.
void fill_mip(Pass& pass, const Target& source, Target& destination);

// [0] is `base` itself, [l] its level l, the last 1×1, all in base's format. `meter`, if any, counts the new levels.
std::vector<Target> mip_chain(Pass& pass, Target base, const std::shared_ptr<MemoryMeter>& meter = nullptr);

} // namespace gnomon
