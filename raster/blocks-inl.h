// Blocks of 8×8 pixels of a tile: coverage, depth and stencil counts; included once for each instruction set.

#if defined(GNOMON_BLOCKS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_BLOCKS_INL
#undef GNOMON_BLOCKS_INL
#else
#define GNOMON_BLOCKS_INL
#endif

#include "raster/depth_keys-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// What the block path needs of a triangle's edges: per block, and per pixel of a block.
struct BlockEdges {
    static constexpr std::size_t pixel_lanes = hn::MaxLanes(hn::CappedTag<std::int32_t, 16>());
    using Pixels = hn::CappedTag<std::int32_t, 16>; // two rows of a block at once, where there are so many lanes
    TileEdges edges;
    Int most_inside[3][int_parts], least_inside[3][int_parts]; // of the edge functions in each block of the lowest row
    hn::Vec<Pixels> ramp[3];                                   // from the block's lower left pixel

    HWY_INLINE explicit BlockEdges(const TileEdges& e) : edges(e) {
        const Ints i;
        const Pixels pixels;
        constexpr std::int32_t span = block_side - 1;
        const auto lane = hn::Iota(pixels, 0);
        for (int k = 0; k < 3; ++k) {
            const std::int32_t a = e.a[k], b = e.b[k];
            for (std::size_t p = 0; p < int_parts; ++p) {
                const auto block = hn::Iota(i, static_cast<std::int32_t>(p * int_lanes));
                const auto corner = hn::Add(hn::Set(i, e.base[k]), hn::Mul(block, hn::Set(i, a * block_side)));
                most_inside[k][p] = hn::Add(corner, hn::Set(i, span * (most(a, 0) + most(b, 0))));
                least_inside[k][p] = hn::Add(corner, hn::Set(i, span * (least(a, 0) + least(b, 0))));
            }
            ramp[k] = hn::Add(hn::Mul(hn::And(lane, hn::Set(pixels, 7)), hn::Set(pixels, a)),
                              hn::Mul(hn::ShiftRight<3>(lane), hn::Set(pixels, b)));
        }
    }

    // Of the blocks of the row at y: those that the edges touch, and for each edge those that it crosses.
    struct Row {
        std::uint32_t touched = 0xff, crossed[3] = {0, 0, 0};
    };
    HWY_INLINE Row row(int y) const {
        const Ints i;
        Row row;
        for (std::size_t p = 0; p < int_parts; ++p) {
            auto outside = hn::Zero(i);
            for (int k = 0; k < 3; ++k) {
                const auto up = hn::Set(i, edges.b[k] * y);
                outside = hn::Or(outside, hn::Add(most_inside[k][p], up));
                const auto partly = hn::Lt(hn::Add(least_inside[k][p], up), hn::Zero(i));
                row.crossed[k] |= static_cast<std::uint32_t>(bits_of(i, partly) << (p * int_lanes));
            }
            row.touched &= ~static_cast<std::uint32_t>(bits_of(i, hn::Lt(outside, hn::Zero(i))) << (p * int_lanes));
        }
        return row;
    }

    // Pixels of the block at (x, y) inside those edges that cross it.
    HWY_INLINE std::uint64_t covered(const Row& row, int column, int y) const {
        const Pixels pixels;
        std::uint64_t outside = 0;
        for (int k = 0; k < 3; ++k) {
            if (!(row.crossed[k] >> column & 1)) continue;
            std::int32_t corner = edges.base[k] + edges.a[k] * column * block_side + edges.b[k] * y;
            for (std::size_t at = 0; at < 64; at += pixel_lanes) {
                const std::int32_t first = corner + edges.b[k] * static_cast<std::int32_t>(at >> 3) +
                                           edges.a[k] * static_cast<std::int32_t>(at & 7);
                const auto value = hn::Add(ramp[k], hn::Set(pixels, first));
                outside |= bits_of(pixels, hn::Lt(value, hn::Zero(pixels))) << at;
            }
        }
        return ~outside;
    }
};

// Depth test, or with `all` only the write, of the covered pixels of one block; returns those that pass.
template <bool with_ids, bool floats, bool less>
HWY_NOINLINE std::uint64_t test_block(const ListState& state, DepthTile& tile, DepthKeys& depth, int x, int y,
                                      std::uint64_t covered, bool all, std::uint32_t id) {
    const Ints i;
    depth.set_columns(tile.x + x);
    std::uint64_t passed = 0;
    for (int j = 0; j < block_side; ++j) {
        const std::uint64_t row_bits = covered >> (8 * j) & 0xff;
        if (row_bits == 0) continue;
        for (std::size_t p = 0; p < int_parts; ++p) {
            std::int32_t* at = tile.depth + (y + j) * tile_side + x + p * int_lanes;
            const Int fresh = depth.at<floats>(j, p);
            Lanes pass = mask_of(i, row_bits >> (p * int_lanes));
            if (!all) pass = hn::And(pass, passes<less>(state.test, fresh, hn::LoadU(i, at)));
            if (state.write) hn::BlendedStore(fresh, pass, i, at);
            if constexpr (with_ids)
                hn::BlendedStore(hn::Set(i, static_cast<std::int32_t>(id)), pass, i,
                                 reinterpret_cast<std::int32_t*>(tile.id) + (at - tile.depth));
            passed |= bits_of(i, pass) << (static_cast<std::size_t>(8 * j) + p * int_lanes);
        }
    }
    return passed;
}

// Writes a block that is covered and passes throughout; its keys lie in [low, high].
template <bool with_ids, bool floats>
HWY_NOINLINE void fill_block(DepthTile& tile, DepthKeys& depth, int x, int y, std::int32_t low, std::int32_t high,
                             std::uint32_t id) {
    const Ints i;
    const auto fill = [&](const auto& key) {
        std::int32_t* at = tile.depth + y * tile_side + x;
        for (int j = 0; j < block_side; ++j, at += tile_side)
            for (std::size_t p = 0; p < int_parts; ++p) {
                hn::StoreU(key(j, p), i, at + p * int_lanes);
                if constexpr (with_ids)
                    hn::StoreU(hn::Set(i, static_cast<std::int32_t>(id)), i,
                               reinterpret_cast<std::int32_t*>(tile.id) + (at - tile.depth) + p * int_lanes);
            }
    };
    if (low == high) {
        const auto constant = hn::Set(i, low);
        return fill([&](int, std::size_t) { return constant; });
    }
    depth.set_columns(tile.x + x);
    if (low > depth.low && high < depth.high)
        fill([&](int j, std::size_t p) { return depth.unclamped<floats>(j, p); });
    else
        fill([&](int j, std::size_t p) { return depth.at<floats>(j, p); });
}

// Adds `step` to the counters of a block, modulo their range.
template <class T> HWY_INLINE void count_block(T* counters, std::uint64_t pixels, std::int8_t step) {
    const hn::CappedTag<T, 64> d;
    constexpr std::size_t lanes = hn::MaxLanes(d);
    const auto steps = hn::Set(d, static_cast<T>(step));
    for (std::size_t at = 0; at < 64; at += lanes) {
        const auto old = hn::LoadU(d, counters + at);
        std::uint8_t bits[8];
        const std::uint64_t part = pixels >> at;
        for (std::size_t k = 0; k < 8; ++k) bits[k] = static_cast<std::uint8_t>(part >> (8 * k));
        hn::StoreU(hn::Add(old, hn::IfThenElseZero(hn::LoadMaskBits(d, bits), steps)), d, counters + at);
    }
}

HWY_INLINE int bit_count(std::uint64_t bits) { return static_cast<int>(hwy::PopCount(bits)); }

// Pixels of the block at (x, y) that lie in the box.
HWY_INLINE std::uint64_t box_pixels(const LocalBox& box, int x, int y) {
    const int x0 = most(box.x0 - x, 0), x1 = least(box.x1 - x, 7), y0 = most(box.y0 - y, 0), y1 = least(box.y1 - y, 7);
    const std::uint64_t row = (0xffull >> (7 - x1)) & (0xffull << x0) & 0xff;
    const std::uint64_t rows = (every_pixel >> (8 * (7 - y1))) & (every_pixel << (8 * y0));
    return (row * 0x0101010101010101ull) & rows;
}

// Adds what passed and what failed to the stencil.
template <ListMode mode>
HWY_INLINE void count_fragments(const ListState& state, DepthTile& tile, bool front, int block, std::uint64_t covered,
                                std::uint64_t passed, TileCounts& counts) {
    const auto update = [&](std::uint64_t pixels, std::int8_t step) {
        if (!step || !pixels) return;
        counts.counted += bit_count(pixels);
        if constexpr (mode == ListMode::Count8)
            count_block(tile.count8 + 64 * block, pixels, step);
        else
            count_block(tile.count32 + 64 * block, pixels, step);
    };
    update(passed, state.counts[front][1]);
    update(covered & ~passed, state.counts[front][0]);
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
