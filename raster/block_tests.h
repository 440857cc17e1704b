#pragma once
// Depth bounds, stencil and depth test of one 8×8 block of fragments, and what they write.

#include <array>
#include <bit>
#include <cstdint>

#include "raster/tile.h"

namespace gnomon::detail {

using Keys = std::array<std::uint32_t, 64>; // depth_key of each pixel

template <class Visit> void for_each_pixel(std::uint64_t mask, const Visit& visit) {
    for (; mask; mask &= mask - 1) visit(std::countr_zero(mask));
}

template <class Visit> void for_each_row(std::uint64_t mask, const Visit& visit) {
    for (int j = 0; mask; ++j, mask >>= 8)
        if (mask & 0xff) visit(j, static_cast<std::uint32_t>(mask & 0xff));
}

// Whether rows of eight 32-bit values can be read and written at once: the block does not stick out of the target.
bool has_whole_rows(const Target& target, int x, int level);

// depth_key for values that are in [0, 1] already.
void quantize_depth(Format format, std::uint64_t mask, const Depths& depth, Keys& keys);

// The fragments of `mask` in the block at (x, y), in one layer of the targets' memory, that pass; updates stencil and
// depth. `keys` are their depths, or null for D32F targets with whole rows: one kernel then evaluates, tests and
// writes.
std::uint64_t run_tests(const TileDraw& tile, const SetupTriangle& triangle, int x, int y, int layer,
                        std::uint64_t mask, const Keys* keys, PassCounters& counters);

} // namespace gnomon::detail
