#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raytrace/shadow_kernels.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <algorithm>

#include "raytrace/shadow_query.h"
#include "raytrace/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::HWY_NAMESPACE {

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
    query.met[query.met_count++ % query.met.size()] = primitive;
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

// In the order of glm::dot() and without contraction: the horizon is that of faces(), bit for bit.
unsigned aim(const Receiver& receiver, const ShadowOrigin& origin, const float* x, const float* y, const float* z,
             RTCRay16& rays, int* valid) {
    const Vector start = set(origin.position), position = set(receiver.position),
                 normal = set(receiver.geometric_normal);
    const hn::RebindToSigned<Tag> integers;
    const Float one = hn::Set(d, 1.0f);
    unsigned facing = 0;
    for (unsigned i = 0; i < 16; i += lanes()) {
        const Vector target{hn::LoadU(d, x + i), hn::LoadU(d, y + i), hn::LoadU(d, z + i)};
        const Vector way = target - start, up = target - position;
        const Float height =
            hn::Add(hn::Add(hn::Mul(normal.x, up.x), hn::Mul(normal.y, up.y)), hn::Mul(normal.z, up.z));
        const Mask above = hn::Gt(height, hn::Zero(d));
        hn::StoreU(hn::VecFromMask(integers, hn::RebindMask(integers, above)), integers, valid + i);
        facing |= bits_of(above) << i;
        hn::StoreU(way.x, d, rays.dir_x + i);
        hn::StoreU(way.y, d, rays.dir_y + i);
        hn::StoreU(way.z, d, rays.dir_z + i);
        // The way is not normalised, so 1 is the target. The ray ends short of it by the rounding of its coordinates,
        // so that what touches the light from behind does not hide it.
        const Float rounding =
            hn::Max(hn::Set(d, origin.rounding), hn::Mul(largest(target), hn::Set(d, relative_step)));
        hn::StoreU(hn::Max(hn::Zero(d), hn::Sub(one, hn::Div(rounding, largest(way)))), d, rays.tfar + i);
    }
    return facing;
}

unsigned hidden(const RTCRay16& rays) {
    unsigned met = 0;
    for (unsigned i = 0; i < 16; i += lanes()) met |= bits_of(hn::Lt(hn::LoadU(d, rays.tfar + i), hn::Zero(d))) << i;
    return met;
}

const ShadowKernels* shadow_table() {
    static constexpr ShadowKernels functions{reject_false_hits, aim, hidden};
    return &functions;
}

} // namespace gnomon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon {

HWY_EXPORT(shadow_table);

const ShadowKernels& shadow_kernels() {
    static const ShadowKernels* const chosen = HWY_DYNAMIC_DISPATCH(shadow_table)();
    return *chosen;
}

} // namespace gnomon
#endif
