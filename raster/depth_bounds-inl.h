// Bounds of the depths in the blocks of a tile, and what they decide; included once for each instruction set.

#if defined(GNOMON_DEPTH_BOUNDS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_DEPTH_BOUNDS_INL
#undef GNOMON_DEPTH_BOUNDS_INL
#else
#define GNOMON_DEPTH_BOUNDS_INL
#endif

#include <cmath>

#include "raster/depth_keys-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using BlockRow = hn::CappedTag<std::int32_t, tile_blocks>; // one integer for each block of a row, in one part or more
constexpr std::size_t row_lanes = hn::MaxLanes(BlockRow()), row_parts = tile_blocks / row_lanes;
using RowInt = hn::Vec<BlockRow>;

// Middles of a row of blocks.
struct BlockMiddles {
    alignas(64) double x[tile_blocks];
    constexpr BlockMiddles() : x() {
        for (std::size_t k = 0; k < tile_blocks; ++k) x[k] = block_side * (static_cast<double>(k) + 0.5);
    }
};
constexpr BlockMiddles block_middles;

// Blocks of a row, as bits, in which depths in [low, high] all pass, or none, against stored ones in [nearest,
// farthest].
struct Verdicts {
    std::uint32_t all = 0, none = 0;
};

HWY_INLINE Verdicts judge(Compare test, const std::int32_t* low, const std::int32_t* high, const std::int32_t* nearest,
                          const std::int32_t* farthest) {
    const BlockRow i;
    const auto below = [&](const std::int32_t* a, const std::int32_t* b) { // a < b, per block
        std::uint32_t bits = 0;
        for (std::size_t p = 0; p < row_parts; ++p)
            bits |= static_cast<std::uint32_t>(
                bits_of(i, hn::Lt(hn::LoadU(i, a + p * row_lanes), hn::LoadU(i, b + p * row_lanes)))
                << (p * row_lanes));
        return bits;
    };
    constexpr std::uint32_t every = 0xff;
    switch (test) {
    case Compare::Less:
        return {below(high, nearest), every & ~below(low, farthest)};
    case Compare::LessEqual:
        return {every & ~below(nearest, high), below(farthest, low)};
    case Compare::Greater:
        return {below(farthest, low), every & ~below(nearest, high)};
    case Compare::GreaterEqual:
        return {every & ~below(low, farthest), below(high, nearest)};
    case Compare::Equal:
        return {0, below(high, nearest) | below(farthest, low)};
    case Compare::NotEqual:
        return {below(high, nearest) | below(farthest, low), 0};
    case Compare::Always:
        return {every, 0};
    case Compare::Never:
        break;
    }
    return {0, every};
}

// Bounds of the triangle's keys in each block of a row of blocks: the depth in a block's middle, give or take how much
// the plane rises over half of it, and what doubles round.
template <KeyKind kind> struct BlockDepths {
    using Row = hn::CappedTag<double, row_lanes>;
    static constexpr std::size_t parts = tile_blocks / hn::MaxLanes(Row());
    hn::Vec<Row> right[parts]; // in the middles of the blocks: dx·(x − x0)
    double half;

    HWY_INLINE explicit BlockDepths(const DepthKeys<kind>& depth) {
        const Row d;
        constexpr double middle = 0.5 * block_side;
        for (std::size_t p = 0; p < parts; ++p) {
            const auto x = hn::Sub(hn::Load(d, block_middles.x + p * hn::MaxLanes(d)), hn::Set(d, depth.anchor_x));
            right[p] = hn::Mul(hn::Set(d, depth.dx), x);
        }
        // Distances to the anchor are below 2¹⁶ pixels, so that 2⁻²⁰ of the rise over half a block is more than is
        // rounded of products with dx and dy, here and for the keys; of the rest, 2⁻⁵⁰ is more.
        half = (middle - 0.5) * (std::abs(depth.dx) + std::abs(depth.dy)) * (1.0 + 0x1p-20) +
               (1.0 + std::abs(depth.value)) * 0x1p-50;
    }
    HWY_INLINE void bound(const DepthKeys<kind>& depth, int y, std::int32_t* low, std::int32_t* high) const {
        const Row d;
        const BlockRow i;
        const hn::Rebind<std::int32_t, Row> narrow;
        const auto row = hn::Set(d, depth.value + depth.dy * (y + 0.5 * block_side - depth.anchor_y));
        alignas(64) std::int32_t keys[2][tile_blocks];
        for (std::size_t p = 0; p < parts; ++p) {
            const auto z = hn::Add(row, right[p]);
            const auto key = [&](auto v) HWY_ATTR { return to_key<kind>(v, depth.offset, depth.scale); };
            hn::Store(key(hn::Sub(z, hn::Set(d, half))), narrow, keys[0] + p * hn::MaxLanes(d));
            hn::Store(key(hn::Add(z, hn::Set(d, half))), narrow, keys[1] + p * hn::MaxLanes(d));
        }
        const auto clamped = [&](const std::int32_t* key) HWY_ATTR {
            return hn::Min(hn::Max(hn::Load(i, key), hn::Set(i, depth.low)), hn::Set(i, depth.high));
        };
        for (std::size_t p = 0; p < tile_blocks; p += row_lanes) {
            hn::Store(clamped(keys[0] + p), i, low + p);
            hn::Store(clamped(keys[1] + p), i, high + p);
        }
    }
};

// Makes a block's depth bounds anew.
void refresh_bounds(DepthTile& tile, int block) {
    const Ints i;
    const std::int32_t* at = tile.depth + block_pixels * static_cast<std::size_t>(block);
    Int low = hn::Load(i, at), high = low;
    for (std::size_t p = int_lanes; p < block_pixels; p += int_lanes) {
        const Int stored = hn::Load(i, at + p);
        low = hn::Min(low, stored);
        high = hn::Max(high, stored);
    }
    tile.nearest[block] = hn::GetLane(hn::MinOfLanes(i, low));
    tile.farthest[block] = hn::GetLane(hn::MaxOfLanes(i, high));
    tile.unknown &= ~(std::uint64_t{1} << block);
    tile.loose &= ~(std::uint64_t{1} << block);
}

// Brings the bounds of some blocks of row r to where they can decide: unknown ones always, loose ones where the
// triangle lies behind (in front, for reversed depth) all that was drawn there since they were exact.
HWY_INLINE void prepare_bounds(const ListState& state, DepthTile& tile, int r, std::uint32_t blocks,
                               const std::int32_t* low, const std::int32_t* high) {
    const auto unknown = static_cast<std::uint32_t>(tile.unknown >> (tile_blocks * r)) & blocks;
    const auto loose = static_cast<std::uint32_t>(tile.loose >> (tile_blocks * r)) & blocks & ~unknown;
    if (!(unknown | loose)) return;
    std::uint32_t stale = unknown;
    const bool less = state.test == Compare::Less || state.test == Compare::LessEqual;
    for (std::uint32_t rest = loose; rest; rest &= rest - 1) {
        const auto c = static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero32(rest));
        const std::int32_t drawn = tile.drawn[r * tile_blocks + c];
        if (less ? low[c] >= drawn : high[c] <= drawn) stale |= 1u << c;
    }
    for (; stale; stale &= stale - 1)
        refresh_bounds(tile, r * tile_blocks + static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero32(stale)));
}

// Keeps the bounds true after a write to a part of the block.
HWY_INLINE void loosen_bounds(const ListState& state, DepthTile& tile, int block, std::int32_t low, std::int32_t high) {
    const bool less = state.test == Compare::Less || state.test == Compare::LessEqual;
    const bool greater = state.test == Compare::Greater || state.test == Compare::GreaterEqual;
    const bool fresh = !(tile.loose >> block & 1);
    if (!greater) tile.nearest[block] = least(tile.nearest[block], low);
    if (!less) tile.farthest[block] = most(tile.farthest[block], high);
    const std::int32_t reached = less ? high : low;
    tile.drawn[block] = fresh ? reached : less ? most(tile.drawn[block], reached) : least(tile.drawn[block], reached);
    tile.loose |= std::uint64_t{1} << block;
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
