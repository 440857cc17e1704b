#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/setup_kernels.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include "raster/clip.h"
#include "raster/corners-inl.h"
#include "raster/setup_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// How far inside the guard band, as doubles: negative outside. The same sums as the clipper's, because whether a vertex
// is cut away must not depend on who asks.
template <class V> HWY_INLINE V inside_guard_band(V x, V y, V w, double gx, double gy) {
    const hn::DFromV<V> d;
    const V right = hn::Mul(hn::Set(d, gx), w), top = hn::Mul(hn::Set(d, gy), w);
    return hn::Min(hn::Min(hn::Add(x, right), hn::Sub(right, x)), hn::Min(hn::Add(y, top), hn::Sub(top, y)));
}

void to_window_part(const SetupState& state, const float* positions, std::int32_t* window) {
    const hn::ScalableTag<float> f;
    const hn::RebindToSigned<decltype(f)> i;
    hn::Vec<decltype(f)> x, y, z, w;
    hn::LoadInterleaved4(f, positions, x, y, z, w);
    const auto zero = hn::Zero(f), minus_w = hn::Neg(w);
    auto flags = hn::Zero(i);
    const auto flag = [&](auto mask, std::uint32_t bit) {
        flags = hn::Or(flags, hn::IfThenElseZero(hn::RebindMask(i, mask), hn::Set(i, static_cast<std::int32_t>(bit))));
    };
    flag(hn::Lt(x, minus_w), 1), flag(hn::Gt(x, w), 2), flag(hn::Lt(y, minus_w), 4), flag(hn::Gt(y, w), 8);
    const double gx = 2.0 * guard_band_pixels / state.viewport.width;
    const double gy = 2.0 * guard_band_pixels / state.viewport.height;
    const auto band = signs(f, inside_guard_band(lower(f, x), lower(f, y), lower(f, w), gx, gy),
                            inside_guard_band(upper(f, x), upper(f, y), upper(f, w), gx, gy));
    auto inside = hn::And(hn::Ge(band, zero), hn::Gt(w, zero));
    if (!state.depth_clamp) {
        const auto nearer = hn::Lt(z, state.clip_depth == ClipDepth::ZeroToOne ? zero : minus_w), beyond = hn::Gt(z, w);
        flag(nearer, 16), flag(beyond, 32);
        inside = hn::And(inside, hn::Not(hn::Or(nearer, beyond)));
    }
    const auto finite = hn::And(hn::And(hn::IsFinite(x), hn::IsFinite(y)), hn::And(hn::IsFinite(z), hn::IsFinite(w)));
    inside = hn::And(inside, finite);
    flag(hn::Not(inside), needs_clip);

    const float half_width = 0.5f * static_cast<float>(state.viewport.width);
    const float half_height = 0.5f * static_cast<float>(state.viewport.height);
    const auto oow = hn::Div(hn::Set(f, 1.0f), w);
    const auto fixed = [&](auto coordinate, float half, int least) {
        const auto pixels =
            hn::Add(hn::Mul(hn::Mul(coordinate, oow), hn::Set(f, half)), hn::Set(f, static_cast<float>(least) + half));
        return hn::NearestInt(hn::Mul(pixels, hn::Set(f, 256.0f)));
    };
    auto depth = hn::Mul(z, oow);
    if (state.clip_depth != ClipDepth::ZeroToOne) depth = hn::Add(hn::Mul(depth, hn::Set(f, 0.5f)), hn::Set(f, 0.5f));
    hn::StoreInterleaved4(fixed(x, half_width, state.viewport.x), fixed(y, half_height, state.viewport.y),
                          hn::BitCast(i, depth), flags, i, window);
}

void to_window(const SetupState& state, const vec4* positions, std::size_t count, WindowVertex* window) {
    const hn::ScalableTag<float> f;
    const std::size_t lanes = hn::Lanes(f);
    std::size_t k = 0;
    for (; k + lanes <= count; k += lanes) to_window_part(state, &positions[k].x, &window[k].x);
    if (k == count) return;
    vec4 rest[HWY_MAX_BYTES / sizeof(float)];
    WindowVertex rest_window[HWY_MAX_BYTES / sizeof(float)];
    for (std::size_t r = 0; r < lanes; ++r) rest[r] = positions[k + r < count ? k + r : k];
    to_window_part(state, &rest[0].x, &rest_window[0].x);
    for (std::size_t r = 0; k + r < count; ++r) window[k + r] = rest_window[r];
}

// The lanes below `count` of one vector of triangles. Returns how many lanes were looked at.
std::size_t cull_part(const SetupState& state, const std::int32_t* window, const std::uint32_t* triangles,
                      std::size_t count, std::uint32_t first, bool mirrored, Survivors& out) {
    const hn::ScalableTag<std::int32_t> i;
    const hn::RebindToUnsigned<decltype(i)> u;
    const hn::RebindToFloat<decltype(i)> f;
    hn::Vec<decltype(u)> index[3];
    hn::LoadInterleaved3(u, triangles, index[0], index[1], index[2]);
    CornerCoordinates<hn::Vec<decltype(i)>> v;
    hn::Vec<decltype(i)> z[3], flags[3];
    for (int c = 0; c < 3; ++c) {
        const auto at = hn::BitCast(i, hn::ShiftLeft<2>(index[c])); // four words a vertex
        v.x[c] = hn::GatherIndex(i, window, at);
        v.y[c] = hn::GatherIndex(i, window + 1, at);
        z[c] = hn::GatherIndex(i, window + 2, at);
        flags[c] = hn::GatherIndex(i, window + 3, at);
    }
    const auto outside =
        hn::And(hn::And(flags[0], flags[1]), hn::And(flags[2], hn::Set(i, std::int32_t{outside_mask})));
    auto alive = hn::And(hn::Eq(outside, hn::Zero(i)), hn::FirstN(i, count));
    const auto any_flag = hn::Or(hn::Or(flags[0], flags[1]), flags[2]);
    const auto cut = hn::And(hn::TestBit(any_flag, hn::Set(i, std::int32_t{needs_clip})), alive);
    const std::intptr_t first_cut = hn::FindFirstTrue(i, cut);
    if (first_cut >= 0) {
        count = static_cast<std::size_t>(first_cut);
        alive = hn::And(alive, hn::FirstN(i, count));
    }

    const auto area = area_sign(i, v);
    const auto positive = hn::Gt(area, hn::Zero(f)), negative = hn::Lt(area, hn::Zero(f));
    const bool positive_is_front = (state.front_face == FrontFace::CounterClockwise) != mirrored;
    const bool keep_positive = state.cull == Cull::None || (state.cull == Cull::Back) == positive_is_front;
    const bool keep_negative = state.cull == Cull::None || (state.cull == Cull::Back) != positive_is_front;
    auto facing = hn::Or(positive, negative);
    if (!keep_positive) facing = negative;
    if (!keep_negative) facing = positive;
    alive = hn::And(alive, hn::RebindMask(i, facing));

    const bool whole_pixels = state.conservative || state.multisampled;
    PixelRange<decltype(i), hn::Vec<decltype(i)>> columns(i, v.x[0], v.x[1], v.x[2], whole_pixels);
    PixelRange<decltype(i), hn::Vec<decltype(i)>> rows(i, v.y[0], v.y[1], v.y[2], whole_pixels);
    const auto tiny = hn::And(hn::Lt(hn::Sub(columns.last, columns.first), hn::Set(i, 2)),
                              hn::Lt(hn::Sub(rows.last, rows.first), hn::Set(i, 2)));
    const auto column = columns.first, row = rows.first;
    columns.clamp(i, state.drawable.x, state.drawable.width);
    rows.clamp(i, state.drawable.y, state.drawable.height);
    alive = hn::AndNot(hn::Or(hn::Gt(columns.first, columns.last), hn::Gt(rows.first, rows.last)), alive);
    const auto suspect = hn::And(alive, tiny);
    if (!whole_pixels && !hn::AllFalse(i, suspect)) {
        const auto empty = hn::And(suspect, holds_no_centre(i, v, hn::RebindMask(i, negative), column, row));
        out.empty += hn::CountTrue(i, empty);
        alive = hn::AndNot(empty, alive);
    }
    if (hn::AllFalse(i, alive)) return count;

    const std::size_t at = out.count;
    for (int c = 0; c < 3; ++c) {
        hn::CompressStore(v.x[c], alive, i, out.x[c] + at);
        hn::CompressStore(v.y[c], alive, i, out.y[c] + at);
        hn::CompressStore(hn::BitCast(f, z[c]), hn::RebindMask(f, alive), f, out.z[c] + at);
    }
    const auto primitive = hn::Add(hn::Set(u, first), hn::Iota(u, 0));
    hn::CompressStore(primitive, hn::RebindMask(u, alive), u, out.primitive + at);
    hn::StoreU(hn::Set(u, SetupTriangle::whole), u, out.piece + at);
    hn::StoreU(hn::Set(u, mirrored ? 1u : 0u), u, out.mirrored + at);
    out.count += hn::CountTrue(i, alive);
    return count;
}

std::size_t cull(const SetupState& state, const WindowVertex* window, const uvec3* triangles, std::size_t count,
                 std::uint32_t first, bool mirrored, Survivors& survivors) {
    const hn::ScalableTag<std::int32_t> i;
    const std::size_t lanes = hn::Lanes(i);
    for (std::size_t k = 0; k < count; k += lanes) {
        const std::size_t wanted = count - k < lanes ? count - k : lanes;
        uvec3 rest[HWY_MAX_BYTES / sizeof(std::int32_t)];
        const uvec3* from = triangles + k;
        if (wanted < lanes) {
            for (std::size_t r = 0; r < lanes; ++r) rest[r] = from[r < wanted ? r : 0];
            from = rest;
        }
        const std::size_t seen =
            cull_part(state, &window->x, &from->x, wanted, first + static_cast<std::uint32_t>(k), mirrored, survivors);
        if (seen < wanted) return k + seen;
    }
    return count;
}

// One vector's worth of set-up triangles as arrays of their fields.
struct FinishedPart {
    static constexpr std::size_t lanes = HWY_MAX_BYTES / sizeof(double);
    alignas(64) std::int32_t x[3][lanes], y[3][lanes];
    alignas(64) float z[lanes], z_minimum[lanes], z_maximum[lanes];
    alignas(64) double dx[lanes], dy[lanes];
    alignas(64) std::int32_t x0[lanes], y0[lanes], x1[lanes], y1[lanes], first[lanes], reversed[lanes], extent[lanes];
    alignas(64) std::int32_t steady[lanes];
};

// Where depths inside lie between those of the corners, rounded to floats. With E² `squares`, no edge being longer than
// E, and A `twice_area` what doubles round is less than 2⁻⁵³ (2 + 24 E²/A) in [0, 1]: 16 of it in the plane, 8 in its
// value at a pixel. Where that is below 2⁻³³, half of the least distance between a float and the middle of two from 2⁻⁷
// on, rounding to float takes it back.
template <class F, class V, class W> HWY_INLINE auto is_steady(F f, V squares, V twice_area, W nearest, W farthest) {
    const hn::DFromV<V> d;
    const auto margin = hn::Sub(hn::Abs(twice_area), hn::Mul(squares, hn::Set(d, 0x1p-15)));
    return hn::And(hn::Gt(hn::DemoteTo(f, margin), hn::Zero(f)),
                   hn::And(hn::Ge(nearest, hn::Set(f, 0x1p-7f)), hn::Le(farthest, hn::Set(f, 1.0f))));
}

void finish_part(const SetupState& state, const Survivors& in, std::size_t at, FinishedPart& out) {
    const hn::ScalableTag<double> d;
    const hn::Rebind<std::int32_t, decltype(d)> i;
    const hn::Rebind<float, decltype(d)> f;
    using V = hn::Vec<decltype(i)>;
    CornerCoordinates<hn::Vec<decltype(i)>> v;
    V z[3];
    for (int c = 0; c < 3; ++c) {
        v.x[c] = hn::LoadU(i, in.x[c] + at);
        v.y[c] = hn::LoadU(i, in.y[c] + at);
        z[c] = hn::BitCast(i, hn::LoadU(f, in.z[c] + at));
    }
    const auto real = [&](V a) { return hn::PromoteTo(d, a); };
    const auto cross = [](auto ax, auto ay, auto bx, auto by) { return hn::Sub(hn::Mul(ax, by), hn::Mul(bx, ay)); };

    // Counter-clockwise, then from the corner that is smallest by (x, y).
    const auto area = cross(real(hn::Sub(v.x[1], v.x[0])), real(hn::Sub(v.y[1], v.y[0])), real(hn::Sub(v.x[2], v.x[0])),
                            real(hn::Sub(v.y[2], v.y[0])));
    const auto clockwise = hn::RebindMask(i, hn::Lt(hn::DemoteTo(f, area), hn::Zero(f)));
    const auto swap = [&](V* a) {
        const V second = hn::IfThenElse(clockwise, a[2], a[1]);
        a[2] = hn::IfThenElse(clockwise, a[1], a[2]);
        a[1] = second;
    };
    swap(v.x), swap(v.y), swap(z);
    const auto before = [&](int a, int b) {
        return hn::Or(hn::Lt(v.x[a], v.x[b]), hn::And(hn::Eq(v.x[a], v.x[b]), hn::Lt(v.y[a], v.y[b])));
    };
    const auto second_smallest = hn::And(before(1, 0), before(1, 2));
    const auto third_smallest = hn::And(before(2, 0), hn::Not(before(1, 2)));
    const auto rotate = [&](V* a) {
        const V r0 = hn::IfThenElse(third_smallest, a[2], hn::IfThenElse(second_smallest, a[1], a[0]));
        const V r1 = hn::IfThenElse(third_smallest, a[0], hn::IfThenElse(second_smallest, a[2], a[1]));
        const V r2 = hn::IfThenElse(third_smallest, a[1], hn::IfThenElse(second_smallest, a[0], a[2]));
        a[0] = r0, a[1] = r1, a[2] = r2;
    };
    rotate(v.x), rotate(v.y), rotate(z);
    // Which submitted corner that is: where swapped, places 1 and 2 held corners 2 and 1.
    const V place = hn::IfThenElse(third_smallest, hn::Set(i, 2), hn::IfThenElseZero(second_smallest, hn::Set(i, 1)));
    const auto exchanged = hn::And(clockwise, hn::Gt(place, hn::Zero(i)));
    hn::StoreU(hn::IfThenElse(exchanged, hn::Sub(hn::Set(i, 3), place), place), i, out.first);
    hn::StoreU(hn::IfThenElseZero(clockwise, hn::Set(i, 1)), i, out.reversed);

    const auto pixels = hn::Set(d, 1.0 / subpixels);
    const auto e1x = hn::Mul(real(hn::Sub(v.x[1], v.x[0])), pixels),
               e1y = hn::Mul(real(hn::Sub(v.y[1], v.y[0])), pixels);
    const auto e2x = hn::Mul(real(hn::Sub(v.x[2], v.x[0])), pixels),
               e2y = hn::Mul(real(hn::Sub(v.y[2], v.y[0])), pixels);
    const auto pixel_area = cross(e1x, e1y, e2x, e2y);
    hn::Vec<decltype(f)> depth[3];
    for (int c = 0; c < 3; ++c) depth[c] = hn::BitCast(f, z[c]);
    const auto z0 = hn::PromoteTo(d, depth[0]);
    const auto d1 = hn::Sub(hn::PromoteTo(d, depth[1]), z0), d2 = hn::Sub(hn::PromoteTo(d, depth[2]), z0);
    hn::StoreU(hn::Div(hn::Sub(hn::Mul(d1, e2y), hn::Mul(d2, e1y)), pixel_area), d, out.dx);
    hn::StoreU(hn::Div(hn::Sub(hn::Mul(d2, e1x), hn::Mul(d1, e2x)), pixel_area), d, out.dy);
    const auto nearest = hn::Min(hn::Min(depth[0], depth[1]), depth[2]),
               farthest = hn::Max(hn::Max(depth[0], depth[1]), depth[2]);
    hn::StoreU(depth[0], f, out.z);
    hn::StoreU(nearest, f, out.z_minimum);
    hn::StoreU(farthest, f, out.z_maximum);

    const bool whole_pixels = state.conservative || state.multisampled;
    const auto square = [](auto a, auto b) { return hn::Add(hn::Mul(a, a), hn::Mul(b, b)); };
    const auto squares = hn::Add(square(e1x, e1y), square(e2x, e2y));
    const auto steady = hn::RebindMask(i, is_steady(f, hn::Add(squares, squares), pixel_area, nearest, farthest));
    hn::StoreU(hn::IfThenElseZero(steady, hn::Set(i, whole_pixels ? 0 : 1)), i, out.steady);
    PixelRange<decltype(i), V> columns(i, v.x[0], v.x[1], v.x[2], whole_pixels);
    PixelRange<decltype(i), V> rows(i, v.y[0], v.y[1], v.y[2], whole_pixels);
    const V limit = hn::Set(i, 64);
    const auto small =
        hn::And(hn::Lt(hn::Sub(columns.last, columns.first), limit), hn::Lt(hn::Sub(rows.last, rows.first), limit));
    const auto whole_columns = columns, whole_rows = rows;
    columns.clamp(i, state.drawable.x, state.drawable.width);
    rows.clamp(i, state.drawable.y, state.drawable.height);
    hn::StoreU(columns.first, i, out.x0), hn::StoreU(columns.last, i, out.x1);
    hn::StoreU(rows.first, i, out.y0), hn::StoreU(rows.last, i, out.y1);
    const auto kept =
        hn::And(hn::And(hn::Eq(columns.first, whole_columns.first), hn::Eq(columns.last, whole_columns.last)),
                hn::And(hn::Eq(rows.first, whole_rows.first), hn::Eq(rows.last, whole_rows.last)));
    const auto extent = [](Extent e) { return static_cast<std::int32_t>(e); };
    const V uncut = hn::Set(i, extent(state.conservative ? Extent::SmallCut : Extent::Small));
    const V small_extent = hn::IfThenElse(kept, uncut, hn::Set(i, extent(Extent::SmallCut)));
    hn::StoreU(hn::IfThenElse(small, small_extent, hn::Set(i, extent(Extent::Large))), i, out.extent);
    for (int c = 0; c < 3; ++c) hn::StoreU(v.x[c], i, out.x[c]), hn::StoreU(v.y[c], i, out.y[c]);
}

void finish(const SetupState& state, const Survivors& in, SetupTriangle* triangles) {
    const hn::ScalableTag<double> d;
    FinishedPart part;
    for (std::size_t at = 0; at < in.count; at += hn::Lanes(d)) {
        finish_part(state, in, at, part);
        for (std::size_t k = 0; k < hn::Lanes(d) && at + k < in.count; ++k) {
            SetupTriangle& t = triangles[at + k];
            for (std::size_t c = 0; c < 4; ++c) t.x[c] = part.x[c % 3][k], t.y[c] = part.y[c % 3][k];
            t.depth = part.z[k], t.depth_minimum = part.z_minimum[k], t.depth_maximum = part.z_maximum[k];
            t.primitive = in.primitive[at + k];
            t.depth_dx = part.dx[k], t.depth_dy = part.dy[k];
            t.depth_offset = 0;
            t.x0 = static_cast<std::uint16_t>(part.x0[k]), t.x1 = static_cast<std::uint16_t>(part.x1[k]);
            t.y0 = static_cast<std::uint16_t>(part.y0[k]), t.y1 = static_cast<std::uint16_t>(part.y1[k]);
            t.piece = in.piece[at + k];
            t.first = static_cast<std::uint8_t>(part.first[k]);
            t.reversed = part.reversed[k] != 0;
            t.steady = part.steady[k] != 0;
            t.front = ((part.reversed[k] == 0) != (in.mirrored[at + k] != 0)) ==
                      (state.front_face == FrontFace::CounterClockwise);
            t.extent = static_cast<Extent>(part.extent[k]);
        }
    }
}

// Edge functions in double, which holds them: the corner of the tile that is most inside decides for each edge.
std::uint64_t touched_tiles(const SetupTriangle& t, int x0, int y0, int rows, bool whole_pixels) {
    constexpr std::size_t tiles = 8;
    const hn::CappedTag<double, tiles> d;
    const double inset = whole_pixels ? 0 : 128, side = tile_side * 256;
    std::uint64_t touched = 0;
    for (std::size_t p = 0; p < tiles; p += hn::MaxLanes(d)) {
        const auto left = hn::Mul(counted_from(d, static_cast<double>(x0) + static_cast<double>(p)), hn::Set(d, side));
        hn::Vec<decltype(d)> edge[3], up[3]; // in row y0, and from row to row
        for (int e = 0; e < 3; ++e) {
            const double a = t.y[e] - t.y[e + 1], b = t.x[e + 1] - t.x[e];
            const double x = (a > 0 ? side - inset : inset) - t.x[e];
            const double y = y0 * side + (b > 0 ? side - inset : inset) - t.y[e];
            edge[e] = hn::Add(hn::Mul(hn::Add(left, hn::Set(d, x)), hn::Set(d, a)), hn::Set(d, b * y));
            up[e] = hn::Set(d, b * side);
        }
        for (int j = 0; j < rows; ++j) {
            const auto least = hn::Min(hn::Min(edge[0], edge[1]), edge[2]);
            touched |= bits_of(d, hn::Ge(least, hn::Zero(d))) << (tiles * static_cast<std::size_t>(j) + p);
            for (int e = 0; e < 3; ++e) edge[e] = hn::Add(edge[e], up[e]);
        }
    }
    return touched;
}

const SetupKernels* setup_table() {
    static constexpr SetupKernels kernels = {to_window, cull, finish, touched_tiles};
    return &kernels;
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "raster/isa.h"

namespace gnomon::detail {
HWY_EXPORT(setup_table);

const SetupKernels& setup_kernels() {
    static const SetupKernels* chosen = for_chosen_isa([] { return HWY_DYNAMIC_DISPATCH(setup_table)(); });
    return *chosen;
}
} // namespace gnomon::detail
#endif
