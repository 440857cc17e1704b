// A half-plane between a square light and a floor: the penumbra has a closed form. With light height H, edge height b
// and light width w, the visible fraction at x on the floor rises linearly over the width w·b/(H − b) around the edge's
// projection.

#include <algorithm>
#include <cmath>

#include "core/builtin/builtin.h"
#include "core/primitives.h"

namespace gnomon {
namespace {

struct HalfPlaneParams {
    float slope = 0.0f;
    float light_size = 2.0f;
    float light_height = 4.0f;
    float edge_height = 2.0f;
};
constexpr auto half_plane_fields = fields(
    field("slope", &HalfPlaneParams::slope, -4, 4, "", "dx/dz of the edge in plan; the blocker covers x < slope·z"),
    field("light_size", &HalfPlaneParams::light_size, 0.001, 10, "m", "side of the square light"),
    field("light_height", &HalfPlaneParams::light_height, 0.1, 100, "m", "height of the light over the floor"),
    field("edge_height", &HalfPlaneParams::edge_height, 0.01, 99, "m", "height of the blocker over the floor"));

Scene build(const HalfPlaneParams& params) {
    if (params.edge_height >= params.light_height)
        throw UsageError("builtin scene 'half-plane': parameter 'edge_height' must be below 'light_height'");
    Scene scene;
    const std::uint32_t floor = add_material(scene, "floor", vec3(0.8f));
    const std::uint32_t blocker = add_material(scene, "blocker", {0.5f, 0.32f, 0.2f});
    // Between a point of the floor and one of the light, no ray leaves the square of half side `reach`: over it the
    // blocker is as good as infinite, and the scene stays small.
    constexpr float half = 4.0f;
    add_object(scene, "floor", plane_mesh(vec2(2.0f * half)), dmat4(1.0), floor);
    const float b = params.edge_height, reach = std::max(half, 0.5f * params.light_size) + 0.1f;
    const float shift = params.slope * reach, far_side = -reach - std::abs(shift);
    MeshData sheet;
    sheet.positions = {{-shift, b, -reach}, {far_side, b, -reach}, {far_side, b, reach}, {shift, b, reach}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
    add_object(scene, "half-plane", sheet, dmat4(1.0), blocker);

    Light light;
    light.name = "square";
    light.type = LightType::Rectangle;
    light.position = {0.0f, params.light_height, 0.0f};
    light.direction = {0.0f, -1.0f, 0.0f};
    light.tangent = {1.0f, 0.0f, 0.0f};
    light.size = vec2(params.light_size);
    light.intensity = vec3(1.0f); // radiance 1, as the closed forms are stated
    scene.lights.push_back(light);
    // Below the blocker, which would hide the floor.
    scene.cameras.push_back(scene_camera({2.5f, 0.75f * b, 7.0f}, {0.3f, 0.0f, 0.0f}, 40.0f));
    return scene;
}

} // namespace

BuiltinScene half_plane_scene() {
    return builtin_scene<HalfPlaneParams>("half-plane", "A straight edge between a square light and a floor",
                                          half_plane_fields, build);
}

} // namespace gnomon
