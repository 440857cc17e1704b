// A ball of thin bars over a floor: every bar blocks little light, many together a lot, and single-depth techniques
// overlap them.

#include <cmath>

#include "core/builtin/builtin.h"
#include "core/primitives.h"

namespace gnomon {
namespace {

struct WireBallParams {
    int meridians = 12;
    int parallels = 9;
    float bar_radius = 0.012f;
    float light_size = 1.0f;
};
constexpr auto wire_ball_fields =
    fields(field("meridians", &WireBallParams::meridians, 1, 200, "", "circles through the poles"),
           field("parallels", &WireBallParams::parallels, 0, 200, "", "circles around the axis"),
           field("bar_radius", &WireBallParams::bar_radius, 0.0005, 0.1, "m", "radius of a bar; that of the ball is 1"),
           field("light_size", &WireBallParams::light_size, 0.001, 10, "m", "side of the square light"));

Scene build(const WireBallParams& params) {
    Scene scene;
    const std::uint32_t floor = add_material(scene, "floor", {0.72f, 0.70f, 0.66f});
    const std::uint32_t bars = add_material(scene, "bars", {0.70f, 0.36f, 0.18f});
    add_object(scene, "floor", plane_mesh({10.0f, 10.0f}, 4, 4), dmat4(1.0), floor);
    MeshData ball;
    // Bars pass one another by the poles at slightly different radii: they touch there, but no two vertices coincide.
    for (int i = 0; i < params.meridians; ++i) {
        const double radius = 1.0 - 1e-3 * i / params.meridians;
        append_mesh(ball, torus_mesh(static_cast<float>(radius), params.bar_radius, 96, 12),
                    rotation(180.0 * i / params.meridians, {0, 1, 0}) * rotation(90, {1, 0, 0}));
    }
    for (int i = 0; i < params.parallels; ++i) {
        const double polar = pi * (i + 1) / (params.parallels + 1);
        append_mesh(ball, torus_mesh(static_cast<float>(1.002 * std::sin(polar)), params.bar_radius, 96, 12),
                    translation({0, 1.002 * std::cos(polar), 0}));
    }
    add_object(scene, "ball", ball, translation({0, 1.3, 0}) * rotation(20, {1, 0, 0.3}), bars);
    Light light =
        light_for_irradiance(LightType::Rectangle, {-1.8f, 5.0f, 1.2f}, {0, 0, 0}, vec2(params.light_size), 3.6f);
    light.name = "lamp";
    scene.lights.push_back(light);
    scene.cameras.push_back(scene_camera({2.6f, 3.2f, 5.2f}, {0.2f, 0.7f, -0.1f}, 40.0f));
    return scene;
}

} // namespace

BuiltinScene wire_ball_scene() {
    return builtin_scene<WireBallParams>("wire-ball", "A ball of thin bars over a floor", wire_ball_fields, build);
}

} // namespace gnomon
