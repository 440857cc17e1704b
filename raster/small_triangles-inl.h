// Small triangles through a tile, row by row; included once for each instruction set.

#if defined(GNOMON_SMALL_TRIANGLES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_SMALL_TRIANGLES_INL
#undef GNOMON_SMALL_TRIANGLES_INL
#else
#define GNOMON_SMALL_TRIANGLES_INL
#endif

#include "raster/depth_keys-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Edge functions of a small triangle at a pixel centre of its box, like TileEdges: 32 bits hold them there.
struct SmallEdges {
    alignas(16) std::int32_t base[4], a[4], b[4];

    HWY_INLINE SmallEdges(const SetupTriangle& t, bool conservative, int x, int y) {
#if HWY_TARGET == HWY_SCALAR
        for (int e = 0; e < 3; ++e) {
            a[e] = t.y[e] - t.y[e + 1], b[e] = t.x[e + 1] - t.x[e];
            const bool inclusive = a[e] > 0 || (a[e] == 0 && b[e] > 0);
            std::int32_t value =
                a[e] * (x * 256 + 128 - t.x[e]) + b[e] * (y * 256 + 128 - t.y[e]) - (inclusive ? 0 : 1);
            if (conservative) value += 128 * ((a[e] < 0 ? -a[e] : a[e]) + (b[e] < 0 ? -b[e] : b[e]));
            base[e] = value >> 8;
        }
#else
        const hn::FixedTag<std::int32_t, 4> q; // the same for three edges at once
        const auto px = hn::LoadU(q, t.x), py = hn::LoadU(q, t.y);
        const auto next_x = hn::Shuffle0321(px), next_y = hn::Shuffle0321(py); // [3] repeats [0]
        const auto step_x = hn::Sub(py, next_y), step_y = hn::Sub(next_x, px), zero = hn::Zero(q);
        auto e = hn::Add(hn::Mul(step_x, hn::Sub(hn::Set(q, x * 256 + 128), px)),
                         hn::Mul(step_y, hn::Sub(hn::Set(q, y * 256 + 128), py)));
        const auto inclusive = hn::Or(hn::Gt(step_x, zero), hn::And(hn::Eq(step_x, zero), hn::Gt(step_y, zero)));
        e = hn::Sub(e, hn::IfThenZeroElse(inclusive, hn::Set(q, 1)));
        if (conservative) e = hn::Add(e, hn::ShiftLeft<7>(hn::Add(hn::Abs(step_x), hn::Abs(step_y))));
        hn::Store(hn::ShiftRight<8>(e), q, base);
        hn::Store(step_x, q, a);
        hn::Store(step_y, q, b);
#endif
    }
};

// Bits of the blocks that the box touches.
HWY_INLINE std::uint64_t blocks_of(const LocalBox& box) {
    const int c0 = box.x0 >> 3, c1 = box.x1 >> 3, r0 = box.y0 >> 3, r1 = box.y1 >> 3;
    const std::uint64_t columns = (std::uint64_t{2} << c1) - (std::uint64_t{1} << c0);
    const std::uint64_t rows = (~std::uint64_t{0} >> (8 * (7 - r1))) & (~std::uint64_t{0} << (8 * r0));
    return (columns * 0x0101010101010101ull) & rows;
}

// Row by row, eight pixels at a step, without asking any bounds.
template <bool with_ids, bool floats, bool less>
HWY_NOINLINE void draw_small(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box,
                             std::uint32_t id, TileCounts& counts) {
    const Ints i;
    DepthKeys depth(t, state.key_scale);
    std::uint64_t covered = 0, passed = 0;
    Int value[3][int_parts];
    std::int32_t up[3];
    const auto start = [&](int x, int y) {
        depth.set_columns(tile.x + x);
        const SmallEdges edges(t, state.conservative, tile.x + x, tile.y + y);
        for (int e = 0; e < 3; ++e) {
            up[e] = edges.b[e];
            for (std::size_t p = 0; p < int_parts; ++p) {
                const auto lane = hn::Iota(i, static_cast<std::int32_t>(p * int_lanes));
                value[e][p] = hn::Add(hn::Set(i, edges.base[e]), hn::Mul(lane, hn::Set(i, edges.a[e])));
            }
        }
    };
    // Row j of the box from x on; `beyond` is negative where there is no such row.
    const auto draw_row = [&](int x, int j, int beyond) {
        for (std::size_t p = 0; p < int_parts; ++p) {
            const auto lane = hn::Iota(i, static_cast<std::int32_t>(p * int_lanes));
            const Int outside = hn::Or(hn::Or(value[0][p], value[1][p]), hn::Or(value[2][p], hn::Set(i, beyond)));
            const Lanes inside = hn::And(hn::Gt(outside, hn::Set(i, -1)), hn::Lt(lane, hn::Set(i, box.x1 - x + 1)));
            for (int e = 0; e < 3; ++e) value[e][p] = hn::Add(value[e][p], hn::Set(i, up[e]));
            const std::size_t at = static_cast<std::size_t>((box.y0 + j) * tile_side + x) + p * int_lanes;
            const Int fresh = depth.at<floats>(j, p);
            const Lanes pass = hn::And(passes<less>(state.test, fresh, hn::LoadU(i, tile.depth + at)), inside);
            if (state.write) hn::BlendedStore(fresh, pass, i, tile.depth + at);
            if constexpr (with_ids)
                hn::BlendedStore(hn::Set(i, static_cast<std::int32_t>(id)), pass, i,
                                 reinterpret_cast<std::int32_t*>(tile.id) + at);
            covered += hn::CountTrue(i, inside);
            passed += hn::CountTrue(i, pass);
        }
    };
    const int last = box.y1 - box.y0;
    constexpr int few = 4; // rows, drawn without asking how many there are
    if (last < few && box.x1 - box.x0 < block_side) {
        depth.set_rows(tile.y + box.y0, few);
        start(box.x0, box.y0);
        for (int j = 0; j < few; ++j) draw_row(box.x0, j, last - j);
    } else {
        depth.set_rows(tile.y + box.y0, static_cast<std::size_t>(last + 1));
        for (int x = box.x0; x <= box.x1; x += block_side) {
            start(x, box.y0);
            for (int j = 0; j <= last; ++j) draw_row(x, j, 0);
        }
    }
    counts.covered += static_cast<std::int64_t>(covered);
    counts.passed += static_cast<std::int64_t>(passed);
    if (state.write && passed) tile.unknown |= blocks_of(box);
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
