#pragma once
// The inside of a tile for the states that most passes have: depth alone, with stencil counters, or with a program that
// needs to run for visible fragments only. The tile's depth and stencil stay in a buffer of its own while the draw's
// triangles go through, and the program runs when they are through.

#include <optional>
#include <span>

#include "raster/depth_tile.h"
#include "raster/tile.h"
#include "raster/visible.h"

namespace gnomon::detail {

// How the list kernel has to draw this; none where the state needs the general path of tile.h.
std::optional<ListState> list_state(const Draw& draw, const PipelineState& state, const Targets& targets);

// Draws the lists in order. `load` says that the tile starts with what the targets' load operations give.
void draw_fast_tile(const TileDraw& tile, const ListState& state, int tile_x, int tile_y, bool load,
                    std::span<const TileList> lists, PassCounters& counters);

} // namespace gnomon::detail
