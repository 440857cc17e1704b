// Blocks of 8×8 pixels of a tile: coverage, depth and stencil counts; included once for each instruction set.

#if defined(GNOMON_BLOCKS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_BLOCKS_INL
#undef GNOMON_BLOCKS_INL
#else
#define GNOMON_BLOCKS_INL
#endif

#include "raster/depth_bounds-inl.h"
#include "raster/stencil_counts-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// What the block path needs of a triangle's edges: per block, and per pixel of a block.
struct BlockEdges {
    TileEdges edges;
    RowInt most_inside[3][row_parts],
        least_inside[3][row_parts]; // of the edge functions in each block of the lowest row
    static constexpr std::size_t ramp_parts = block_pixels / int_lanes;
    Int ramp[3][ramp_parts]; // from a block's lower left pixel to each of its pixels

    HWY_INLINE explicit BlockEdges(const TileEdges& e) : edges(e) {
        const Ints i;
        const BlockRow blocks;
        constexpr std::int32_t span = block_side - 1;
        for (int k = 0; k < 3; ++k) {
            const std::int32_t a = e.a[k], b = e.b[k];
            for (std::size_t p = 0; p < row_parts; ++p) {
                const auto block = hn::Iota(blocks, static_cast<std::int32_t>(p * row_lanes));
                const auto corner =
                    hn::Add(hn::Set(blocks, e.base[k]), hn::Mul(block, hn::Set(blocks, a * block_side)));
                most_inside[k][p] = hn::Add(corner, hn::Set(blocks, span * (most(a, 0) + most(b, 0))));
                least_inside[k][p] = hn::Add(corner, hn::Set(blocks, span * (least(a, 0) + least(b, 0))));
            }
            const auto right = hn::Set(i, a * patch_side), up = hn::Set(i, b * patch_side);
            for (std::size_t p = 0; p < int_parts; ++p) {
                const auto x = hn::Mul(hn::Load(i, patch_places<std::int32_t>.x + p * int_lanes), hn::Set(i, a));
                const auto y = hn::Mul(hn::Load(i, patch_places<std::int32_t>.y + p * int_lanes), hn::Set(i, b));
                ramp[k][p] = hn::Add(x, y);
                ramp[k][int_parts + p] = hn::Add(ramp[k][p], right);
                ramp[k][2 * int_parts + p] = hn::Add(ramp[k][p], up);
                ramp[k][3 * int_parts + p] = hn::Add(ramp[k][int_parts + p], up);
            }
        }
    }

    // Of the blocks of the row at y: those that the edges touch, and those that one of them crosses.
    struct Row {
        std::uint32_t touched = 0xff, crossed = 0;
    };
    HWY_INLINE Row row(int y) const {
        const BlockRow i;
        Row row;
        for (std::size_t p = 0; p < row_parts; ++p) {
            auto outside = hn::Zero(i), partly = outside; // where negative
            for (int k = 0; k < 3; ++k) {
                const auto up = hn::Set(i, edges.b[k] * y);
                outside = hn::Or(outside, hn::Add(most_inside[k][p], up));
                partly = hn::Or(partly, hn::Add(least_inside[k][p], up));
            }
            const auto negative = [&](RowInt v) HWY_ATTR {
                return static_cast<std::uint32_t>(bits_of(i, hn::Lt(v, hn::Zero(i))) << (p * row_lanes));
            };
            row.touched &= ~negative(outside);
            row.crossed |= negative(partly);
        }
        return row;
    }

    // Pixels of the block at (x, y) inside all edges.
    HWY_INLINE std::uint64_t covered(int x, int y) const {
        const Ints i;
        Int corner[3];
        for (int k = 0; k < 3; ++k) corner[k] = hn::Set(i, edges.base[k] + edges.a[k] * x + edges.b[k] * y);
        std::uint64_t outside = 0;
        for (std::size_t p = 0; p < ramp_parts; ++p) {
            const auto value = [&](std::size_t k) HWY_ATTR { return hn::Add(corner[k], ramp[k][p]); };
            const auto any = hn::Or3(value(0), value(1), value(2)); // negative where one of them is
            outside |= bits_of(i, hn::Lt(any, hn::Zero(i))) << (p * int_lanes);
        }
        return ~outside;
    }
};

// Depth test, or with `all` only the write, of the covered pixels of one block; returns those that pass.
template <bool with_ids, KeyKind kind, bool usual>
HWY_NOINLINE std::uint64_t test_block(const ListState& state, DepthTile& tile, const DepthKeys<kind>& depth, int x,
                                      int y, std::uint64_t covered, bool all, std::uint32_t id) {
    const Ints i;
    const auto column = static_cast<std::size_t>(x / patch_side), row = static_cast<std::size_t>(y / patch_side);
    const typename DepthKeys<kind>::Columns columns[2] = {depth.columns(column), depth.columns(column + 1)};
    std::uint64_t passed = 0;
    const std::size_t block = place_in_tile(x, y);
    for (std::size_t up = 0; up < 2; ++up) {
        if (!(covered >> (32 * up) & 0xffffffffu)) continue;
        const auto rows = depth.rows(row + up);
        for (std::size_t right = 0; right < 2; ++right) {
            const std::size_t at = (2 * up + right) * patch_pixels;
            const std::uint64_t bits = covered >> at & 0xffff;
            if (!bits) continue;
            Lanes in[int_parts];
            for (std::size_t p = 0; p < int_parts; ++p) in[p] = mask_of(i, bits >> (p * int_lanes));
            Lanes pass[int_parts];
            test_patch<with_ids, usual, false, true>(state, tile, depth, columns[right], rows, block + at, in, all,
                                                     state.write, id, pass);
            passed |= patch_bits(pass) << at;
        }
    }
    return passed;
}

// Writes a block that is covered and passes throughout; its keys lie in [low, high].
template <bool with_ids, KeyKind kind>
HWY_NOINLINE void fill_block(DepthTile& tile, const DepthKeys<kind>& depth, int x, int y, std::int32_t low,
                             std::int32_t high, std::uint32_t id) {
    const Ints i;
    std::size_t at = place_in_tile(x, y);
    const auto fill = [&](const Int& key) {
        hn::Store(key, i, tile.depth + at);
        if constexpr (with_ids)
            hn::Store(hn::Set(i, static_cast<std::int32_t>(id)), i, reinterpret_cast<std::int32_t*>(tile.id) + at);
        at += int_lanes;
    };
    if (low == high) {
        const auto constant = hn::Set(i, low);
        for (std::size_t p = 0; p < block_pixels / int_lanes; ++p) fill(constant);
        return;
    }
    const auto column = static_cast<std::size_t>(x / patch_side), row = static_cast<std::size_t>(y / patch_side);
    const typename DepthKeys<kind>::Columns columns[2] = {depth.columns(column), depth.columns(column + 1)};
    const bool clamped = low <= depth.low || high >= depth.high;
    for (std::size_t up = 0; up < 2; ++up) {
        const auto rows = depth.rows(row + up);
        for (std::size_t right = 0; right < 2; ++right)
            for (std::size_t p = 0; p < int_parts; ++p)
                fill(clamped ? depth.at(columns[right], rows, p) : depth.unclamped(columns[right], rows, p));
    }
}

// Pixels of a block in columns from c on, up to c, and so for rows.
struct BlockMasks {
    std::uint64_t from_column[8] = {}, to_column[8] = {}, from_row[8] = {}, to_row[8] = {};
    constexpr BlockMasks() {
        for (int y = 0; y < block_side; ++y)
            for (int x = 0; x < block_side; ++x) {
                const std::uint64_t bit = std::uint64_t{1} << place_in_block(x, y);
                for (int k = 0; k < block_side; ++k) {
                    from_column[k] |= x >= k ? bit : 0, to_column[k] |= x <= k ? bit : 0;
                    from_row[k] |= y >= k ? bit : 0, to_row[k] |= y <= k ? bit : 0;
                }
            }
    }
};
constexpr BlockMasks block_masks;

// Pixels of the block at (x, y) that lie in the box, which the block touches.
HWY_INLINE std::uint64_t box_pixels(const LocalBox& box, int x, int y) {
    return block_masks.from_column[most(box.x0 - x, 0)] & block_masks.to_column[least(box.x1 - x, 7)] &
           block_masks.from_row[most(box.y0 - y, 0)] & block_masks.to_row[least(box.y1 - y, 7)];
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
