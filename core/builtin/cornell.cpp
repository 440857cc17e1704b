// The Cornell box: the room, blocks, lamp and camera as measured at Cornell University's Program of Computer Graphics,
// the published millimetres divided by 100.

#include <array>

#include "core/builtin/builtin.h"
#include "core/primitives.h"
#include "core/scene_load.h"

namespace gnomon {
namespace {

struct CornellParams {
    float light_scale = 1.0f;
};
constexpr auto cornell_fields = fields(field("light_scale", &CornellParams::light_scale, 0.01, 2, "",
                                             "factor on the sides of the lamp, 1.30 m by 1.05 m"));

using Corners = std::array<vec3, 4>;

MeshData quad(const Corners& corners) {
    MeshData mesh;
    for (const vec3& corner : corners) mesh.positions.push_back(corner / 100.0f);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

// An upright block on the floor; its top as published, which runs counter-clockwise seen from above.
MeshData block(const Corners& top) {
    MeshData mesh;
    for (const float keep : {1.0f, 0.0f})
        for (const vec3& corner : top) mesh.positions.push_back(corner * vec3(1.0f, keep, 1.0f) / 100.0f);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
    for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t next = (i + 1) % 4;
        mesh.triangles.emplace_back(i, i + 4, next + 4);
        mesh.triangles.emplace_back(i, next + 4, next);
    }
    return mesh;
}

Scene build(const CornellParams& params) {
    Scene scene;
    const std::uint32_t white = add_material(scene, "white", {0.725f, 0.71f, 0.68f});
    const std::uint32_t red = add_material(scene, "red", {0.63f, 0.065f, 0.05f});
    const std::uint32_t green = add_material(scene, "green", {0.14f, 0.45f, 0.091f});
    const auto add = [&](const char* name, const MeshData& mesh, std::uint32_t material) {
        add_object(scene, name, mesh, dmat4(1.0), material);
    };
    add("floor", quad({{{552.8f, 0, 0}, {0, 0, 0}, {0, 0, 559.2f}, {549.6f, 0, 559.2f}}}), white);
    add("ceiling", quad({{{556, 548.8f, 0}, {556, 548.8f, 559.2f}, {0, 548.8f, 559.2f}, {0, 548.8f, 0}}}), white);
    add("back wall", quad({{{549.6f, 0, 559.2f}, {0, 0, 559.2f}, {0, 548.8f, 559.2f}, {556, 548.8f, 559.2f}}}), white);
    add("right wall", quad({{{0, 0, 559.2f}, {0, 0, 0}, {0, 548.8f, 0}, {0, 548.8f, 559.2f}}}), green);
    add("left wall", quad({{{552.8f, 0, 0}, {549.6f, 0, 559.2f}, {556, 548.8f, 559.2f}, {556, 548.8f, 0}}}), red);
    add("short block", block({{{130, 165, 65}, {82, 165, 225}, {240, 165, 272}, {290, 165, 114}}}), white);
    add("tall block", block({{{423, 330, 247}, {265, 330, 296}, {314, 330, 456}, {472, 330, 406}}}), white);

    Light light;
    light.name = "lamp";
    light.type = LightType::Rectangle;
    light.position = {2.78f, 5.487f, 2.795f}; // a millimetre below the ceiling, which must not hide it
    light.direction = {0, -1, 0};
    light.tangent = {1, 0, 0};
    light.size = vec2(1.30f, 1.05f) * params.light_scale;
    light.intensity = {17, 12, 4};
    add_light_surface(scene, light);
    scene.lights.push_back(light);
    // 35 mm focal length behind a film of 25 mm.
    scene.cameras.push_back(scene_camera({2.78f, 2.73f, -8.0f}, {2.78f, 2.73f, 2.8f}, 39.3077f));
    return scene;
}

} // namespace

BuiltinScene cornell_scene() {
    return builtin_scene<CornellParams>("cornell", "The Cornell box", cornell_fields, build);
}

} // namespace gnomon
