#pragma once
// What the rasterizer is timed on.

#include <optional>

#include "core/scene.h"

namespace gnomon_bench {

using namespace gnomon;

// 24 bumpy closed spheres on a floor, with smooth normals: 1,003,520 triangles, or 20,000. The first camera is the
// viewer's, the second the light's; the light is a point.
Scene spheres(bool big);
// A sheet of hills, 1,002,528 triangles.
Scene height_field();
// A shared scene with a camera and a point light above it; nothing where it is absent.
std::optional<Scene> shared_scene(const char* name);

// A square light that shines from `position` towards `target`.
Light rectangle(vec3 position, vec3 target, float side);

mat4 to_clip(const Camera& camera, int width, int height);

} // namespace gnomon_bench
