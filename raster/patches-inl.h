// Triangles through a tile, patch by patch: small ones, and large ones that cover it in part; included once for each
// instruction set.

#if defined(GNOMON_PATCHES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_PATCHES_INL
#undef GNOMON_PATCHES_INL
#else
#define GNOMON_PATCHES_INL
#endif

#include <type_traits>

#include "raster/stencil_counts-inl.h"

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

// First pixel of each column of patches.
template <class T> struct PatchColumns {
    alignas(64) T first_pixel[patch_pixels] = {};
    constexpr PatchColumns() {
        for (std::size_t n = 0; n < patch_pixels; ++n) first_pixel[n] = static_cast<T>(patch_side * n);
    }
};
template <class T> constexpr PatchColumns<T> patch_columns;

// Bits of the blocks that the box touches.
HWY_INLINE std::uint64_t blocks_of(const LocalBox& box) {
    const int c0 = box.x0 >> 3, c1 = box.x1 >> 3, r0 = box.y0 >> 3, r1 = box.y1 >> 3;
    const std::uint64_t columns = (std::uint64_t{2} << c1) - (std::uint64_t{1} << c0);
    const std::uint64_t rows = (~std::uint64_t{0} >> (8 * (7 - r1))) & (~std::uint64_t{0} << (8 * r0));
    return (columns * 0x0101010101010101ull) & rows;
}

template <class V> HWY_INLINE auto nonnegative(V v) {
    const hn::DFromV<V> d;
    if constexpr (std::is_integral_v<hn::TFromV<V>>)
        return hn::Gt(v, hn::Set(d, -1));
    else
        return hn::Ge(v, hn::Zero(d));
}

// The edge functions of a small triangle over one patch.
struct PatchEdges {
    using Lane = hn::CappedTag<float, patch_pixels>;
    using Values = hn::Vec<Lane>;
    Values value[3][int_parts], right[3], up[3]; // `right` and `up`: the step to the next patch

    HWY_INLINE explicit PatchEdges(const SmallEdges& small) {
        const Lane d;
        for (std::size_t e = 0; e < 3; ++e) {
            const auto right_step = hn::Set(d, small.a[e]), up_step = hn::Set(d, small.b[e]);
            right[e] = hn::Mul(right_step, hn::Set(d, float{patch_side}));
            up[e] = hn::Mul(up_step, hn::Set(d, float{patch_side}));
            for (std::size_t p = 0; p < int_parts; ++p) {
                const auto x = hn::Mul(right_step, hn::Load(d, patch_places<float>.x + p * int_lanes));
                const auto y = hn::Mul(up_step, hn::Load(d, patch_places<float>.y + p * int_lanes));
                value[e][p] = hn::Add(hn::Add(hn::Set(d, small.base[e]), x), y);
            }
        }
    }
    HWY_INLINE void move(const Values* step) {
        for (std::size_t e = 0; e < 3; ++e)
            for (std::size_t p = 0; p < int_parts; ++p) value[e][p] = hn::Add(value[e][p], step[e]);
    }
    HWY_INLINE Lanes inside(std::size_t p) const {
        return hn::RebindMask(Ints(), nonnegative(hn::Min(hn::Min(value[0][p], value[1][p]), value[2][p])));
    }
};

// Whether depth is written: in the usual state, known when compiling, unless there are counts.
template <ListMode mode, bool usual> HWY_INLINE bool writes(const ListState& state) {
    return usual ? !is_counting(mode) : state.write;
}

// Of a list's triangles. Patch by patch, pixels are counted in lanes of their own.
struct ListCounts : TileCounts {
    alignas(64) std::int32_t covered_lanes[patch_pixels] = {}, passed_lanes[patch_pixels] = {};

    void add_to(TileCounts& counts) const {
        counts.covered += covered, counts.passed += passed, counts.counted += counted;
        for (const std::int32_t lane : covered_lanes) counts.covered += lane;
        for (const std::int32_t lane : passed_lanes) counts.passed += lane;
    }
};

// What a triangle did in a tile.
struct DrawnPixels {
    Int covered[int_parts], passed[int_parts];

    HWY_INLINE DrawnPixels() {
        for (std::size_t p = 0; p < int_parts; ++p) covered[p] = passed[p] = hn::Zero(Ints());
    }
    static HWY_INLINE Int counted(Int count, Lanes lanes) {
        return hn::IfThenElse(lanes, hn::Add(count, hn::Set(Ints(), 1)), count);
    }
    template <ListMode mode, bool usual>
    HWY_INLINE void add_to(ListCounts& counts, const ListState& state, DepthTile& tile, const LocalBox& box) const {
        const Ints i;
        for (std::size_t p = 0; p < int_parts; ++p) {
            const std::size_t at = p * int_lanes;
            hn::Store(hn::Add(hn::Load(i, counts.covered_lanes + at), covered[p]), i, counts.covered_lanes + at);
            hn::Store(hn::Add(hn::Load(i, counts.passed_lanes + at), passed[p]), i, counts.passed_lanes + at);
        }
        if (writes<mode, usual>(state)) tile.unknown |= blocks_of(box);
    }
};

// Tests one patch and does what follows from it. With `whole`, all of its pixels count, whatever `inside` says.
template <ListMode mode, bool usual, bool whole, bool clamped, KeyKind kind>
HWY_INLINE void draw_patch(const ListState& state, DepthTile& tile, bool front, const DepthKeys<kind>& depth,
                           const typename DepthKeys<kind>::Columns& columns, const typename DepthKeys<kind>::Rows& rows,
                           std::size_t at, const Lanes* inside, std::uint32_t id, DrawnPixels& drawn,
                           TileCounts& counts) {
    Lanes pass[int_parts];
    test_patch<mode == ListMode::Ids, usual, whole, clamped>(state, tile, depth, columns, rows, at, inside, false,
                                                             writes<mode, usual>(state), id, pass);
    for (std::size_t p = 0; p < int_parts; ++p) {
        drawn.passed[p] = DrawnPixels::counted(drawn.passed[p], pass[p]);
        if (!whole) drawn.covered[p] = DrawnPixels::counted(drawn.covered[p], inside[p]);
    }
    if constexpr (is_counting(mode))
        count_fragments<mode, patch_pixels>(state, tile, front, at, whole ? 0xffff : patch_bits(inside),
                                            patch_bits(pass), counts);
}

// Pixels of the patch row at y that lie in the box's rows; of one column of patches, those in the box's columns.
HWY_INLINE std::uint32_t row_pixels(const LocalBox& box, int y) {
    return (0xffffu >> (4 * most(y + 3 - box.y1, 0))) & (0xffffu << (4 * most(box.y0 - y, 0)));
}
HWY_INLINE std::uint32_t column_pixels(const LocalBox& box, int x) {
    return ((0xfu >> most(x + 3 - box.x1, 0)) & (0xfu << most(box.x0 - x, 0)) & 0xf) * 0x1111u;
}

HWY_INLINE bool whole_patches(const LocalBox& box) {
    return ((box.x0 | box.y0 | ~box.x1 | ~box.y1) & (patch_side - 1)) == 0;
}

// Where the n-th patch of a row of patches lies in the tile.
struct PatchOffsets {
    std::uint16_t column[tile_patches], row[tile_patches];
    constexpr PatchOffsets() : column(), row() {
        for (std::size_t n = 0; n < tile_patches; ++n) {
            column[n] = static_cast<std::uint16_t>(place_in_tile(static_cast<int>(n) * patch_side, 0));
            row[n] = static_cast<std::uint16_t>(place_in_tile(0, static_cast<int>(n) * patch_side));
        }
    }
};
constexpr PatchOffsets patch_offsets;
HWY_INLINE std::size_t place_of_patch(int column, int row) {
    return std::size_t{patch_offsets.column[column]} + patch_offsets.row[row];
}

// A triangle of few patches: one after the other, without asking which it touches.
template <ListMode mode, KeyKind kind, bool usual, bool clamped>
HWY_NOINLINE void draw_small(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box,
                             std::uint32_t id, ListCounts& counts) {
    const Ints i;
    const DepthKeys<kind> depth(t, tile, state.key_scale);
    const int first = box.x0 / patch_side, last = box.x1 / patch_side, first_row = box.y0 / patch_side;
    const SmallEdges small(t, state.conservative, tile.x + first * patch_side, tile.y + first_row * patch_side);
    PatchEdges row_edges(small);
    const auto first_columns = depth.columns(static_cast<std::size_t>(first));
    const bool cut = t.extent != Extent::Small; // otherwise the edges alone tell what is inside
    DrawnPixels drawn;
    for (int row = first_row, last_row = box.y1 / patch_side;;) {
        const auto rows = depth.rows(static_cast<std::size_t>(row));
        PatchEdges edges = row_edges;
        auto columns = first_columns;
        for (int n = first;;) {
            Lanes inside[int_parts];
            for (std::size_t p = 0; p < int_parts; ++p) inside[p] = edges.inside(p);
            if (cut) {
                const std::uint32_t in_box = row_pixels(box, row * patch_side) & column_pixels(box, n * patch_side);
                for (std::size_t p = 0; p < int_parts; ++p)
                    inside[p] = hn::And(inside[p], mask_of(i, in_box >> (p * int_lanes)));
            }
            draw_patch<mode, usual, false, clamped>(state, tile, t.front, depth, columns, rows, place_of_patch(n, row),
                                                    inside, id, drawn, counts);
            if (++n > last) break;
            edges.move(edges.right);
            columns = depth.columns(static_cast<std::size_t>(n));
        }
        if (++row > last_row) break;
        row_edges.move(row_edges.up);
    }
    drawn.add_to<mode, usual>(counts, state, tile, box);
}

// Patches of a tile, each as one number: its place in the tile, its column and its row.
struct PatchNumbers {
    alignas(64) std::int32_t column[tile_patches], row[tile_patches];
    constexpr PatchNumbers() : column(), row() {
        for (std::size_t n = 0; n < tile_patches; ++n) {
            const auto number = static_cast<std::int32_t>(n);
            column[n] = static_cast<std::int32_t>(patch_offsets.column[n]) | number << 12;
            row[n] = static_cast<std::int32_t>(patch_offsets.row[n]) | number << 16;
        }
    }
    static std::size_t place(std::int32_t patch) { return static_cast<std::size_t>(patch & 0xfff); }
    static std::size_t column_of(std::int32_t patch) { return static_cast<std::size_t>(patch >> 12 & 15); }
    static std::size_t row_of(std::int32_t patch) { return static_cast<std::size_t>(patch >> 16); }
};
constexpr PatchNumbers patch_numbers;

// Patches that a triangle touches, those that it covers apart from those that edges cross; of these the edge functions
// at their first pixels. What is in the lists is drawn without asking: loops whose ends nobody can predict, one for
// each row of patches, would take as long as the drawing.
template <class T> struct PatchLists {
    static constexpr std::size_t most = tile_patches * tile_patches + patch_pixels; // a vector is written at the end
    std::size_t whole_count = 0, crossed_count = 0;
    alignas(64) std::int32_t whole[most], crossed[most];
    alignas(64) T corner[3][most];
};

// A row of patches across the tile, one lane each: which of them the triangle touches, and which it covers.
template <class T> struct RowOfPatches {
    static_assert(tile_side == patch_side * static_cast<int>(patch_pixels));
    using Lane = hn::CappedTag<T, patch_pixels>;
    hn::Vec<Lane> corner[3][int_parts], up[3], most_inside[3], least_inside[3];

    HWY_INLINE RowOfPatches(const T* base, const T* a, const T* b) {
        const Lane d;
        for (std::size_t e = 0; e < 3; ++e) {
            const auto right_step = hn::Set(d, a[e]), up_step = hn::Set(d, b[e]), zero = hn::Zero(d);
            const auto span = hn::Set(d, T{patch_side - 1});
            up[e] = hn::Mul(up_step, hn::Set(d, T{patch_side}));
            most_inside[e] = hn::Mul(span, hn::Add(hn::Max(right_step, zero), hn::Max(up_step, zero)));
            least_inside[e] = hn::Mul(span, hn::Add(hn::Min(right_step, zero), hn::Min(up_step, zero)));
            for (std::size_t p = 0; p < int_parts; ++p) {
                const auto offset = hn::Mul(hn::Load(d, patch_columns<T>.first_pixel + p * int_lanes), right_step);
                corner[e][p] = hn::Add(hn::Set(d, base[e]), offset);
            }
        }
    }
    HWY_INLINE void move() {
        for (std::size_t e = 0; e < 3; ++e)
            for (std::size_t p = 0; p < int_parts; ++p) corner[e][p] = hn::Add(corner[e][p], up[e]);
    }
    // Lists row y of patches, of which those in `columns` count, as bits; in `whole_columns` those that may be whole.
    HWY_INLINE void list(std::size_t y, std::uint32_t columns, std::uint32_t whole_columns,
                         PatchLists<T>& lists) const {
        const Ints i;
        const Lane d;
        for (std::size_t p = 0; p < int_parts; ++p) {
            const auto touched = hn::And(at_least(most_inside, p), mask_of(d, columns >> (p * int_lanes)));
            const auto whole = hn::And(at_least(least_inside, p), mask_of(d, whole_columns >> (p * int_lanes)));
            const auto crossed = hn::AndNot(whole, touched);
            const auto numbers =
                hn::Add(hn::Load(i, patch_numbers.column + p * int_lanes), hn::Set(i, patch_numbers.row[y]));
            hn::StoreU(hn::Compress(numbers, hn::RebindMask(i, whole)), i, lists.whole + lists.whole_count);
            hn::StoreU(hn::Compress(numbers, hn::RebindMask(i, crossed)), i, lists.crossed + lists.crossed_count);
            for (std::size_t e = 0; e < 3; ++e)
                hn::StoreU(hn::Compress(corner[e][p], crossed), d, lists.corner[e] + lists.crossed_count);
            lists.whole_count += hn::CountTrue(d, whole);
            lists.crossed_count += hn::CountTrue(d, crossed);
        }
    }

private:
    HWY_INLINE hn::Mask<Lane> at_least(const hn::Vec<Lane>* offset, std::size_t p) const {
        return nonnegative(hn::Min(hn::Min(hn::Add(corner[0][p], offset[0]), hn::Add(corner[1][p], offset[1])),
                                   hn::Add(corner[2][p], offset[2])));
    }
};

// A triangle of more patches: listing first which it touches, and which it covers. The edges are those at the tile's
// first column and the row of patches at y0.
template <ListMode mode, KeyKind kind, bool usual, bool clamped, class T>
HWY_INLINE void draw_rows(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box, int y0,
                          const T* base, const T* a, const T* b, std::uint32_t id, ListCounts& counts) {
    using Lane = hn::CappedTag<T, patch_pixels>;
    const Lane d;
    // Otherwise the edges, or patches alone, tell what is inside.
    const bool cut = t.extent != Extent::Small && !whole_patches(box);
    const DepthKeys<kind> depth(t, tile, state.key_scale);
    const int first = box.x0 / patch_side, last = box.x1 / patch_side;
    const std::uint32_t columns = (2u << last) - (1u << first);
    // Columns of patches that the box holds whole: of those that an edge covers it may still cut some away.
    const int first_whole = (box.x0 + 3) / patch_side, last_whole = (box.x1 + 1) / patch_side - 1;
    const std::uint32_t whole_columns = last_whole >= first_whole ? (2u << last_whole) - (1u << first_whole) : 0;
    typename DepthKeys<kind>::Columns column_depths[patch_pixels];
    typename DepthKeys<kind>::Rows row_depths[patch_pixels];
    for (int n = first; n <= last; ++n) column_depths[n] = depth.columns(static_cast<std::size_t>(n));
    PatchLists<T> lists;
    RowOfPatches<T> row(base, a, b);
    for (int y = y0; y <= box.y1; y += patch_side) {
        const auto n = static_cast<std::size_t>(y / patch_side);
        row_depths[n] = depth.rows(n);
        row.list(n, columns, y >= box.y0 && y + 3 <= box.y1 ? whole_columns : 0, lists);
        row.move();
    }

    DrawnPixels drawn;
    const auto draw = [&](std::int32_t patch, const Lanes* inside, auto whole) HWY_ATTR {
        draw_patch<mode, usual, whole(), clamped>(
            state, tile, t.front, depth, column_depths[PatchNumbers::column_of(patch)],
            row_depths[PatchNumbers::row_of(patch)], PatchNumbers::place(patch), inside, id, drawn, counts);
    };
    for (std::size_t k = 0; k < lists.whole_count; ++k) draw(lists.whole[k], nullptr, std::true_type());
    counts.covered += static_cast<std::int64_t>(patch_pixels * lists.whole_count);
    hn::Vec<Lane> offset[3][int_parts];
    for (std::size_t e = 0; e < 3; ++e)
        for (std::size_t p = 0; p < int_parts; ++p)
            offset[e][p] = hn::Add(hn::Mul(hn::Set(d, a[e]), hn::Load(d, patch_places<T>.x + p * int_lanes)),
                                   hn::Mul(hn::Set(d, b[e]), hn::Load(d, patch_places<T>.y + p * int_lanes)));
    for (std::size_t k = 0; k < lists.crossed_count; ++k) {
        const std::int32_t patch = lists.crossed[k];
        Lanes inside[int_parts];
        for (std::size_t p = 0; p < int_parts; ++p) {
            auto least = hn::Add(offset[0][p], hn::Set(d, lists.corner[0][k]));
            for (std::size_t e = 1; e < 3; ++e)
                least = hn::Min(least, hn::Add(offset[e][p], hn::Set(d, lists.corner[e][k])));
            inside[p] = hn::RebindMask(Ints(), nonnegative(least));
        }
        if (cut) {
            const std::uint32_t in_box =
                row_pixels(box, static_cast<int>(PatchNumbers::row_of(patch)) * patch_side) &
                column_pixels(box, static_cast<int>(PatchNumbers::column_of(patch)) * patch_side);
            for (std::size_t p = 0; p < int_parts; ++p)
                inside[p] = hn::And(inside[p], mask_of(Ints(), in_box >> (p * int_lanes)));
        }
        draw(patch, inside, std::false_type());
    }
    drawn.add_to<mode, usual>(counts, state, tile, box);
}

template <ListMode mode, KeyKind kind, bool usual, bool clamped>
HWY_NOINLINE void draw_medium(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box,
                              std::uint32_t id, ListCounts& counts) {
    const int y0 = box.y0 & -patch_side;
    const SmallEdges edges(t, state.conservative, tile.x, tile.y + y0);
    draw_rows<mode, kind, usual, clamped>(state, tile, t, box, y0, edges.base, edges.a, edges.b, id, counts);
}

template <ListMode mode, KeyKind kind, bool usual, bool clamped>
HWY_NOINLINE void draw_large(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box,
                             const TileEdges& edges, std::uint32_t id, ListCounts& counts) {
    const int y0 = box.y0 & -patch_side;
    std::int32_t base[3];
    for (std::size_t e = 0; e < 3; ++e) base[e] = edges.base[e] + edges.b[e] * y0;
    draw_rows<mode, kind, usual, clamped>(state, tile, t, box, y0, base, edges.a, edges.b, id, counts);
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
