// Two long rows of columns seen along their length: a large depth range, in which shadow-map texels are too many far
// away and too few close by.

#include "core/builtin/builtin.h"
#include "core/primitives.h"

namespace gnomon {
namespace {

struct ColonnadeParams {
    int columns = 40;
    float spacing = 4.0f;
    float light_size = 24.0f;
};
constexpr auto colonnade_fields =
    fields(field("columns", &ColonnadeParams::columns, 1, 1000, "", "columns in each of the two rows"),
           field("spacing", &ColonnadeParams::spacing, 1.5, 50, "m", "from column to column"),
           field("light_size", &ColonnadeParams::light_size, 0.001, 200, "m", "side of the square light"));

// A round column of 5 m between two square plates; the parts are a hair apart, so that each stays a closed mesh of its
// own.
MeshData column_mesh() {
    MeshData column = cylinder_mesh(0.38f, 0.30f, 4.4f, 40);
    column.normals.clear();
    MeshData mesh;
    append_mesh(mesh, box_mesh({-0.5f, 0.0f, -0.5f}, {0.5f, 0.25f, 0.5f}));
    append_mesh(mesh, column, translation({0, 0.251, 0}));
    append_mesh(mesh, box_mesh({-0.45f, 4.652f, -0.45f}, {0.45f, 4.95f, 0.45f}));
    return mesh;
}

Scene build(const ColonnadeParams& params) {
    Scene scene;
    const std::uint32_t pavement = add_material(scene, "pavement", {0.66f, 0.62f, 0.55f});
    const std::uint32_t marble = add_material(scene, "marble", {0.80f, 0.77f, 0.71f});
    const float length = static_cast<float>(params.columns) * params.spacing;
    const double middle = -0.5 * static_cast<double>(length - params.spacing);
    add_object(scene, "pavement", plane_mesh({24.0f, length + 20.0f}, 6, 6 * params.columns),
               translation({0, 0, middle}), pavement);
    const MeshData column = column_mesh();
    for (int row = 0; row < 2; ++row) {
        const double x = row == 0 ? -3.0 : 3.0;
        MeshData columns;
        for (int i = 0; i < params.columns; ++i)
            append_mesh(columns, column, translation({x, 0.001, -static_cast<double>(params.spacing) * i}));
        add_object(scene, row == 0 ? "left columns" : "right columns", columns, dmat4(1.0), marble);
        add_object(scene, row == 0 ? "left beam" : "right beam",
                   box_mesh({-0.5f, 4.953f, -0.5f * length}, {0.5f, 5.6f, 0.5f * length}), translation({x, 0, middle}),
                   marble);
    }
    const auto z = static_cast<float>(middle);
    Light light =
        light_for_irradiance(LightType::Rectangle, {-0.7f * length - 60.0f, 0.8f * length + 80.0f, z + 0.3f * length},
                             {0, 0, z}, vec2(params.light_size), 3.6f);
    light.name = "sun";
    scene.lights.push_back(light);
    scene.cameras.push_back(scene_camera({0.6f, 2.2f, 7.5f}, {0.0f, 1.9f, -20.0f}, 50.0f));
    return scene;
}

} // namespace

BuiltinScene colonnade_scene() {
    return builtin_scene<ColonnadeParams>("colonnade", "Two long rows of columns", colonnade_fields, build);
}

} // namespace gnomon
