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
      query_{{}, end, &casters, own_primitive, own_corners, origin.position, 4 * origin.rounding, {}} {
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
    occluded(valid, query_.casters->built, query_.context, false_hit_filter(), rays_);
    return {facing & ~negative_lanes(rays_.tfar), facing};
}

bool ShadowRays::to_direction(vec3 direction) {
    alignas(64) int valid[packet_size] = {-1};
    std::fill_n(rays_.dir_x, packet_size, direction.x);
    std::fill_n(rays_.dir_y, packet_size, direction.y);
    std::fill_n(rays_.dir_z, packet_size, direction.z);
    std::fill_n(rays_.tfar, packet_size, infinity);
    occluded(valid, query_.casters->built, query_.context, false_hit_filter(), rays_);
    return !(rays_.tfar[0] < 0.0f);
}

} // namespace gnomon
