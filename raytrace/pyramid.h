#pragma once
// The bundle of shadow rays from one receiver to all points of an area light: a pyramid with its apex at the rays'
// origin over the parallelogram that the light's points lie in. Proofs about the pyramid hold for every one of the
// rays, whatever pattern the points are taken from.
//
// Rounding is part of it. u = 2⁻²⁴ is float's unit; "slack" is how far a ray may leave the ideal pyramid because the
// light's points and the ray's direction are rounded, and the margins of the tests are bounds of what both we and
// Embree round away, derived where they are used.

#include "core/light.h"
#include "core/receiver.h"
#include "raytrace/embree_scene.h"
#include "raytrace/false_hits.h"

namespace gnomon {

// Proofs that nothing is in between keep twice the distance at which EmbreeScene still accepts hits.
inline constexpr float proof_growth = 2 * box_growth;

// A pyramid's parallelogram is larger than the light, about the same centre: proofs about what is beside a part of the
// light (see silhouettes.h) need to look beyond its border.
inline constexpr float light_growth = 1.0f + 0x1p-6f;

// The parallelogram center ± a ± b around the points of light_points() for one receiver, and how much float rounds
// those in each coordinate. Not usable for proofs: a mesh, whose points it does not hold, and a sphere seen from within
// or nearly so.
struct LightFrame {
    dvec3 center, a, b;
    dvec3 rounding;
    bool usable = true;
};
// The largest distance of points center ± a ± b from the origin.
double farthest_point(dvec3 center, dvec3 a, dvec3 b);

LightFrame light_frame(const Light& light, vec3 receiver);

struct Pyramid {
    vec3 origin;
    // Relative to the origin: the light's points are center + s·axis_a + t·axis_b with s, t in [−1, 1] / light_growth,
    // give or take `slack` in each coordinate. `reach` bounds each coordinate of all ways.
    vec3 center, axis_a, axis_b, slack, reach;
    float longest;                  // way, in length
    vec3 own[3];                    // corners of the receiver's triangle
    float own_distance;             // above that of some point of it from the origin, along every axis
    float end_minimum, end_maximum; // where rays end, as a part of the way to the light's point
    // For a point p, relative to the origin: height·p is 1 in the light's plane and 0 in the parallel one through the
    // origin, and p meets the light's plane at s = (to_a·p) / (height·p) − center_a; t likewise.
    vec3 height, to_a, to_b;
    float center_a, center_b;
    // What s and t of a light's point, as computed with height·p = 1, may be wrong by.
    float wrong_a, wrong_b;
    float wrong_height; // how far height·d may be off 1 for the way d of a ray
    float growth;       // how far to stay away: proof_growth of the largest coordinate of origin and light
    // A point p inside has normal·p ≤ offset for each; Σ|normal| = 1.
    static constexpr int planes = 7;
    vec3 normal[planes];
    float offset[planes];

    bool all_face = false;   // every point of the light is above the receiver's horizon
    bool none_faces = false; // none is
    bool usable =
        false; // otherwise nothing but the two above holds: the light is seen edge-on, or surrounds the receiver
};

Pyramid pyramid_of(const Light& light, const Receiver& receiver, const ShadowOrigin& origin,
                   const std::array<vec3, 3>& own_corners);

// The corners of a box around all points of an area light, whatever the receiver.
Bounds light_bounds(const Light& light);

} // namespace gnomon
