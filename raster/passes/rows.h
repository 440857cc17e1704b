#pragma once
// Rows of targets as plain floats, whatever the format: what the image passes loop over, and how they count.

#include <vector>

#include "raster/target.h"

namespace gnomon::detail {

// Row y of a target, channels interleaved, with `reach` copies of the end texels on either side: texel x is at
// (x + reach)·channels. Any format but integer and stencil ones; a depth is its one channel.
void load_row(const Target& source, int y, int layer, int reach, std::vector<float>& row);

// width·channels floats into row y, converted to the format. Not for depth formats.
void store_row(Target& destination, int y, int layer, const float* row);

// `fragments` of a full-screen pass, which together fetch `texels` of `texel_bytes` and write `fragment_bytes` each.
void count_fragments(PassCounters& counters, std::int64_t fragments, std::int64_t texels, std::int64_t texel_bytes,
                     std::int64_t fragment_bytes);

} // namespace gnomon::detail
