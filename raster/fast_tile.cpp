#include "raster/fast_tile.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include <emmintrin.h>
#include <hwy/cache_control.h>

namespace gnomon::detail {
namespace {

constexpr int most_waiting = 4; // tiles without triangles that wait for one that has some

// Between rows of a target and a tile's patches: visit(texels, where they lie in the tile, how many of a patch's row).
template <class AnyTarget, class T, class Visit>
void for_each_patch_row(AnyTarget& target, const Targets& targets, const DepthTile& tile, T* places,
                        const Visit& visit) {
    const TilePart extent = part_of_tile(target, targets.level, tile.x, tile.y);
    const size_t bytes = patch_side * static_cast<size_t>(target.texel_bytes());
    for (int j = 0; j < extent.rows; ++j) {
        auto* texels = target.texel(tile.x, tile.y + j, targets.layer, targets.level);
        T* row = places + place_in_tile(0, j);
        int i = 0;
        for (; i + block_side <= extent.columns; i += block_side, texels += 2 * bytes, row += block_pixels) {
            visit(texels, row, patch_side);
            visit(texels + bytes, row + patch_pixels, patch_side);
        }
        if (i < extent.columns) visit(texels, row, std::min(patch_side, extent.columns - i));
        if (i + patch_side < extent.columns) visit(texels + bytes, row + patch_pixels, extent.columns - i - patch_side);
    }
}

// Asks for a tile's rows, which the prefetcher would not guess.
void prefetch_rows(const Target& target, const Targets& targets, const DepthTile& tile) {
    const TilePart extent = part_of_tile(target, targets.level, tile.x, tile.y);
    for (int j = 0; j < extent.rows; ++j) {
        const std::byte* row = target.texel(tile.x, tile.y + j, targets.layer, targets.level);
        const int bytes = extent.columns * target.texel_bytes();
        for (int at = 0; at < bytes; at += 64) hwy::Prefetch(row + at);
    }
}

template <class T> void copy_in(const std::byte* from, T* to, int count) {
    if (count == patch_side)
        std::memcpy(to, from, patch_side * sizeof(T));
    else
        std::memcpy(to, from, static_cast<size_t>(count) * sizeof(T));
}
template <class T> void copy_out(std::byte* to, const T* from, int count) {
    if (count == patch_side)
        std::memcpy(to, from, patch_side * sizeof(T));
    else
        std::memcpy(to, from, static_cast<size_t>(count) * sizeof(T));
}

void load_depth(const Target& target, const Targets& targets, bool load, const Kernels& kernels, DepthTile& tile) {
    tile.unknown = ~std::uint64_t{0}, tile.loose = 0;
    if (load && targets.clear_depth) {
        const auto key =
            static_cast<std::int32_t>(depth_key(target.format(), static_cast<double>(*targets.clear_depth)));
        kernels.fill_tile(tile.depth, key);
        std::fill_n(tile.nearest, tile_blocks * tile_blocks, key);
        std::fill_n(tile.farthest, tile_blocks * tile_blocks, key);
        tile.unknown = 0;
        return;
    }
    prefetch_rows(target, targets, tile);
    if (!part_of_tile(target, targets.level, tile.x, tile.y).whole()) std::fill_n(tile.depth, tile_pixels, 0);
    if (target.texel_bytes() == 4) {
        for_each_patch_row(target, targets, tile, tile.depth, copy_in<std::int32_t>);
        return;
    }
    for_each_patch_row(target, targets, tile, tile.depth, [](const std::byte* from, std::int32_t* to, int count) {
        for (int i = 0; i < count; ++i) {
            std::uint16_t key;
            std::memcpy(&key, from + 2 * i, sizeof(key));
            to[i] = key;
        }
    });
}

TileStores stores_to(const Target& target, const Targets& targets, const Kernels& kernels) {
    const size_t stride = static_cast<size_t>(target.width(targets.level) * target.texel_bytes());
    const auto first = reinterpret_cast<std::uintptr_t>(target.texel(0, 0, targets.layer, targets.level));
    const bool aligned = (first | stride) % 64 == 0; // and so all tiles are
    return {.store_rows = kernels.store_rows,
            .fill_rows = kernels.fill_rows,
            .stride = stride,
            .stream = aligned && is_streamed(target),
            .cleared = targets.clear_depth ? static_cast<std::int32_t>(
                                                 depth_key(target.format(), static_cast<double>(*targets.clear_depth)))
                                           : 0};
}

void store_depth(Target& target, const Targets& targets, const DepthTile& tile, const Kernels& kernels) {
    if (target.texel_bytes() == 4) {
        if (!part_of_tile(target, targets.level, tile.x, tile.y).whole()) {
            for_each_patch_row(target, targets, tile, tile.depth, copy_out<std::int32_t>);
            return;
        }
        const TileStores stores = stores_to(target, targets, kernels);
        kernels.store_rows(tile.depth, 0, tile_side, target.texel(tile.x, tile.y, targets.layer, targets.level),
                           stores.stride, stores.stream);
        return;
    }
    for_each_patch_row(target, targets, tile, tile.depth, [](std::byte* to, const std::int32_t* from, int count) {
        for (int i = 0; i < count; ++i) {
            const auto key = static_cast<std::uint16_t>(from[i]);
            std::memcpy(to + 2 * i, &key, sizeof(key));
        }
    });
}

template <class T> void load_counters(Target& target, const Targets& targets, bool load, DepthTile& tile, T* counters) {
    if (load && targets.clear_stencil) {
        std::fill_n(counters, tile_pixels, static_cast<T>(*targets.clear_stencil));
        return;
    }
    for_each_patch_row(target, targets, tile, counters, copy_in<T>);
}

template <class T>
void store_counters(Target& target, const Targets& targets, const DepthTile& tile, const T* counters) {
    for_each_patch_row(target, targets, tile, counters, copy_out<T>);
}

void fill_others(const Targets& targets, const ListState& state, const DepthTile& tile) {
    if (targets.stencil && targets.clear_stencil && !is_counting(state.mode)) {
        const TilePart extent = part_of_tile(*targets.stencil, targets.level, tile.x, tile.y);
        targets.stencil->fill(tile.x, tile.y, extent.columns, extent.rows, targets.layer, targets.level,
                              targets.stencil->cleared_uint(*targets.clear_stencil));
    }
    if (!targets.clear_color || state.mode == ListMode::Ids) return;
    for (Target* target : targets.color) {
        if (!target) continue;
        const TilePart extent = part_of_tile(*target, targets.level, tile.x, tile.y);
        target->fill(tile.x, tile.y, extent.columns, extent.rows, targets.layer, targets.level,
                     target->cleared(*targets.clear_color));
    }
}

bool counts_only(const StencilFace& face, std::uint32_t maximum) {
    const auto counts = [](StencilOp op) {
        return op == StencilOp::Keep || op == StencilOp::IncrementWrap || op == StencilOp::DecrementWrap;
    };
    return face.test == Compare::Always && counts(face.depth_fail) && counts(face.pass) &&
           (face.write_mask & maximum) == maximum;
}

std::int8_t step_of(StencilOp op) {
    return op == StencilOp::IncrementWrap   ? std::int8_t{1}
           : op == StencilOp::DecrementWrap ? std::int8_t{-1}
                                            : std::int8_t{0};
}

} // namespace

std::optional<ListState> list_state(const Draw& draw, const PipelineState& state, const Targets& targets) {
    if (!targets.depth || targets.samples != 1 || state.depth.bounds) return std::nullopt;
    ListState list;
    list.test = state.depth.test;
    list.write = state.depth.write;
    list.conservative = state.conservative;
    list.offset = state.polygon_offset.factor != 0 || state.polygon_offset.units != 0;
    list.key_scale = targets.depth->format() == Format::D16   ? 65535.0
                     : targets.depth->format() == Format::D24 ? 16777215.0
                                                              : 0.0;
    const bool stencil = state.stencil.enabled && targets.stencil;
    if (draw.fragments) {
        const bool reads = state.blend.enabled || state.logic_op != LogicOp::Copy;
        if (!draw.flags.visible_only || draw.flags.discards || draw.flags.writes_depth || reads || stencil)
            return std::nullopt;
        list.mode = ListMode::Ids;
    } else if (stencil) {
        const bool narrow = targets.stencil->format() == Format::S8;
        const std::uint32_t maximum = narrow ? 0xffu : 0xffffffffu;
        if (list.write || !counts_only(state.stencil.front, maximum) || !counts_only(state.stencil.back, maximum))
            return std::nullopt;
        list.mode = narrow ? ListMode::Count8 : ListMode::Count32;
        for (const bool front : {false, true}) {
            const StencilFace& face = front ? state.stencil.front : state.stencil.back;
            list.counts[front][0] = step_of(face.depth_fail);
            list.counts[front][1] = step_of(face.pass);
        }
    }
    return list;
}

FastTiles::FastTiles(const TileDraw& draw, const ListState& state, bool load)
    : draw_(draw), state_(state), load_(load), kernel_(draw_list(state)),
      stores_(stores_to(*draw.targets->depth, *draw.targets, *draw.kernels)) {}

// Whether the depth of a tile may be stored later.
bool FastTiles::waits(int tile_x, int tile_y) const {
    const Target& target = *draw_.targets->depth;
    return state_.mode == ListMode::Depth && target.texel_bytes() == 4 &&
           part_of_tile(target, draw_.targets->level, tile_x, tile_y).whole();
}

void FastTiles::finish() {
    stores_.store(stores_.rows_left());
    _mm_sfence(); // for what was streamed
}

void FastTiles::draw(int tile_x, int tile_y, std::span<const TileList> lists, PassCounters& counters) {
    const Targets& targets = *draw_.targets;
    const bool clear_depth = load_ && targets.clear_depth, waiting = waits(tile_x, tile_y);
    DepthTile& tile = tiles_[turn_];
    tile.x = tile_x, tile.y = tile_y;
    if (load_) fill_others(targets, state_, tile);
    if (lists.empty() && clear_depth && waiting) {
        stores_.tiles.push_back({nullptr, targets.depth->texel(tile_x, tile_y, targets.layer, targets.level)});
        stores_.store(stores_.rows_left() - (stores_.stream ? most_waiting * tile_side : 0));
        return;
    }
    load_depth(*targets.depth, targets, load_, *draw_.kernels, tile);
    if (state_.mode == ListMode::Ids)
        draw_.kernels->fill_tile(reinterpret_cast<std::int32_t*>(tile.id), static_cast<std::int32_t>(DepthTile::no_id));
    if (state_.mode == ListMode::Count8) load_counters(*targets.stencil, targets, load_, tile, tile.count8);
    if (state_.mode == ListMode::Count32) load_counters(*targets.stencil, targets, load_, tile, tile.count32);

    const TileCounts counts = draw_lists(tile, lists);
    const bool store = (state_.write && counts.passed) || clear_depth;
    if (store && waiting) {
        stores_.tiles.push_back({tile.depth, targets.depth->texel(tile_x, tile_y, targets.layer, targets.level)});
        turn_ = 1 - turn_;
    } else if (store) {
        store_depth(*targets.depth, targets, tile, *draw_.kernels);
    }
    if (counts.counted || (load_ && targets.clear_stencil)) {
        if (state_.mode == ListMode::Count8) store_counters(*targets.stencil, targets, tile, tile.count8);
        if (state_.mode == ListMode::Count32) store_counters(*targets.stencil, targets, tile, tile.count32);
    }
    const bool clear_color = load_ && targets.clear_color;
    if (state_.mode == ListMode::Ids && (counts.passed || clear_color))
        shade_visible(draw_, tile, clear_color, lists, counters);
    count(counts, counters);
}

// All that waits is stored meanwhile, so that the other tile's place is free.
TileCounts FastTiles::draw_lists(DepthTile& tile, std::span<const TileList> lists) {
    int triangles = 0;
    for (const TileList& list : lists) triangles += static_cast<int>(list.indices.size());
    if (triangles > 0) stores_.rows_at_once = (stores_.rows_left() + triangles - 1) / triangles;
    TileCounts counts;
    for (size_t k = 0; k < lists.size(); ++k)
        kernel_(state_, tile, lists[k].triangles->data.get(), lists[k].indices.data(), lists[k].indices.size(),
                static_cast<std::uint32_t>(k * most_triangles_of_a_list), stores_, counts);
    stores_.store(stores_.rows_left());
    return counts;
}

void FastTiles::count(const TileCounts& counts, PassCounters& counters) const {
    const Targets& targets = *draw_.targets;
    const std::int64_t depth_bytes = info(targets.depth->format()).bytes;
    const std::int64_t stencil_bytes = is_counting(state_.mode) ? info(targets.stencil->format()).bytes : 0;
    counters.fragments_covered += counts.covered;
    counters.fragments_passed += counts.passed;
    counters.bytes_read += counts.covered * ((state_.test == Compare::Always ? 0 : depth_bytes) + stencil_bytes);
    counters.bytes_written += (state_.write ? counts.passed * depth_bytes : 0) + counts.counted * stencil_bytes;
    if (state_.mode == ListMode::Ids) {
        counters.fragments_shaded += counts.passed;
        counters.bytes_written += counts.passed * color_bytes(draw_).written;
    }
}

} // namespace gnomon::detail
