// Plates one above another: several occluders along every ray to the light, where filtered depth distributions let
// light bleed through and single-layer techniques mistake one penumbra for another.

#include "core/builtin/builtin.h"
#include "core/primitives.h"

namespace gnomon {
namespace {

struct StackedPlatesParams {
    int plates = 4;
    float gap = 0.45f;
    float light_size = 1.5f;
};
constexpr auto stacked_plates_fields =
    fields(field("plates", &StackedPlatesParams::plates, 1, 50, "", "plates over the floor"),
           field("gap", &StackedPlatesParams::gap, 0.05, 5, "m", "from plate to plate"),
           field("light_size", &StackedPlatesParams::light_size, 0.001, 10, "m", "side of the square light"));

Scene build(const StackedPlatesParams& params) {
    Scene scene;
    const std::uint32_t floor = add_material(scene, "floor", {0.74f, 0.72f, 0.68f});
    const std::uint32_t odd = add_material(scene, "odd plates", {0.66f, 0.30f, 0.20f});
    const std::uint32_t even = add_material(scene, "even plates", {0.25f, 0.40f, 0.46f});
    add_object(scene, "floor", plane_mesh({12.0f, 12.0f}, 4, 4), dmat4(1.0), floor);
    for (int i = 0; i < params.plates; ++i) {
        // Smaller and turned further with height, so that every plate shows its rim and casts on the one below.
        const float half = 1.3f / (1.0f + 0.28f * static_cast<float>(i));
        add_object(scene, "plate " + std::to_string(i + 1), box_mesh({-half, 0.0f, -half}, {half, 0.03f, half}),
                   translation({0.12 * i, static_cast<double>(params.gap) * (i + 1), -0.05 * i}) *
                       rotation(17.0 * i, {0, 1, 0}),
                   i % 2 == 0 ? odd : even);
    }
    const float top = params.gap * static_cast<float>(params.plates);
    Light light =
        light_for_irradiance(LightType::Rectangle, {-2.2f, top + 3.6f, 1.6f}, {0, 0, 0}, vec2(params.light_size), 3.6f);
    light.name = "lamp";
    scene.lights.push_back(light);
    const float reach = 5.4f + top;
    scene.cameras.push_back(
        scene_camera({0.5f * reach, 0.45f * reach + 0.2f, 0.9f * reach}, {0.1f, 0.35f * top, 0.0f}, 38.0f));
    return scene;
}

} // namespace

BuiltinScene stacked_plates_scene() {
    return builtin_scene<StackedPlatesParams>("stacked-plates", "Plates one above another", stacked_plates_fields,
                                              build);
}

} // namespace gnomon
