// What lies behind boxes, as many at once as the processor takes. Included by files that are compiled once for each
// target, so it is read once for each, too.

#if defined(GNOMON_RAYTRACE_BOXES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_RAYTRACE_BOXES_INL_H
#undef GNOMON_RAYTRACE_BOXES_INL_H
#else
#define GNOMON_RAYTRACE_BOXES_INL_H
#endif

#include "raytrace/pyramid.h"
#include "raytrace/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::HWY_NAMESPACE {

constexpr float unbounded = 1e30f;

// The range of s and t of what lies behind boxes: of their corners' images. Boxes that come near the plane of the apex
// reach everything.
HWY_INLINE void reach_of_boxes(const Pyramid& pyramid, const Float* low, const Float* high, Float* range) {
    const auto terms = [&](vec3 factor, Vector& at_low, Vector& at_high) HWY_ATTR {
        const Vector f = set(factor);
        at_low = {hn::Mul(f.x, low[0]), hn::Mul(f.y, low[1]), hn::Mul(f.z, low[2])};
        at_high = {hn::Mul(f.x, high[0]), hn::Mul(f.y, high[1]), hn::Mul(f.z, high[2])};
    };
    Vector height[2], a[2], b[2];
    terms(pyramid.height, height[0], height[1]);
    terms(pyramid.to_a, a[0], a[1]);
    terms(pyramid.to_b, b[0], b[1]);
    Float a_low = hn::Set(d, unbounded), b_low = a_low, a_high = hn::Neg(a_low), b_high = a_high, nearest = a_low;
    for (int corner = 0; corner < 8; ++corner) {
        const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
        const auto sum = [&](const Vector* v) HWY_ATTR { return hn::Add(hn::Add(v[x].x, v[y].y), v[z].z); };
        const Float h = sum(height), inverse = hn::Div(hn::Set(d, 1.0f), h);
        const Float at_a = hn::Mul(sum(a), inverse), at_b = hn::Mul(sum(b), inverse);
        nearest = hn::Min(nearest, h);
        a_low = hn::Min(a_low, at_a), a_high = hn::Max(a_high, at_a);
        b_low = hn::Min(b_low, at_b), b_high = hn::Max(b_high, at_b);
    }
    // At heights above 2⁻⁸ what is rounded stays far below the growth of the boxes but for 2⁻¹² of the range.
    const Mask known = hn::Gt(nearest, hn::Set(d, 0x1p-8f));
    const Float center_a = hn::Set(d, pyramid.center_a), center_b = hn::Set(d, pyramid.center_b);
    const auto grown = [&](Float value, Float other, Float center, float wrong) HWY_ATTR {
        const Float size = hn::MulAdd(hn::Add(hn::Abs(value), hn::Abs(other)), hn::Set(d, 0x1p-12f), hn::Set(d, wrong));
        return hn::Sub(hn::Add(value, hn::CopySign(size, hn::Sub(value, other))), center);
    };
    range[0] = hn::IfThenElse(known, grown(a_low, a_high, center_a, 2 * pyramid.wrong_a), hn::Set(d, -unbounded));
    range[1] = hn::IfThenElse(known, grown(a_high, a_low, center_a, 2 * pyramid.wrong_a), hn::Set(d, unbounded));
    range[2] = hn::IfThenElse(known, grown(b_low, b_high, center_b, 2 * pyramid.wrong_b), hn::Set(d, -unbounded));
    range[3] = hn::IfThenElse(known, grown(b_high, b_low, center_b, 2 * pyramid.wrong_b), hn::Set(d, unbounded));
}

} // namespace gnomon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
