#pragma once
// The inside of a tile: one triangle at a time through coverage, depth, stencil, program and blending, 8×8 pixels at a
// step.

#include "raster/draw.h"
#include "raster/kernels.h"

namespace gnomon::detail {

inline constexpr int tile_shift = 6;
inline constexpr int tile_side =
    1 << tile_shift; // pixels: every edge function that crosses a tile fits 32 bits (setup.h)

// What is the same for all triangles of a draw.
struct TileDraw {
    const Draw* draw;
    const PipelineState* state;
    const Targets* targets;
    const float* varyings;
    const Kernels* kernels;
};

// Draws the part of the triangle inside the tile whose lower left pixel is (tile_x, tile_y). Adds the fragment and byte
// counters.
void draw_in_tile(const TileDraw& tile, const SetupTriangle& triangle, const AttributePlanes* attributes, int tile_x,
                  int tile_y, PassCounters& counters);

} // namespace gnomon::detail
