#pragma once
// Shadow rays of one receiver through Embree, sixteen at a time, without the hits that are errors of rounding.

#include <array>
#include <cstddef>
#include <cstdint>

#include "raytrace/shadow_origin.h"
#include "raytrace/shadow_query.h"

namespace gnomon {

class ShadowRays {
public:
    static constexpr std::size_t packet_size = 16;

    // `own_primitive` is that of the receiver's triangle, with its corners. Rays either end at points or have no end.
    ShadowRays(const ShadowCasters& casters, const Receiver& receiver, const ShadowOrigin& origin,
               std::uint32_t own_primitive, const std::array<vec3, 3>& own_corners, bool end);

    struct Mask {
        unsigned seen, traced; // bit k: target k
    };
    // For up to 16 targets; those below the receiver's horizon are neither seen nor traced.
    Mask to_targets(const float* x, const float* y, const float* z, std::size_t count);

    // Triangles of the scene that the rays have met since the last call, up to sixteen: a hint, for false hits and
    // repetitions are among them. How many.
    std::size_t take_met(std::array<std::uint32_t, packet_size>& triangles);

    // Whether nothing lies in a direction above the horizon.
    bool to_direction(vec3 direction);

private:
    Receiver receiver_;
    ShadowOrigin origin_;
    ShadowQuery query_;
    alignas(64) RTCRay16 rays_;
};

} // namespace gnomon
