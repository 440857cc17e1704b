#pragma once
// What Embree's filter for shadow rays needs to know in order to take false hits out.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
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
    vec3 shift{0.0f}; // of local coordinates, which built has
    RTCScene built = nullptr;
    std::vector<std::uint32_t> triangles; // primitive to Scene::triangles; empty where the numbers are the same
    std::vector<float> steep;             // per primitive, see steep_hit

    std::array<vec3, 3> corners(std::uint32_t primitive) const {
        const uvec3 t = scene.triangles[triangles.empty() ? primitive : triangles[primitive]];
        return {scene.positions[t.x] - shift, scene.positions[t.y] - shift, scene.positions[t.z] - shift};
    }
};

// A triangle that was hit, seen from where the rays start. A hit is certainly none of the false ones where it lies in
// the triangle's box, grown by half of what the rule allows, and the ray starts farther from the triangle's plane than
// the receiver's own triangle can be off it, and ends beyond that plane: away·way > from_plane + off_plane·|way|, with
// the way's largest component for |way|.
struct LookedAt {
    std::uint32_t primitive = no_triangle;
    HitTriangle triangle;
    std::optional<RelativeSides> own; // where the receiver's triangle lies; worked out when first asked for
    vec3 half, away;
    float from_plane, off_plane;
};

// Embree hands the context back to a filter, so what the filter needs to know follows it in memory.
struct ShadowQuery {
    QueryContext context;
    bool ends; // whether its rays have an end: lights at a distance
    const ShadowCasters* casters;
    std::uint32_t own_primitive;
    std::array<vec3, 3> own_corners;
    vec3 start;
    float nearest;                       // what starts nearer to a plane may start in it
    std::array<LookedAt, 32> looked_at{}; // a primitive has one place: neighbouring packets meet it again
    std::array<std::uint32_t, 16> met{}; // primitives, the last ones first to be forgotten
    unsigned met_count = 0;              // in all
};

LookedAt& look_at(ShadowQuery& query, std::uint32_t primitive);

// Of a ray of the query that goes along `way`.
bool is_false_hit(ShadowQuery& query, std::uint32_t primitive, vec3 way);

struct ShadowKernels {
    // Asks the two of all hits that are not plainly true.
    RTCFilterFunctionN filter;

    // Points sixteen rays at their targets. Bit k and valid[k] = -1: target k is above the receiver's horizon.
    unsigned (*aim)(const Receiver& receiver, const ShadowOrigin& origin, const float* x, const float* y,
                    const float* z, RTCRay16& rays, int* valid);

    // Bit k: ray k met something.
    unsigned (*hidden)(const RTCRay16& rays);
};
const ShadowKernels& shadow_kernels();

} // namespace gnomon
