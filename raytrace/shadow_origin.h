#pragma once
// Where a receiver's shadow rays start: off its surface by what is rounded, so that they do not meet it again. What is
// rounded grows with the coordinates, so a scene far from the origin is traced in coordinates of its own.

#include <array>
#include <span>

#include "core/light.h"
#include "core/receiver.h"
#include "core/scene.h"

namespace gnomon {

// What to subtract from positions of the world to get local ones: 0 but on axes along which all of the points lie at
// least four times as far from the origin as they are apart on any axis. There all points lie within a quarter of the
// shift, so that the difference is exact [Sterbenz 1974].
vec3 local_shift(std::span<const vec3> points);

// The same receiver and light in local coordinates.
Receiver to_local(Receiver receiver, vec3 shift);
Light to_local(Light light, vec3 shift);

struct ShadowOrigin {
    vec3 position;
    float rounding;       // metres that separate "touching" from "in front of" here
    float world_rounding; // the same for coordinates of the world: how far the receiver may be off its triangle
};

// Of a local receiver on its triangle.
ShadowOrigin shadow_origin(const Receiver& receiver, const std::array<vec3, 3>& corners, vec3 shift);

} // namespace gnomon
