#include "raytrace/shadow_rays.h"

#include <algorithm>

#include <hwy/highway.h>

#include "core/vector_clones.h"

namespace gnomon {
namespace {

// Bit k: number k of sixteen is negative.
template <class T> HWY_ATTR unsigned negative_lanes(const T* values) {
    namespace hn = hwy::HWY_NAMESPACE;
    constexpr hn::CappedTag<T, ShadowRays::packet_size> d;
    unsigned negative = 0;
    for (size_t i = 0; i < ShadowRays::packet_size; i += hn::Lanes(d)) {
        std::uint8_t bits[8] = {};
        hn::StoreMaskBits(d, hn::Lt(hn::LoadU(d, values + i), hn::Zero(d)), bits);
        negative |= (bits[0] | static_cast<unsigned>(bits[1]) << 8) << i;
    }
    return negative;
}

// A hit is no false one where the ray meets the triangle steeply and starts well off its plane, which the hit itself
// tells; the others are looked at one by one.
bool is_certain(vec3 normal, vec3 way, float distance, float steep, float nearest) {
    const float across = std::abs(normal.x * way.x + normal.y * way.y + normal.z * way.z);
    const float away = nearest * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z));
    return (across > steep * largest_component(way)) & (distance * across > away);
}

bool is_false(ShadowQuery& query, std::uint32_t primitive, vec3 way, float distance) {
    if (query.looked_at != primitive) {
        query.looked_at = primitive;
        query.triangle = hit_triangle(query.casters->corners(primitive));
        query.sides = {};
    }
    const HitTriangle& hit = query.triangle;
    if (query.ends && !lies_in_box(hit, query.start, way, distance) && !meets_box(hit, query.start, way)) return true;
    return is_left_behind(hit, query.own_corners, query.start, way, query.ends, query.nearest, query.sides);
}

// All lanes that Embree asks about have met the same triangle; mostly there is but one.
void reject_false_hits(const RTCFilterFunctionNArguments* arguments) {
    auto& query = *reinterpret_cast<ShadowQuery*>(arguments->context);
    const unsigned count = arguments->N;
    int* const valid = arguments->valid;
    unsigned asked = count == ShadowRays::packet_size ? negative_lanes(valid) : 1u;
    if (asked == 0) return;
    RTCRayN* rays = arguments->ray;
    RTCHitN* hits = arguments->hit;
    const std::uint32_t primitive = RTCHitN_primID(hits, count, static_cast<unsigned>(__builtin_ctz(asked)));
    if (primitive == query.own_primitive) {
        std::fill_n(valid, count, 0);
        return;
    }
    const float steep = query.ends ? query.casters->steep[primitive] : infinity;
    for (; asked; asked &= asked - 1) {
        const auto i = static_cast<unsigned>(__builtin_ctz(asked));
        const vec3 normal(RTCHitN_Ng_x(hits, count, i), RTCHitN_Ng_y(hits, count, i), RTCHitN_Ng_z(hits, count, i));
        const vec3 way(RTCRayN_dir_x(rays, count, i), RTCRayN_dir_y(rays, count, i), RTCRayN_dir_z(rays, count, i));
        const float distance = RTCRayN_tfar(rays, count, i);
        if (is_certain(normal, way, distance, steep, query.nearest)) continue;
        if (is_false(query, primitive, way, distance)) valid[i] = 0;
    }
}

// Points sixteen rays at their targets; lanes are valid where the target is above the receiver's horizon.
GNOMON_VECTOR_CLONES
void aim(const Receiver& receiver, vec3 origin, float origin_rounding, const float* x, const float* y, const float* z,
         RTCRay16& rays, int* __restrict valid) {
    for (size_t k = 0; k < ShadowRays::packet_size; ++k) {
        const vec3 target(x[k], y[k], z[k]);
        const vec3 way = target - origin;
        valid[k] = faces(receiver, target) ? -1 : 0;
        rays.dir_x[k] = way.x;
        rays.dir_y[k] = way.y;
        rays.dir_z[k] = way.z;
        // The way is not normalised, so 1 is the target. The ray ends short of it by the rounding of its coordinates,
        // so that what touches the light from behind does not hide it.
        const float rounding = larger(origin_rounding, largest_component(target) * relative_step);
        rays.tfar[k] = larger(0.0f, 1.0f - rounding / largest_component(way));
    }
}

} // namespace

ShadowRays::ShadowRays(const ShadowCasters& casters, const Receiver& receiver, const ShadowOrigin& origin,
                       std::uint32_t own_primitive, const std::array<vec3, 3>& own_corners, bool end)
    : receiver_(receiver), rounding_(origin.rounding),
      query_{{}, end, &casters, own_primitive, own_corners, origin.position, 4 * origin.rounding, no_triangle, {}, {}} {
    start_query(query_.context);
    std::fill_n(rays_.org_x, packet_size, origin.position.x);
    std::fill_n(rays_.org_y, packet_size, origin.position.y);
    std::fill_n(rays_.org_z, packet_size, origin.position.z);
    std::fill_n(rays_.tnear, packet_size, 0.0f);
    std::fill_n(rays_.time, packet_size, 0.0f);
    std::fill_n(rays_.mask, packet_size, 0xffffffffu);
    std::fill_n(rays_.id, packet_size, 0u);
    std::fill_n(rays_.flags, packet_size, 0u);
}

ShadowRays::Mask ShadowRays::to_targets(const float* x, const float* y, const float* z, size_t count) {
    alignas(64) int valid[packet_size];
    if (count == packet_size) {
        aim(receiver_, query_.start, rounding_, x, y, z, rays_, valid);
    } else {
        float padded[3][packet_size] = {};
        std::copy_n(x, count, padded[0]);
        std::copy_n(y, count, padded[1]);
        std::copy_n(z, count, padded[2]);
        aim(receiver_, query_.start, rounding_, padded[0], padded[1], padded[2], rays_, valid);
        std::fill(valid + count, valid + packet_size, 0);
    }
    const unsigned facing = negative_lanes(valid);
    if (facing == 0) return {0, 0};
    occluded(valid, query_.casters->built, query_.context, reject_false_hits, rays_);
    return {facing & ~negative_lanes(rays_.tfar), facing};
}

bool ShadowRays::to_direction(vec3 direction) {
    alignas(64) int valid[packet_size] = {-1};
    std::fill_n(rays_.dir_x, packet_size, direction.x);
    std::fill_n(rays_.dir_y, packet_size, direction.y);
    std::fill_n(rays_.dir_z, packet_size, direction.z);
    std::fill_n(rays_.tfar, packet_size, infinity);
    occluded(valid, query_.casters->built, query_.context, reject_false_hits, rays_);
    return !(rays_.tfar[0] < 0.0f);
}

} // namespace gnomon
