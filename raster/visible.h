#pragma once
// Programs that need to run for visible fragments only: they run when a tile's triangles are through, once a pixel.

#include <algorithm>
#include <span>

#include "raster/depth_tile.h"
#include "raster/tile.h"

namespace gnomon::detail {

// Some set-up triangles of a draw, and which of them touch a tile, in order.
struct TileList {
    const SetupTriangles* triangles;
    std::span<const std::uint16_t> indices;
};
inline constexpr size_t most_triangles_of_a_list = 1 << 16; // a tile's ids hold the list above and the triangle below

// The part of a tile inside a target.
struct TilePart {
    int columns, rows;
    bool whole() const { return columns == tile_side && rows == tile_side; }
};
inline TilePart part_of_tile(const Target& target, int level, int tile_x, int tile_y) {
    return {std::min(tile_side, target.width(level) - tile_x), std::min(tile_side, target.height(level) - tile_y)};
}

// Runs the program for the fragments whose ids the tile holds. With `clear` all other pixels of the colour targets get
// their clear colour.
void shade_visible(const TileDraw& draw, const DepthTile& tile, bool clear, std::span<const TileList> lists,
                   PassCounters& counters);

} // namespace gnomon::detail
