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

// Draws tiles one after the other; `load` says that they start with what the targets' load operations give. The depth
// of a tile may reach its target while the next is drawn.
class FastTiles {
public:
    FastTiles(const TileDraw& draw, const ListState& state, bool load);

    // Draws the lists in order.
    void draw(int tile_x, int tile_y, std::span<const TileList> lists, PassCounters& counters);
    // To be called after the last tile: then all is in the targets, and seen by whoever comes next.
    void finish();

private:
    bool waits(int tile_x, int tile_y) const;
    TileCounts draw_lists(DepthTile& tile, std::span<const TileList> lists);
    void count(const TileCounts& counts, PassCounters& counters) const;

    const TileDraw& draw_;
    const ListState& state_;
    bool load_;
    DrawList kernel_;
    TileStores stores_;
    DepthTile tiles_[2]; // one is drawn while the other is stored
    size_t turn_ = 0;    // which one is drawn
};

} // namespace gnomon::detail
