#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raytrace/false_hit_filter.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include <algorithm>

#include "raytrace/shadow_query.h"

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
    return bytes[0] | static_cast<unsigned>(bytes[1]) << 8;
}

struct Vector {
    Float x, y, z;
};
HWY_INLINE Vector load(const float* x, std::size_t stride) {
    return {hn::LoadU(d, x), hn::LoadU(d, x + stride), hn::LoadU(d, x + 2 * stride)};
}
HWY_INLINE Vector set(vec3 v) { return {hn::Set(d, v.x), hn::Set(d, v.y), hn::Set(d, v.z)}; }
HWY_INLINE Float dot(const Vector& a, const Vector& b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Float largest(const Vector& a) { return hn::Max(hn::Max(hn::Abs(a.x), hn::Abs(a.y)), hn::Abs(a.z)); }
HWY_INLINE Float sum_of_magnitudes(const Vector& a) {
    return hn::Add(hn::Add(hn::Abs(a.x), hn::Abs(a.y)), hn::Abs(a.z));
}

// A hit is no false one where the ray meets the triangle steeply and starts well off its plane, which the hit itself
// tells.
HWY_INLINE Mask is_steep(const Vector& normal, const Vector& way, Float distance, float steep, float nearest) {
    const Float across = hn::Abs(dot(normal, way));
    return hn::And(hn::Gt(across, hn::Mul(hn::Set(d, steep), largest(way))),
                   hn::Gt(hn::Mul(distance, across), hn::Mul(hn::Set(d, nearest), sum_of_magnitudes(normal))));
}

// Nor where the hit point lies in the triangle's box and the ray's end well beyond the triangle's plane.
HWY_INLINE Mask is_plain(const LookedAt& hit, vec3 start, const Vector& way, Float distance) {
    const auto inside = [&](float from, Float along, float center, float half) HWY_ATTR {
        const Float off = hn::MulAdd(distance, along, hn::Set(d, from - center));
        return hn::Le(hn::Abs(off), hn::Set(d, half));
    };
    const vec3 middle = hit.triangle.center, half = hit.half;
    const Mask in_box =
        hn::And(inside(start.x, way.x, middle.x, half.x),
                hn::And(inside(start.y, way.y, middle.y, half.y), inside(start.z, way.z, middle.z, half.z)));
    const Float beyond = hn::MulAdd(hn::Set(d, hit.off_plane), largest(way), hn::Set(d, hit.from_plane));
    return hn::And(in_box, hn::Gt(dot(set(hit.away), way), beyond));
}

// Which of the lanes may have met a triangle falsely.
HWY_INLINE unsigned doubtful(ShadowQuery& query, std::uint32_t primitive, unsigned asked, const float* normals,
                             const float* rays, unsigned count) {
    const float *ways = rays + 4 * count, *distances = rays + 8 * count, steep = query.casters->steep[primitive];
    unsigned left = 0;
    if (query.ends)
        for (unsigned i = 0; i < count; i += lanes())
            left |= ~bits_of(is_steep(load(normals + i, count), load(ways + i, count), hn::LoadU(d, distances + i),
                                      steep, query.nearest))
                    << i;
    asked &= left;
    if (asked == 0) return 0;
    const LookedAt& hit = look_at(query, primitive);
    left = 0;
    for (unsigned i = 0; i < count; i += lanes())
        left |= ~bits_of(is_plain(hit, query.start, load(ways + i, count), hn::LoadU(d, distances + i))) << i;
    return asked & left;
}

// All lanes that Embree asks about have met the same triangle; mostly there is but one.
void reject_false_hits(const RTCFilterFunctionNArguments* arguments) {
    auto& query = *reinterpret_cast<ShadowQuery*>(arguments->context);
    const unsigned count = arguments->N;
    int* const valid = arguments->valid;
    const bool whole = count % lanes() == 0;
    unsigned asked = 0;
    if (whole) {
        for (unsigned i = 0; i < count; i += lanes()) {
            const hn::RebindToSigned<Tag> integers;
            asked |= bits_of(hn::RebindMask(d, hn::Lt(hn::LoadU(integers, valid + i), hn::Zero(integers)))) << i;
        }
    } else {
        for (unsigned i = 0; i < count; ++i) asked |= (valid[i] == -1 ? 1u : 0u) << i;
    }
    if (asked == 0) return;
    const std::uint32_t primitive = RTCHitN_primID(arguments->hit, count, static_cast<unsigned>(__builtin_ctz(asked)));
    if (primitive == query.own_primitive) {
        std::fill_n(valid, count, 0);
        return;
    }
    if (whole)
        asked = doubtful(query, primitive, asked, &RTCHitN_Ng_x(arguments->hit, count, 0),
                         &RTCRayN_org_x(arguments->ray, count, 0), count);
    for (; asked; asked &= asked - 1) {
        const auto i = static_cast<unsigned>(__builtin_ctz(asked));
        RTCRayN* rays = arguments->ray;
        if (is_false_hit(query, primitive,
                         {RTCRayN_dir_x(rays, count, i), RTCRayN_dir_y(rays, count, i), RTCRayN_dir_z(rays, count, i)}))
            valid[i] = 0;
    }
}

RTCFilterFunctionN filter() { return reject_false_hits; }

} // namespace gnomon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon {

HWY_EXPORT(filter);

RTCFilterFunctionN false_hit_filter() {
    static const RTCFilterFunctionN chosen = HWY_DYNAMIC_DISPATCH(filter)();
    return chosen;
}

} // namespace gnomon
#endif
