#pragma once
// Where a receiver's shadow rays start: off its surface by what is rounded, so that they do not meet it again.

#include "core/receiver.h"
#include "core/scene.h"

namespace gnomon {

struct ShadowOrigin {
    vec3 position;
    float rounding; // metres that separate "touching" from "in front of" here
};

ShadowOrigin shadow_origin(const Scene& scene, const Receiver& receiver);

} // namespace gnomon
