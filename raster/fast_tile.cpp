#include "raster/fast_tile.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include <emmintrin.h>

#include "raster/block_tests.h"

namespace gnomon::detail {
namespace {

constexpr size_t most_triangles_of_a_list = 1 << 16; // ids hold the list above and the triangle below

// The part of the tile inside the target.
struct Extent {
    int columns, rows;
    bool whole() const { return columns == tile_side && rows == tile_side; }
};

Extent extent_of(const Target& target, int level, int tile_x, int tile_y) {
    return {std::min(tile_side, target.width(level) - tile_x), std::min(tile_side, target.height(level) - tile_y)};
}

void load_depth(const Target& target, const Targets& targets, bool load, DepthTile& tile) {
    const Extent extent = extent_of(target, targets.level, tile.x, tile.y);
    tile.unknown = ~std::uint64_t{0}, tile.loose = 0;
    if (load && targets.clear_depth) {
        const auto key =
            static_cast<std::int32_t>(depth_key(target.format(), static_cast<double>(*targets.clear_depth)));
        std::fill_n(tile.depth, tile_pixels, key);
        std::fill_n(tile.nearest, tile_blocks * tile_blocks, key);
        std::fill_n(tile.farthest, tile_blocks * tile_blocks, key);
        tile.unknown = 0;
        return;
    }
    if (!extent.whole()) std::fill_n(tile.depth, tile_pixels, 0);
    for (int j = 0; j < extent.rows; ++j) {
        const std::byte* from = target.texel(tile.x, tile.y + j, targets.layer, targets.level);
        std::int32_t* to = tile.depth + j * tile_side;
        if (target.texel_bytes() == 4) {
            std::memcpy(to, from, static_cast<size_t>(extent.columns) * 4);
        } else {
            for (int i = 0; i < extent.columns; ++i) {
                std::uint16_t key;
                std::memcpy(&key, from + 2 * i, sizeof(key));
                to[i] = key;
            }
        }
    }
}

// Targets of this size are written past the caches, which they would only empty.
constexpr std::int64_t streamed_bytes = std::int64_t{8} << 20;

// One row of the tile, 256 bytes, both sides aligned to 64.
void stream_row(std::byte* to, const std::int32_t* from) {
    for (int k = 0; k < tile_side; k += 4)
        _mm_stream_si128(reinterpret_cast<__m128i*>(to + 4 * k),
                         _mm_load_si128(reinterpret_cast<const __m128i*>(from + k)));
}

void store_depth(Target& target, const Targets& targets, const DepthTile& tile) {
    const Extent extent = extent_of(target, targets.level, tile.x, tile.y);
    const bool stream = target.bytes() >= streamed_bytes;
    for (int j = 0; j < extent.rows; ++j) {
        std::byte* to = target.texel(tile.x, tile.y + j, targets.layer, targets.level);
        const std::int32_t* from = tile.depth + j * tile_side;
        if (stream && target.texel_bytes() == 4 && extent.columns == tile_side &&
            reinterpret_cast<std::uintptr_t>(to) % 64 == 0) {
            stream_row(to, from);
        } else if (target.texel_bytes() == 4) {
            std::memcpy(to, from, static_cast<size_t>(extent.columns) * 4);
        } else {
            for (int i = 0; i < extent.columns; ++i) {
                const auto key = static_cast<std::uint16_t>(from[i]);
                std::memcpy(to + 2 * i, &key, sizeof(key));
            }
        }
    }
    if (stream) _mm_sfence();
}

// Between a target's rows and the tile's blocks: visit(texels of the row, counters of the block's row, how many).
template <class T, class Visit>
void for_each_block_row(Target& target, const Targets& targets, const DepthTile& tile, T* counters,
                        const Visit& visit) {
    const Extent extent = extent_of(target, targets.level, tile.x, tile.y);
    for (int j = 0; j < extent.rows; ++j) {
        std::byte* row = target.texel(tile.x, tile.y + j, targets.layer, targets.level);
        for (int i = 0; i < extent.columns; i += block_side) {
            const int block = (j >> 3) * tile_blocks + (i >> 3);
            visit(row + static_cast<size_t>(i) * sizeof(T), counters + 64 * block + block_side * (j & 7),
                  std::min(block_side, extent.columns - i));
        }
    }
}

template <class T> void load_counters(Target& target, const Targets& targets, bool load, DepthTile& tile, T* counters) {
    if (load && targets.clear_stencil) {
        std::fill_n(counters, tile_pixels, static_cast<T>(*targets.clear_stencil));
        return;
    }
    for_each_block_row(target, targets, tile, counters, [](const std::byte* texels, T* block, int count) {
        std::memcpy(block, texels, static_cast<size_t>(count) * sizeof(T));
    });
}

template <class T>
void store_counters(Target& target, const Targets& targets, const DepthTile& tile, const T* counters) {
    for_each_block_row(target, targets, tile, counters, [](std::byte* texels, const T* block, int count) {
        std::memcpy(texels, block, static_cast<size_t>(count) * sizeof(T));
    });
}

// The load operations of targets that the tile does not hold.
void fill_others(const Targets& targets, const ListState& state, const DepthTile& tile) {
    const auto fill = [&](Target& target, const std::array<std::byte, 16>& texel) {
        const Extent extent = extent_of(target, targets.level, tile.x, tile.y);
        target.fill(tile.x, tile.y, extent.columns, extent.rows, targets.layer, targets.level, texel);
    };
    const bool counting = state.mode == ListMode::Count8 || state.mode == ListMode::Count32;
    if (targets.stencil && targets.clear_stencil && !counting)
        fill(*targets.stencil, targets.stencil->cleared_uint(*targets.clear_stencil));
    if (!targets.clear_color) return;
    for (Target* target : targets.color)
        if (target) fill(*target, target->cleared(*targets.clear_color));
}

// Runs the program for the visible fragments, block by block, a triangle of the block at a time.
void shade_visible(const TileDraw& draw, const DepthTile& tile, std::span<const TileList> lists,
                   PassCounters& counters) {
    BlockColors colors;
    FragmentBlock block;
    block.color = &colors;
    block.counters = &counters;
    const int layer = draw.targets->layer;
    for (int y = 0; y < tile_side; y += block_side)
        for (int x = 0; x < tile_side; x += block_side) {
            const std::uint32_t* ids = tile.id + y * tile_side + x;
            const auto id_at = [&](int bit) { return ids[(bit >> 3) * tile_side + (bit & 7)]; };
            std::uint64_t rest = 0;
            for (int bit = 0; bit < 64; ++bit) rest |= std::uint64_t{id_at(bit) != DepthTile::no_id} << bit;
            const std::uint64_t visible = rest;
            if (!visible) continue;
            block.x = tile.x + x, block.y = tile.y + y;
            while (rest) {
                const std::uint32_t id = id_at(std::countr_zero(rest));
                std::uint64_t same = 0;
                for_each_pixel(rest, [&](int bit) { same |= std::uint64_t{id_at(bit) == id} << bit; });
                rest &= ~same;
                const SetupTriangles& chunk = *lists[id / most_triangles_of_a_list].triangles;
                const SetupTriangle& triangle = chunk.data[id % most_triangles_of_a_list];
                AttributePlanes planes;
                if (draw.draw->varying_count > 0) planes = attribute_planes(draw, triangle, chunk.pieces.data());
                block.triangle = &triangle;
                block.attributes = draw.draw->varying_count > 0 ? &planes : nullptr;
                block.mask = same;
                Depths depth;
                draw.kernels->depth(triangle, block.x, block.y, same, depth.data());
                for_each_pixel(same, [&](int bit) {
                    block.depth[static_cast<size_t>(bit)] = static_cast<float>(depth[static_cast<size_t>(bit)]);
                });
                draw.draw->fragments(block, draw.varyings);
            }
            write_colors(draw, block.x, block.y, layer, visible, colors);
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

void draw_fast_tile(const TileDraw& draw, const ListState& state, int tile_x, int tile_y, bool load,
                    std::span<const TileList> lists, PassCounters& counters) {
    const Targets& targets = *draw.targets;
    DepthTile tile;
    tile.x = tile_x, tile.y = tile_y;
    load_depth(*targets.depth, targets, load, tile);
    if (load) fill_others(targets, state, tile);
    if (state.mode == ListMode::Ids) std::fill_n(tile.id, tile_pixels, DepthTile::no_id);
    if (state.mode == ListMode::Count8) load_counters(*targets.stencil, targets, load, tile, tile.count8);
    if (state.mode == ListMode::Count32) load_counters(*targets.stencil, targets, load, tile, tile.count32);

    TileCounts counts;
    const DrawList kernel = draw_list();
    for (size_t k = 0; k < lists.size(); ++k)
        kernel(state, tile, lists[k].triangles->data.get(), lists[k].indices.data(), lists[k].indices.size(),
               static_cast<std::uint32_t>(k * most_triangles_of_a_list), counts);

    if ((state.write && counts.passed) || (load && targets.clear_depth)) store_depth(*targets.depth, targets, tile);
    if (counts.counted || (load && targets.clear_stencil)) {
        if (state.mode == ListMode::Count8) store_counters(*targets.stencil, targets, tile, tile.count8);
        if (state.mode == ListMode::Count32) store_counters(*targets.stencil, targets, tile, tile.count32);
    }
    if (state.mode == ListMode::Ids && counts.passed) shade_visible(draw, tile, lists, counters);

    const std::int64_t depth_bytes = info(targets.depth->format()).bytes;
    const bool stencil = state.mode == ListMode::Count8 || state.mode == ListMode::Count32;
    const std::int64_t stencil_bytes = stencil ? info(targets.stencil->format()).bytes : 0;
    counters.fragments_covered += counts.covered;
    counters.fragments_passed += counts.passed;
    counters.bytes_read += counts.covered * ((state.test == Compare::Always ? 0 : depth_bytes) + stencil_bytes);
    counters.bytes_written += (state.write ? counts.passed * depth_bytes : 0) + counts.counted * stencil_bytes;
    if (state.mode == ListMode::Ids) {
        counters.fragments_shaded += counts.passed;
        counters.bytes_written += counts.passed * color_bytes(draw).written;
    }
}

} // namespace gnomon::detail
