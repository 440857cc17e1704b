#pragma once
// The inside of a tile for every state there is: one triangle at a time through coverage, depth, stencil, program and
// blending, 8×8 pixels at a step, straight on the targets' memory.

#include "raster/draw.h"
#include "raster/kernels.h"

namespace gnomon::detail {

// What is the same for all triangles of a draw.
struct TileDraw {
    const Draw* draw;
    const PipelineState* state;
    const Targets* targets;
    const vec4* positions;
    const float* varyings;
    const Kernels* kernels;
};

// The planes of a triangle's varyings; `pieces` are those of its chunk.
AttributePlanes attribute_planes(const TileDraw& tile, const SetupTriangle& triangle, const ClippedPiece* pieces);
inline const float* varyings_of(const TileDraw& tile, std::uint32_t vertex) {
    return tile.varyings + size_t{vertex} * static_cast<size_t>(tile.draw->varying_count);
}

using Depths = std::array<double, 64>;

// The inputs of a run's fragments: from its depths, and from its planes where it has any.
void set_depth(const FragmentRun& run, FragmentBlock& block, const Depths& depth);
void set_varyings(const TileDraw& tile, const FragmentRun& run, FragmentBlock& block);

// Writes what the fragment program gave to colour target c, for the pixels of the mask in the block at (x, y).
void write_color(const TileDraw& tile, size_t c, int x, int y, int layer, std::uint64_t mask,
                 const BlockColors::value_type& color);

// Draws the part of the triangle inside the tile whose lower left pixel is (tile_x, tile_y). Adds the fragment and byte
// counters.
void draw_in_tile(const TileDraw& tile, const SetupTriangle& triangle, const ClippedPiece* pieces, int tile_x,
                  int tile_y, PassCounters& counters);

// Bytes that one fragment reads and writes of the colour targets.
struct ColorBytes {
    int read = 0, written = 0;
};
ColorBytes color_bytes(const TileDraw& tile);

} // namespace gnomon::detail
