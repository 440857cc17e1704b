// Bounds of the depths in the blocks of a tile, and what they decide; included once for each instruction set.

#if defined(GNOMON_DEPTH_BOUNDS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_DEPTH_BOUNDS_INL
#undef GNOMON_DEPTH_BOUNDS_INL
#else
#define GNOMON_DEPTH_BOUNDS_INL
#endif

#include "raster/depth_keys-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using BlockRow = hn::CappedTag<std::int32_t, tile_blocks>; // one integer for each block of a row, in one part or more
constexpr std::size_t row_lanes = hn::MaxLanes(BlockRow()), row_parts = tile_blocks / row_lanes;
using RowInt = hn::Vec<BlockRow>;

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

// The least and the greatest key of the triangle in each block of the row at y. Depth is monotonic along x and y,
// rounding and all, so its extremes over a block are at corners.
template <KeyKind kind>
HWY_NOINLINE void bound_depths(const DepthKeys<kind>& depth, int y, std::int32_t* low, std::int32_t* high) {
    const BlockRow blocks;
    const hn::CappedTag<double, row_lanes> d;
    constexpr std::size_t lanes = hn::MaxLanes(hn::CappedTag<double, row_lanes>());
    constexpr int last = block_side - 1;
    const auto bound = [&](bool upper, std::int32_t* out) {
        const double first = (((depth.dx > 0) == upper ? last : 0) + 0.5) - depth.anchor_x;
        const double up = (y + ((depth.dy > 0) == upper ? last : 0) + 0.5) - depth.anchor_y;
        const auto row = hn::Set(d, depth.value + depth.dy * up);
        alignas(64) std::int32_t keys[tile_blocks];
        const hn::Rebind<std::int32_t, hn::CappedTag<double, row_lanes>> narrow;
        for (std::size_t k = 0; k < tile_blocks; k += lanes) {
            const auto x = hn::Add(hn::Set(d, first), hn::Mul(hn::Iota(d, static_cast<double>(k)), hn::Set(d, 8.0)));
            const auto z = hn::Add(row, hn::Mul(hn::Set(d, depth.dx), x));
            hn::StoreU(to_key<kind>(z, depth.offset, depth.scale), narrow, keys + k);
        }
        for (std::size_t p = 0; p < tile_blocks; p += row_lanes)
            hn::StoreU(
                hn::Min(hn::Max(hn::LoadU(blocks, keys + p), hn::Set(blocks, depth.low)), hn::Set(blocks, depth.high)),
                blocks, out + p);
    };
    bound(false, low);
    bound(true, high);
}

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
