// The fast path of the tile rasterizer: lists of triangles through depth, with stencil counts or triangle ids. Small
// triangles, and large ones that cover a tile in part, go patch by patch; others, and large ones that count, by 8×8
// blocks, whose depth bounds decide whole blocks where they can.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/list_kernel.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "raster/blocks-inl.h"
#include "raster/depth_bounds-inl.h"
#include "raster/patches-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// One triangle, by blocks.
template <ListMode mode, KeyKind kind, bool usual>
HWY_NOINLINE void draw_blocks(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box,
                              const TileEdges& tile_edge, std::uint32_t id, TileCounts& counts) {
    constexpr bool with_ids = mode == ListMode::Ids, counting = is_counting(mode);
    const BlockEdges edges(tile_edge);
    const DepthKeys<kind> depth(t, tile, state.key_scale);
    const int c0 = box.x0 >> 3, c1 = box.x1 >> 3, r0 = box.y0 >> 3, r1 = box.y1 >> 3;
    const std::uint32_t columns = (2u << c1) - (1u << c0);
    // Columns of blocks that the box holds whole.
    const int w0 = (box.x0 + 7) >> 3, w1 = (box.x1 + 1) >> 3;
    const std::uint32_t whole_columns = w1 > w0 ? (1u << w1) - (1u << w0) : 0;
    // Bounds of the whole triangle do for one that is not large.
    const bool large = c1 - c0 > 3 || r1 - r0 > 3;
    const BlockDepths<kind> depths(depth);
    alignas(64) std::int32_t low[tile_blocks], high[tile_blocks];
    bool whole_range = false;
    for (int r = r0; r <= r1; ++r) {
        const int y = r * block_side;
        const BlockEdges::Row row = edges.row(y);
        const std::uint32_t touched = row.touched & columns;
        if (!touched) continue;
        for (std::size_t k = 0; !whole_range && k < tile_blocks; ++k) low[k] = depth.low, high[k] = depth.high;
        whole_range = true;
        const std::uint32_t in_box = y >= box.y0 && y + 7 <= box.y1 ? whole_columns : 0;
        const std::uint32_t whole = in_box & ~row.crossed;
        prepare_bounds(state, tile, r, touched, low, high);
        const int first = r * tile_blocks;
        Verdicts verdicts = judge(state.test, low, high, tile.nearest + first, tile.farthest + first);
        if (large && touched & ~(verdicts.all | verdicts.none)) { // what the whole triangle's range leaves open
            whole_range = false;
            depths.bound(depth, y, low, high);
            prepare_bounds(state, tile, r, touched, low, high);
            verdicts = judge(state.test, low, high, tile.nearest + first, tile.farthest + first);
        }

        // What bounds alone decide.
        const std::uint32_t filled = !counting && state.write ? whole & verdicts.all : 0;
        for (std::uint32_t rest = filled; rest; rest &= rest - 1) {
            const int c = static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero32(rest));
            fill_block<with_ids>(tile, depth, c * block_side, y, low[c], high[c], id);
            tile.nearest[first + c] = low[c], tile.farthest[first + c] = high[c];
        }
        tile.loose &= ~(static_cast<std::uint64_t>(filled) << first);
        const std::uint32_t decided = filled | (counting ? 0 : whole & verdicts.none);
        counts.covered += 64 * bit_count(decided);
        counts.passed += 64 * bit_count(filled);

        for (std::uint32_t rest = touched & ~decided; rest; rest &= rest - 1) {
            const int column = static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero32(rest)), x = column * block_side;
            const int block = first + column;
            std::uint64_t covered = every_pixel;
            if (!(whole >> column & 1)) {
                covered = edges.covered(x, y);
                if (!(in_box >> column & 1)) covered &= box_pixels(box, x, y);
                if (!covered) continue;
            }
            counts.covered += bit_count(covered);
            const bool all = verdicts.all >> column & 1;
            std::uint64_t passed = 0;
            if (all && !with_ids && !state.write) {
                passed = covered;
            } else if (!(verdicts.none >> column & 1)) {
                passed = test_block<with_ids, kind, usual>(state, tile, depth, x, y, covered, all, id);
                if (passed && state.write) loosen_bounds(state, tile, block, low[column], high[column]);
            }
            counts.passed += bit_count(passed);
            if constexpr (counting)
                count_fragments<mode, block_pixels>(
                    state, tile, t.front, block_pixels * static_cast<std::size_t>(block), covered, passed, counts);
        }
    }
}

// One triangle, by what suits its size.
template <ListMode mode, KeyKind kind, bool usual, bool clamped>
HWY_INLINE void draw_triangle(const ListState& state, DepthTile& tile, const SetupTriangle& t, std::uint32_t id,
                              ListCounts& counts) {
    const LocalBox box = local_box(t, tile);
    if (t.extent != Extent::Large) {
        if ((box.x1 >> 2) - (box.x0 >> 2) > 2)
            draw_medium<mode, kind, usual, clamped>(state, tile, t, box, id, counts);
        else
            draw_small<mode, kind, usual, clamped>(state, tile, t, box, id, counts);
        return;
    }
    const TileEdges edges = tile_edges(t, state.conservative, tile.x, tile.y);
    if (edges.empty) return;
    if constexpr (!is_counting(mode))
        if (edges.crossed) return draw_large<mode, kind, usual, clamped>(state, tile, t, box, edges, id, counts);
    draw_blocks<mode, kind, usual>(state, tile, t, box, edges, id, counts);
}

template <ListMode mode, KeyKind kind, bool usual>
void draw_all(const ListState& state, DepthTile& tile, const SetupTriangle* triangles, const std::uint16_t* list,
              std::size_t count, std::uint32_t first_id, TileStores& stores, TileCounts& counts) {
    constexpr std::size_t ahead = 8; // triangles on their way from memory
    constexpr bool clamped_always = kind != KeyKind::Float || !usual || is_counting(mode);
    ListCounts drawn;
    for (std::size_t k = 0; k < count; ++k) {
        if (k + ahead < count) {
            hwy::Prefetch(&triangles[list[k + ahead]]);
            hwy::Prefetch(&triangles[list[k + ahead]].depth_dx);
        }
        const SetupTriangle& t = triangles[list[k]];
        const std::uint32_t id = first_id + list[k];
        if (t.steady)
            draw_triangle<mode, kind, usual, clamped_always>(state, tile, t, id, drawn);
        else
            draw_triangle<mode, kind, usual, true>(state, tile, t, id, drawn);
        if constexpr (mode == ListMode::Depth)
            if (!stores.empty()) stores.store(stores.rows_at_once);
    }
    drawn.add_to(counts);
}

template <ListMode mode, KeyKind kind> DrawList for_test(const ListState& state) {
    const bool usual = state.test == Compare::Less && state.write == !is_counting(mode);
    return usual ? draw_all<mode, kind, true> : draw_all<mode, kind, false>;
}
template <ListMode mode> DrawList for_format(const ListState& state) {
    if (state.key_scale != 0) return for_test<mode, KeyKind::Unorm>(state);
    return state.offset ? for_test<mode, KeyKind::OffsetFloat>(state) : for_test<mode, KeyKind::Float>(state);
}

DrawList list_function(const ListState& state) {
    switch (state.mode) {
    case ListMode::Depth:
        return for_format<ListMode::Depth>(state);
    case ListMode::Ids:
        return for_format<ListMode::Ids>(state);
    case ListMode::Count8:
        return for_format<ListMode::Count8>(state);
    case ListMode::Count32:
        break;
    }
    return for_format<ListMode::Count32>(state);
}

using ListFunctions = DrawList (*)(const ListState& state);
ListFunctions list_table() { return list_function; }

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "raster/isa.h"

namespace gnomon::detail {
HWY_EXPORT(list_table);

DrawList draw_list(const ListState& state) {
    static DrawList (*const chosen)(const ListState&) =
        for_chosen_isa([] { return HWY_DYNAMIC_DISPATCH(list_table)(); });
    return chosen(state);
}
} // namespace gnomon::detail
#endif
