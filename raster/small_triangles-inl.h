// Small triangles through a tile, patch by patch; included once for each instruction set.

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

// Edge functions of a small triangle at the lower left pixel of a patch near it, like TileEdges, and their steps per
// pixel: integers below 2²⁴, so floats hold them and what is made of them exactly.
struct SmallEdges {
    alignas(16) float base[4], a[4], b[4];

    HWY_INLINE SmallEdges(const SetupTriangle& t, bool conservative, int x, int y) {
#if HWY_TARGET == HWY_SCALAR
        for (int e = 0; e < 3; ++e) {
            const std::int32_t step_x = t.y[e] - t.y[e + 1], step_y = t.x[e + 1] - t.x[e];
            const bool inclusive = step_x > 0 || (step_x == 0 && step_y > 0);
            std::int32_t value =
                step_x * (x * 256 + 128 - t.x[e]) + step_y * (y * 256 + 128 - t.y[e]) - (inclusive ? 0 : 1);
            if (conservative) value += 128 * ((step_x < 0 ? -step_x : step_x) + (step_y < 0 ? -step_y : step_y));
            base[e] = static_cast<float>(value >> 8);
            a[e] = static_cast<float>(step_x), b[e] = static_cast<float>(step_y);
        }
#else
        const hn::FixedTag<std::int32_t, 4> q; // the same for three edges at once
        const hn::FixedTag<float, 4> f;
        const auto px = hn::LoadU(q, t.x), py = hn::LoadU(q, t.y);
        const auto next_x = hn::Shuffle0321(px), next_y = hn::Shuffle0321(py); // [3] repeats [0]
        const auto step_x = hn::Sub(py, next_y), step_y = hn::Sub(next_x, px), zero = hn::Zero(q);
        auto e = hn::Add(hn::Mul(step_x, hn::Sub(hn::Set(q, x * 256 + 128), px)),
                         hn::Mul(step_y, hn::Sub(hn::Set(q, y * 256 + 128), py)));
        const auto inclusive = hn::Or(hn::Gt(step_x, zero), hn::And(hn::Eq(step_x, zero), hn::Gt(step_y, zero)));
        e = hn::Sub(e, hn::IfThenZeroElse(inclusive, hn::Set(q, 1)));
        if (conservative) e = hn::Add(e, hn::ShiftLeft<7>(hn::Add(hn::Abs(step_x), hn::Abs(step_y))));
        hn::Store(hn::ConvertTo(f, hn::ShiftRight<8>(e)), f, base);
        hn::Store(hn::ConvertTo(f, step_x), f, a);
        hn::Store(hn::ConvertTo(f, step_y), f, b);
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

// The edge functions of a triangle over one patch, and how to step to the next.
struct PatchEdges {
    using Floats = hn::CappedTag<float, patch_pixels>;
    using Float = hn::Vec<Floats>;
    Float value[3][int_parts], right[3], up[3];

    HWY_INLINE explicit PatchEdges(const SmallEdges& edges) {
        const Floats f;
        for (std::size_t e = 0; e < 3; ++e) {
            const auto a = hn::Set(f, edges.a[e]), b = hn::Set(f, edges.b[e]);
            right[e] = hn::Mul(a, hn::Set(f, static_cast<float>(patch_side)));
            up[e] = hn::Mul(b, hn::Set(f, static_cast<float>(patch_side)));
            for (std::size_t p = 0; p < int_parts; ++p) {
                const auto x = hn::Mul(a, hn::Load(f, patch_places<float>.x + p * int_lanes));
                const auto y = hn::Mul(b, hn::Load(f, patch_places<float>.y + p * int_lanes));
                value[e][p] = hn::Add(hn::Add(hn::Set(f, edges.base[e]), x), y);
            }
        }
    }
    HWY_INLINE void move(const Float* step) {
        for (std::size_t e = 0; e < 3; ++e)
            for (std::size_t p = 0; p < int_parts; ++p) value[e][p] = hn::Add(value[e][p], step[e]);
    }
    HWY_INLINE Lanes inside(std::size_t p) const {
        const Floats f;
        const auto least = hn::Min(hn::Min(value[0][p], value[1][p]), value[2][p]);
        return hn::RebindMask(Ints(), hn::Ge(least, hn::Zero(f)));
    }
};

// Patch by patch, without asking any bounds.
template <bool with_ids, KeyKind kind, bool less>
HWY_NOINLINE void draw_small(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box,
                             std::uint32_t id, TileCounts& counts) {
    const Ints i;
    const DepthKeys<kind> depth(t, state.key_scale);
    const int x0 = box.x0 & -patch_side, y0 = box.y0 & -patch_side;
    PatchEdges row_edges(SmallEdges(t, state.conservative, tile.x + x0, tile.y + y0));
    const auto first_columns = depth.columns(tile.x + x0);
    std::uint64_t covered = 0, passed = 0;
    for (int y = y0; y <= box.y1; y += patch_side) {
        const auto rows = depth.rows(tile.y + y);
        const std::uint32_t row_bits =
            (0xffffu >> (4 * most(y + 3 - box.y1, 0))) & (0xffffu << (4 * most(box.y0 - y, 0)));
        PatchEdges edges = row_edges;
        auto columns = first_columns;
        for (int x = x0;;) {
            const std::uint32_t column_bits =
                ((0xfu >> most(x + 3 - box.x1, 0)) & (0xfu << most(box.x0 - x, 0)) & 0xf) * 0x1111u;
            Lanes inside[int_parts];
            for (std::size_t p = 0; p < int_parts; ++p) {
                inside[p] = hn::And(edges.inside(p), mask_of(i, (row_bits & column_bits) >> (p * int_lanes)));
                covered += hwy::PopCount(bits_of(i, inside[p]));
            }
            const std::size_t at = place_in_tile(x, y);
            passed +=
                hwy::PopCount(test_patch<with_ids, less>(state, tile, depth, columns, rows, at, inside, false, id));
            x += patch_side;
            if (x > box.x1) break;
            edges.move(edges.right);
            columns = depth.columns(tile.x + x);
        }
        row_edges.move(row_edges.up);
    }
    counts.covered += static_cast<std::int64_t>(covered);
    counts.passed += static_cast<std::int64_t>(passed);
    if (state.write && passed) tile.unknown |= blocks_of(box);
}

// Patch by patch too, but asking first which patches of a row the triangle touches, and which it covers.
template <bool with_ids, KeyKind kind, bool less>
HWY_NOINLINE void draw_medium(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box,
                              std::uint32_t id, TileCounts& counts) {
    using Floats = PatchEdges::Floats; // the patches of a row, or the pixels of a patch
    static_assert(tile_side == patch_side * static_cast<int>(patch_pixels));
    const Ints i;
    const Floats f;
    const DepthKeys<kind> depth(t, state.key_scale);
    const int y0 = box.y0 & -patch_side, first = box.x0 / patch_side, last = box.x1 / patch_side;
    const SmallEdges at_tile(t, state.conservative, tile.x, tile.y + y0);
    PatchEdges edges(at_tile);
    hn::Vec<Floats> corner[3][int_parts], most_inside[3], least_inside[3];
    for (std::size_t e = 0; e < 3; ++e) {
        const auto a = hn::Set(f, at_tile.a[e]), b = hn::Set(f, at_tile.b[e]), zero = hn::Zero(f);
        const auto span = hn::Set(f, static_cast<float>(patch_side - 1));
        most_inside[e] = hn::Mul(span, hn::Add(hn::Max(a, zero), hn::Max(b, zero)));
        least_inside[e] = hn::Mul(span, hn::Add(hn::Min(a, zero), hn::Min(b, zero)));
        for (std::size_t p = 0; p < int_parts; ++p)
            corner[e][p] = hn::Add(hn::Set(f, at_tile.base[e]),
                                   hn::Mul(hn::Iota(f, static_cast<float>(p * int_lanes)), edges.right[e]));
    }
    const std::uint32_t box_columns = (2u << last) - (1u << first);
    const std::uint32_t left = ((0xfu << (box.x0 & 3)) & 0xf) * 0x1111u, right = (0xfu >> (3 - (box.x1 & 3))) * 0x1111u;
    std::uint64_t covered = 0, passed = 0;
    for (int y = y0; y <= box.y1; y += patch_side) {
        std::uint64_t touched = 0, whole = 0;
        for (std::size_t p = 0; p < int_parts; ++p) {
            const auto at_least = [&](const hn::Vec<Floats>* offset) {
                const auto least = hn::Min(hn::Min(hn::Add(corner[0][p], offset[0]), hn::Add(corner[1][p], offset[1])),
                                           hn::Add(corner[2][p], offset[2]));
                return bits_of(f, hn::Ge(least, hn::Zero(f))) << (p * int_lanes);
            };
            touched |= at_least(most_inside), whole |= at_least(least_inside);
            for (std::size_t e = 0; e < 3; ++e) corner[e][p] = hn::Add(corner[e][p], edges.up[e]);
        }
        const auto rows = depth.rows(tile.y + y);
        const std::uint32_t row_bits =
            (0xffffu >> (4 * most(y + 3 - box.y1, 0))) & (0xffffu << (4 * most(box.y0 - y, 0)));
        for (auto rest = static_cast<std::uint32_t>(touched) & box_columns; rest; rest &= rest - 1) {
            const int n = static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero32(rest)), x = n * patch_side;
            const std::uint32_t bits = row_bits & (n == first ? left : 0xffffu) & (n == last ? right : 0xffffu);
            Lanes inside[int_parts];
            for (std::size_t p = 0; p < int_parts; ++p) {
                inside[p] = mask_of(i, bits >> (p * int_lanes));
                if (!(whole >> n & 1)) {
                    const auto column = hn::Set(f, static_cast<float>(n));
                    auto least = hn::Add(edges.value[0][p], hn::Mul(column, edges.right[0]));
                    for (std::size_t e = 1; e < 3; ++e)
                        least = hn::Min(least, hn::Add(edges.value[e][p], hn::Mul(column, edges.right[e])));
                    inside[p] = hn::And(inside[p], hn::RebindMask(i, hn::Ge(least, hn::Zero(f))));
                }
                covered += hwy::PopCount(bits_of(i, inside[p]));
            }
            passed += hwy::PopCount(test_patch<with_ids, less>(state, tile, depth, depth.columns(tile.x + x), rows,
                                                               place_in_tile(x, y), inside, false, id));
        }
        edges.move(edges.up);
    }
    counts.covered += static_cast<std::int64_t>(covered);
    counts.passed += static_cast<std::int64_t>(passed);
    if (state.write && passed) tile.unknown |= blocks_of(box);
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
