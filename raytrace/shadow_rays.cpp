#include "raytrace/shadow_rays.h"

#include <algorithm>

namespace gnomon {

ShadowRays::ShadowRays(const ShadowCasters& casters, const Receiver& receiver, const ShadowOrigin& origin,
                       std::uint32_t own_primitive, const std::array<vec3, 3>& own_corners, bool end)
    : receiver_(receiver),
      origin_(origin), query_{{}, end, &casters, own_primitive, own_corners, origin.position, 4 * origin.world_rounding,
                              {}, {},  0} {
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
    const ShadowKernels& kernels = shadow_kernels();
    alignas(64) int valid[packet_size];
    unsigned facing = 0;
    if (count == packet_size) {
        facing = kernels.aim(receiver_, origin_, x, y, z, rays_, valid);
    } else {
        float padded[3][packet_size] = {};
        std::copy_n(x, count, padded[0]);
        std::copy_n(y, count, padded[1]);
        std::copy_n(z, count, padded[2]);
        facing = kernels.aim(receiver_, origin_, padded[0], padded[1], padded[2], rays_, valid) & ((1u << count) - 1u);
        std::fill(valid + count, valid + packet_size, 0);
    }
    if (facing == 0) return {0, 0};
    occluded(valid, query_.casters->built, query_.context, kernels.filter, rays_);
    return {facing & ~kernels.hidden(rays_), facing};
}

std::size_t ShadowRays::take_met(std::array<std::uint32_t, packet_size>& triangles) {
    const std::size_t count = std::min<std::size_t>(query_.met_count, query_.met.size());
    const std::vector<std::uint32_t>& names = query_.casters->triangles;
    for (std::size_t i = 0; i < count; ++i) triangles[i] = names.empty() ? query_.met[i] : names[query_.met[i]];
    query_.met_count = 0;
    return count;
}

bool ShadowRays::to_direction(vec3 direction) {
    alignas(64) int valid[packet_size] = {-1};
    std::fill_n(rays_.dir_x, packet_size, direction.x);
    std::fill_n(rays_.dir_y, packet_size, direction.y);
    std::fill_n(rays_.dir_z, packet_size, direction.z);
    std::fill_n(rays_.tfar, packet_size, infinity);
    occluded(valid, query_.casters->built, query_.context, shadow_kernels().filter, rays_);
    return !(rays_.tfar[0] < 0.0f);
}

} // namespace gnomon
