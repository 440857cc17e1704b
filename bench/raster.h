#pragma once
// What the timings of rasterized passes and of look-ups share.

#include <cstdint>
#include <vector>

#include "bench/bench.h"
#include "bench/scenes.h"
#include "raster/target.h"

namespace gnomon_bench {

inline constexpr const char* peer = "llvmpipe";

// The stored depths or stencil values, row by row from the bottom.
std::vector<std::uint32_t> keys_of(const Target& target);

// A full screen of 15 x 15 percentage-closer look-ups.
void time_pcf(Bench& bench, Scene scene);

} // namespace gnomon_bench
