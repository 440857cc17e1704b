// Three coordinates of as many vectors as the processor takes at once. Included by files that are compiled once for
// each target, so it is read once for each, too.

#if defined(GNOMON_RAYTRACE_VECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_RAYTRACE_VECTORS_INL_H
#undef GNOMON_RAYTRACE_VECTORS_INL_H
#else
#define GNOMON_RAYTRACE_VECTORS_INL_H
#endif

#include <cstring>

#include <hwy/highway.h>

#include "core/math.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, 16>;
using Float = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;
constexpr Tag d;

HWY_INLINE unsigned lanes() { return static_cast<unsigned>(hn::Lanes(d)); }

HWY_INLINE unsigned bits_of(Mask mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    std::uint16_t bits; // one register's worth where masks are registers
    std::memcpy(&bits, bytes, sizeof bits);
    return bits;
}

// The lanes whose bits are set; bits beyond the last lane do not matter.
HWY_INLINE Mask mask_of(unsigned bits) {
    const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8)};
    return hn::LoadMaskBits(d, bytes);
}

struct Vector {
    Float x, y, z;
};
HWY_INLINE Vector set(vec3 v) { return {hn::Set(d, v.x), hn::Set(d, v.y), hn::Set(d, v.z)}; }
// Coordinates in arrays `stride` apart.
HWY_INLINE Vector load(const float* x, std::size_t stride) {
    return {hn::LoadU(d, x), hn::LoadU(d, x + stride), hn::LoadU(d, x + 2 * stride)};
}
HWY_INLINE Vector operator+(const Vector& a, const Vector& b) {
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vector operator-(const Vector& a, const Vector& b) {
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Vector operator*(Float s, const Vector& a) { return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)}; }
HWY_INLINE Vector magnitudes(const Vector& a) { return {hn::Abs(a.x), hn::Abs(a.y), hn::Abs(a.z)}; }
HWY_INLINE Vector larger(const Vector& a, const Vector& b) {
    return {hn::Max(a.x, b.x), hn::Max(a.y, b.y), hn::Max(a.z, b.z)};
}
HWY_INLINE Float largest(const Vector& a) { return hn::Max(hn::Max(hn::Abs(a.x), hn::Abs(a.y)), hn::Abs(a.z)); }
HWY_INLINE Float dot(const Vector& a, const Vector& b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Float length(const Vector& a) { return hn::Sqrt(dot(a, a)); }
HWY_INLINE Vector cross(const Vector& a, const Vector& b) {
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

} // namespace gnomon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
