#pragma once
// What every technique is judged by: hard visibility by one ray, area-light visibility by N.

#include "core/image.h"
#include "core/receiver.h"
#include "raytrace/embree_scene.h"
#include "raytrace/pattern.h"

namespace gnomon {

class Progress;

// Visibility is 1 where the camera sees nothing, and 0 where the receiver's geometric normal does not face the light
// point.

// One ray from each receiver to the light's centre (or against its direction): 1 seen, 0 not.
Image<float> hard_visibility(const EmbreeScene& scene, const Receivers& receivers, const Light& light);

// The fraction of `samples` points of the light that each receiver sees, in a fixed order of summation (integers). A
// punctual light has one point, so this is hard_visibility then. `progress` may be null; it advances by one a row.
Image<float> area_visibility(const EmbreeScene& scene, const Receivers& receivers, const Light& light, Pattern pattern,
                             int samples, std::uint32_t seed, Progress* progress);

} // namespace gnomon
