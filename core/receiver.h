#pragma once
// The points that light falls on: one per pixel, made once per frame and answered by techniques and truth alike.

#include <cstdint>

#include "core/image.h"
#include "core/light.h"
#include "core/math.h"

namespace gnomon {

inline constexpr std::uint32_t no_triangle = 0xffffffffu;

struct Receiver {
    vec3 position{0.0f};                  // float32 world position
    vec3 geometric_normal{0.0f};          // unit, turned towards the viewer
    std::uint32_t triangle = no_triangle; // index into Scene::triangles; no_triangle: the camera sees nothing here

    bool valid() const { return triangle != no_triangle; }
};

using Receivers = Image<Receiver>;

// Whether light from `point` can fall on the receiver's visible side at all. The terminator of every technique and of
// the truth is this same test on the same numbers.
inline bool faces(const Receiver& receiver, vec3 point) {
    return glm::dot(receiver.geometric_normal, point - receiver.position) > 0.0f;
}

// The same for a light seen as a point at its centre, or as a direction.
inline bool faces_light(const Receiver& receiver, const Light& light) {
    if (light.type == LightType::Directional) return glm::dot(receiver.geometric_normal, light.direction) < 0.0f;
    return faces(receiver, light.position);
}

} // namespace gnomon
