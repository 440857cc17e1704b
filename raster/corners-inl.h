// Corners of as many triangles as a vector has lanes; included once for each instruction set.

#if defined(GNOMON_CORNERS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_CORNERS_INL
#undef GNOMON_CORNERS_INL
#else
#define GNOMON_CORNERS_INL
#endif

#include <hwy/highway.h>

#include "raster/kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The lower or upper half of a vector's lanes, as doubles, and back as floats, of which the sign is what matters.
#if HWY_TARGET == HWY_SCALAR
template <class D, class V> HWY_INLINE auto lower(D, V v) { return hn::PromoteTo(hn::Rebind<double, D>(), v); }
template <class D, class V> HWY_INLINE auto upper(D d, V v) { return lower(d, v); }
template <class D, class V> HWY_INLINE auto signs(D, V low, V) { return hn::DemoteTo(hn::Rebind<float, D>(), low); }
#else
template <class D> using HalfAsDouble = hn::Rebind<double, hn::Half<D>>;
template <class D, class V> HWY_INLINE auto lower(D, V v) {
    return hn::PromoteTo(HalfAsDouble<D>(), hn::LowerHalf(hn::Half<D>(), v));
}
template <class D, class V> HWY_INLINE auto upper(D, V v) {
    return hn::PromoteTo(HalfAsDouble<D>(), hn::UpperHalf(hn::Half<D>(), v));
}
template <class D, class V> HWY_INLINE auto signs(D, V low, V high) {
    const hn::Rebind<float, D> f;
    const hn::Half<decltype(f)> half;
    return hn::Combine(f, hn::DemoteTo(half, high), hn::DemoteTo(half, low));
}
#endif

// Three corners of as many triangles as a vector has lanes.
template <class V> struct CornerCoordinates { V x[3], y[3]; };

// Twice the signed area, as a float of its sign: exact in double, where products of 24-bit differences fit.
template <class D, class V> HWY_INLINE auto area_sign(D d, const CornerCoordinates<V>& v) {
    const auto e1x = hn::Sub(v.x[1], v.x[0]), e1y = hn::Sub(v.y[1], v.y[0]);
    const auto e2x = hn::Sub(v.x[2], v.x[0]), e2y = hn::Sub(v.y[2], v.y[0]);
    const auto cross = [](auto ax, auto ay, auto bx, auto by) { return hn::Sub(hn::Mul(ax, by), hn::Mul(bx, ay)); };
    return signs(d, cross(lower(d, e1x), lower(d, e1y), lower(d, e2x), lower(d, e2y)),
                 cross(upper(d, e1x), upper(d, e1y), upper(d, e2x), upper(d, e2y)));
}

// First and last pixel whose centre (or, where whole pixels count, any point) lies between two coordinates.
template <class D, class V> struct PixelRange {
    V first, last;
    HWY_INLINE PixelRange(D d, V a, V b, V c, bool whole_pixels)
        : first(hn::ShiftRight<8>(hn::Add(hn::Min(hn::Min(a, b), c), hn::Set(d, whole_pixels ? 0 : 127)))),
          last(hn::ShiftRight<8>(hn::Sub(hn::Max(hn::Max(a, b), c), hn::Set(d, whole_pixels ? 0 : 128)))) {}
    HWY_INLINE void clamp(D d, int begin, int size) {
        first = hn::Max(first, hn::Set(d, begin));
        last = hn::Min(last, hn::Set(d, begin + size - 1));
    }
};

// Which triangles hold none of the four pixel centres from (column, row) on; those must be all that their boxes hold.
// Coordinates around such a small triangle are small, so that 32 bits hold its edge functions.
template <class D, class V, class M>
HWY_INLINE auto holds_no_centre(D d, const CornerCoordinates<V>& v, M clockwise, V column, V row) {
    const V x[3] = {v.x[0], hn::IfThenElse(clockwise, v.x[2], v.x[1]), hn::IfThenElse(clockwise, v.x[1], v.x[2])};
    const V y[3] = {v.y[0], hn::IfThenElse(clockwise, v.y[2], v.y[1]), hn::IfThenElse(clockwise, v.y[1], v.y[2])};
    const V centre_x = hn::Add(hn::ShiftLeft<8>(column), hn::Set(d, 128));
    const V centre_y = hn::Add(hn::ShiftLeft<8>(row), hn::Set(d, 128));
    V outside[4]; // its sign
    for (int e = 0; e < 3; ++e) {
        const int next = (e + 1) % 3;
        const V a = hn::Sub(y[e], y[next]), b = hn::Sub(x[next], x[e]);
        // The fill rule's −1 on exclusive edges: a < 0, or a = 0 and b < 0.
        const auto exclusive = hn::Or(hn::Lt(a, hn::Zero(d)), hn::And(hn::Eq(a, hn::Zero(d)), hn::Lt(b, hn::Zero(d))));
        const V at = hn::Add(hn::Add(hn::Mul(a, hn::Sub(centre_x, x[e])), hn::Mul(b, hn::Sub(centre_y, y[e]))),
                             hn::VecFromMask(d, exclusive));
        const V right = hn::Add(at, hn::ShiftLeft<8>(a)), up = hn::ShiftLeft<8>(b);
        const V values[4] = {at, right, hn::Add(at, up), hn::Add(right, up)};
        for (int k = 0; k < 4; ++k) outside[k] = e == 0 ? values[k] : hn::Or(outside[k], values[k]);
    }
    return hn::Lt(hn::And(hn::And(outside[0], outside[1]), hn::And(outside[2], outside[3])), hn::Zero(d));
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
