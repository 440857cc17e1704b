#include "raytrace/shadow_origin.h"

#include <cmath>

#include "raytrace/false_hits.h"

namespace gnomon {

vec3 local_shift(std::span<const vec3> points) {
    Bounds bounds;
    for (const vec3& p : points) bounds.extend(p);
    vec3 shift(0.0f);
    if (bounds.empty()) return shift;
    const float apart = 4 * largest_component(bounds.extent());
    for (int axis = 0; axis < 3; ++axis)
        if (bounds.minimum[axis] > apart || bounds.maximum[axis] < -apart) shift[axis] = bounds.center()[axis];
    return shift;
}

Receiver to_local(Receiver receiver, vec3 shift) {
    receiver.position -= shift;
    return receiver;
}

Light to_local(Light light, vec3 shift) {
    light.position -= shift;
    for (LightTriangle& t : light.triangles) t.a -= shift, t.b -= shift, t.c -= shift;
    return light;
}

// A receiver's position is a float32 point that was computed to lie on its triangle: it is off the triangle's plane by
// a few units in the last place of the largest coordinate that took part (those of the point and of the triangle's
// vertices), and Embree's distance to the plane is wrong by about as much again. 2⁻¹⁹ of that coordinate is 8 to 16
// such units: enough for both, and 20 µm in a scene of 10 m. The receiver's own triangle is excluded as well, because
// the plane of a sliver is known less well.
//
// The point was rounded in the world, which may be coarser than local coordinates: there it is put back onto the plane
// first, along the normal.
ShadowOrigin shadow_origin(const Receiver& receiver, const std::array<vec3, 3>& corners, vec3 shift) {
    float magnitude = largest_component(receiver.position), in_world = largest_component(receiver.position + shift);
    for (const vec3& corner : corners) {
        magnitude = larger(magnitude, largest_component(corner));
        in_world = larger(in_world, largest_component(corner + shift));
    }
    const float rounding = magnitude * relative_step;
    float step = rounding;
    if (in_world > magnitude) {
        const dvec3 a(corners[0]), n(receiver.geometric_normal);
        const dvec3 plane = glm::normalize(glm::cross(dvec3(corners[1]) - a, dvec3(corners[2]) - a));
        const double off = glm::dot(plane, dvec3(receiver.position) - a) / glm::dot(plane, n);
        if (std::abs(off) <= static_cast<double>(in_world * relative_step)) step -= static_cast<float>(off);
    }
    return {receiver.position + receiver.geometric_normal * step, rounding,
            larger(magnitude, in_world) * relative_step};
}

} // namespace gnomon
