#include "raytrace/shadow_origin.h"

#include "raytrace/false_hits.h"

namespace gnomon {

// A receiver's position is a float32 point that was computed to lie on its triangle: it is off the triangle's plane by
// a few units in the last place of the largest coordinate that took part (those of the point and of the triangle's
// vertices), and Embree's distance to the plane is wrong by about as much again. 2⁻¹⁹ of that coordinate is 8 to 16
// such units: enough for both, and 20 µm in a scene of 10 m. The receiver's own triangle is excluded as well, because
// the plane of a sliver is known less well.
ShadowOrigin shadow_origin(const Scene& scene, const Receiver& receiver) {
    float magnitude = largest_component(receiver.position);
    const uvec3 corners = scene.triangles[receiver.triangle];
    for (int k = 0; k < 3; ++k) magnitude = larger(magnitude, largest_component(scene.positions[corners[k]]));
    const float rounding = magnitude * relative_step;
    return {receiver.position + receiver.geometric_normal * rounding, rounding};
}

} // namespace gnomon
