// The scene one gets without asking: kinds of occluder that shadow techniques are known to fail on, side by side.
// Contact shadows (boxes, pedestal), wide penumbrae (the tall rods, the arch), thin and regular occluders (screen,
// rods), self-shadowing on curved surfaces (sphere, torus) and light leaking where a thin sheet stands on the ground.

#include <array>
#include <cmath>

#include "core/builtin/builtin.h"
#include "core/primitives.h"

namespace gnomon {
namespace {

struct DefaultParams {
    float light_size = 1.6f;
    float detail = 1.0f;
};
constexpr auto default_fields =
    fields(field("light_size", &DefaultParams::light_size, 0.001, 20, "m", "side of the square light"),
           field("detail", &DefaultParams::detail, 0.1, 8, "", "factor on the number of faces along every curve"));

// A folding screen: two frames at an angle, each filled with upright slats.
MeshData screen_mesh() {
    MeshData screen;
    constexpr float height = 1.7f, width = 1.3f;
    for (int panel = 0; panel < 2; ++panel) {
        MeshData frame;
        append_mesh(frame, box_mesh({0.0f, 0.0f, -0.03f}, {0.05f, height, 0.03f}));
        append_mesh(frame, box_mesh({width - 0.05f, 0.0f, -0.03f}, {width, height, 0.03f}));
        append_mesh(frame, box_mesh({0.06f, 0.12f, -0.025f}, {width - 0.06f, 0.18f, 0.025f}));
        append_mesh(frame, box_mesh({0.06f, height - 0.1f, -0.025f}, {width - 0.06f, height - 0.04f, 0.025f}));
        for (int i = 0; i < 24; ++i) {
            const float x = 0.08f + 0.049f * static_cast<float>(i);
            append_mesh(frame, box_mesh({x, 0.185f, -0.008f}, {x + 0.016f, height - 0.105f, 0.008f}));
        }
        append_mesh(screen, frame,
                    panel == 0 ? rotation(12, {0, 1, 0}) : rotation(168, {0, 1, 0}) * translation({0.07, 0, 0}));
    }
    return screen;
}

// Half a circle of bent tube standing on its two ends.
MeshData arch_mesh(float radius, float tube_radius, int segments, int sides) {
    std::vector<vec3> points;
    for (int i = 0; i <= segments; ++i) {
        const double angle = pi * i / segments;
        points.emplace_back(radius * std::cos(angle), 0.02 + 1.35 * radius * std::sin(angle), 0.0);
    }
    const std::vector<float> radii(points.size(), tube_radius);
    return tube_mesh(points, radii, sides);
}

Scene build(const DefaultParams& params) {
    const auto count = [&](int n) {
        return std::max(6, static_cast<int>(std::lround(static_cast<float>(n) * params.detail)));
    };
    Scene scene;
    const std::uint32_t sand = add_material(scene, "sand", {0.76f, 0.68f, 0.56f});
    const std::uint32_t stone = add_material(scene, "stone", {0.72f, 0.70f, 0.66f});
    const std::uint32_t clay = add_material(scene, "clay", {0.70f, 0.33f, 0.20f});
    const std::uint32_t wood = add_material(scene, "wood", {0.46f, 0.28f, 0.15f});
    const std::uint32_t brass = add_material(scene, "brass", {0.78f, 0.56f, 0.24f});
    const std::uint32_t slate = add_material(scene, "slate", {0.24f, 0.33f, 0.38f});
    const dmat4 here(1.0);

    add_object(scene, "ground", plane_mesh({14.0f, 14.0f}, 8, 8), here, sand);
    // A sphere on a pedestal of three drums.
    MeshData pedestal = cylinder_mesh(0.50f, 0.50f, 0.12f, count(96));
    append_mesh(pedestal, cylinder_mesh(0.36f, 0.32f, 0.62f, count(96)), translation({0, 0.121, 0}));
    append_mesh(pedestal, cylinder_mesh(0.46f, 0.46f, 0.08f, count(96)), translation({0, 0.742, 0}));
    add_object(scene, "pedestal", pedestal, translation({-0.4, 0.001, 0.1}), stone);
    add_object(scene, "sphere", sphere_mesh(0.42f, count(128), count(64)), translation({-0.4, 1.244, 0.1}), clay);
    add_object(scene, "screen", screen_mesh(), translation({-1.2, 0.0, -1.25}) * rotation(8, {0, 1, 0}), wood);
    add_object(scene, "torus", torus_mesh(0.42f, 0.13f, count(128), count(40)),
               translation({1.05, 0.50, 0.9}) * rotation(24, {0, 1, 0}) * rotation(68, {1, 0, 0}), brass);
    add_object(scene, "arch", arch_mesh(0.95f, 0.06f, count(96), count(24)),
               translation({1.9, 0.0, -0.7}) * rotation(-35, {0, 1, 0}), slate);
    // Blocks of different heights, and a thin sheet that stands on the ground.
    add_object(scene, "low block", box_mesh({-0.4f, 0.0f, -0.3f}, {0.4f, 0.22f, 0.3f}),
               translation({0.35, 0.001, 1.75}) * rotation(15, {0, 1, 0}), stone);
    add_object(scene, "middle block", box_mesh({-0.22f, 0.0f, -0.22f}, {0.22f, 0.55f, 0.22f}),
               translation({-1.55, 0.001, 0.95}) * rotation(-20, {0, 1, 0}), slate);
    add_object(scene, "tall block", box_mesh({-0.16f, 0.0f, -0.16f}, {0.16f, 1.15f, 0.16f}),
               translation({-2.05, 0.001, 0.25}) * rotation(35, {0, 1, 0}), clay);
    add_object(scene, "sheet", box_mesh({-0.5f, 0.0f, -0.004f}, {0.5f, 0.6f, 0.004f}),
               translation({2.25, 0.0, 0.85}) * rotation(-60, {0, 1, 0}), brass);
    // Rods that lean over the scene, thin against their distance from the ground.
    MeshData rods;
    for (int i = 0; i < 7; ++i) {
        const float x = -0.25f + 0.16f * static_cast<float>(i);
        append_mesh(rods, rod_mesh({x, 0.0f, 1.05f}, {x + 0.25f - 0.05f * static_cast<float>(i), 1.3f, 0.75f}, 0.009f,
                                   count(16)));
    }
    add_object(scene, "rods", rods, translation({-0.75, 0.001, 0.55}), wood);

    Light light = light_for_irradiance(LightType::Rectangle, {-3.2f, 5.2f, 2.6f}, {0.0f, 0.4f, 0.0f},
                                       vec2(params.light_size), 3.6f);
    light.name = "lamp";
    light.intensity *= vec3(1.0f, 0.95f, 0.86f);
    scene.lights.push_back(light);
    scene.cameras.push_back(scene_camera({2.1f, 3.0f, 5.9f}, {0.05f, 0.45f, 0.0f}, 36.0f));
    return scene;
}

} // namespace

BuiltinScene default_scene() {
    return builtin_scene<DefaultParams>(
        "default", "A still life of shadows: sphere, torus, arch, screen, rods and blocks", default_fields, build);
}

} // namespace gnomon
