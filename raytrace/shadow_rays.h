#pragma once
// Shadow rays of one receiver through Embree, sixteen at a time, without the hits that are errors of rounding.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/receiver.h"
#include "core/scene.h"
#include "raytrace/embree_api.h"
#include "raytrace/false_hits.h"
#include "raytrace/shadow_origin.h"

namespace gnomon {

// What shadow rays may meet.
struct ShadowCasters {
    const Scene& scene;
    RTCScene built = nullptr;
    std::vector<std::uint32_t> triangles; // primitive to Scene::triangles; empty where the numbers are the same
    std::vector<float> steep;             // per primitive, see steep_hit

    std::array<vec3, 3> corners(std::uint32_t primitive) const {
        const uvec3 t = scene.triangles[triangles.empty() ? primitive : triangles[primitive]];
        return {scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]};
    }
};

// Embree hands the context back to a filter, so what the filter needs to know follows it in memory.
struct ShadowQuery {
    QueryContext context;
    bool ends; // whether its rays have an end: lights at a distance
    const ShadowCasters* casters;
    std::uint32_t own_primitive;
    std::array<vec3, 3> own_corners;
    vec3 start;
    float nearest;           // what starts nearer to a plane may start in it
    std::uint32_t looked_at; // primitive of `triangle`: neighbouring packets meet it again
    HitTriangle triangle;
    RelativeSides sides;
};

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

    // Whether nothing lies in a direction above the horizon.
    bool to_direction(vec3 direction);

private:
    Receiver receiver_;
    float rounding_;
    ShadowQuery query_;
    alignas(64) RTCRay16 rays_;
};

} // namespace gnomon
