// Thin, regular occluders: pickets and wires whose shadows alias where a shadow map's texels are wider than they are.

#include <algorithm>

#include "core/builtin/builtin.h"
#include "core/primitives.h"

namespace gnomon {
namespace {

struct FenceParams {
    int pickets = 48;
    int wires = 9;
    float picket_width = 0.05f;
    float wire_radius = 0.004f;
    float light_size = 0.8f;
};
constexpr auto fence_fields =
    fields(field("pickets", &FenceParams::pickets, 2, 2000, "", "pickets of the wooden fence"),
           field("wires", &FenceParams::wires, 1, 500, "", "horizontal wires of the wire fence"),
           field("picket_width", &FenceParams::picket_width, 0.001, 0.5, "m", "width of a picket"),
           field("wire_radius", &FenceParams::wire_radius, 0.0005, 0.05, "m", "radius of a wire"),
           field("light_size", &FenceParams::light_size, 0.001, 10, "m", "side of the square light"));

constexpr float width = 6.0f;

MeshData pickets(const FenceParams& params) {
    MeshData mesh;
    for (int i = 0; i < params.pickets; ++i) {
        const float x = width * ((static_cast<float>(i) + 0.5f) / static_cast<float>(params.pickets) - 0.5f);
        const float half = 0.5f * params.picket_width, top = 1.0f, tip = top + params.picket_width;
        // A board with a pointed top: a box whose lid is a roof.
        MeshData board;
        board.positions = {{x - half, 0, 0}, {x + half, 0, 0}, {x + half, top, 0}, {x, tip, 0}, {x - half, top, 0}};
        for (int k = 0; k < 5; ++k)
            board.positions.push_back(board.positions[static_cast<size_t>(k)] - vec3(0, 0, 0.02f));
        board.triangles = {{0, 1, 2}, {0, 2, 4}, {4, 2, 3}, {6, 5, 7}, {5, 9, 7}, {9, 8, 7}};
        for (std::uint32_t k = 0; k < 5; ++k) {
            const std::uint32_t next = (k + 1) % 5;
            board.triangles.emplace_back(k, k + 5, next + 5);
            board.triangles.emplace_back(k, next + 5, next);
        }
        append_mesh(mesh, board);
    }
    for (const float y : {0.25f, 0.75f})
        append_mesh(mesh, box_mesh({-0.5f * width, y, -0.051f}, {0.5f * width, y + 0.07f, -0.021f}));
    return mesh;
}

MeshData wire_fence(const FenceParams& params) {
    MeshData mesh;
    for (int post = 0; post <= 4; ++post) {
        const float x = width * (static_cast<float>(post) / 4.0f - 0.5f);
        append_mesh(mesh, rod_mesh({x, 0.0f, 0.05f}, {x, 1.25f, 0.05f}, 0.03f, 24));
    }
    for (int i = 0; i < params.wires; ++i) {
        const float y = 1.2f * (static_cast<float>(i) + 1.0f) / static_cast<float>(params.wires);
        append_mesh(mesh, rod_mesh({-0.5f * width, y, 0.0f}, {0.5f * width, y, 0.0f}, params.wire_radius, 8));
    }
    return mesh;
}

Scene build(const FenceParams& params) {
    Scene scene;
    const std::uint32_t ground = add_material(scene, "ground", {0.62f, 0.62f, 0.55f});
    const std::uint32_t wood = add_material(scene, "wood", {0.55f, 0.40f, 0.26f});
    const std::uint32_t steel = add_material(scene, "steel", {0.45f, 0.48f, 0.52f});
    add_object(scene, "ground", plane_mesh({12.0f, 12.0f}, 4, 4), dmat4(1.0), ground);
    add_object(scene, "pickets", pickets(params), translation({0, 0.02, -1.6}), wood);
    add_object(scene, "wires", wire_fence(params), translation({0, 0.001, 1.0}), steel);
    Light light =
        light_for_irradiance(LightType::Rectangle, {-3.0f, 5.0f, -5.5f}, {0, 0, 0}, vec2(params.light_size), 3.6f);
    light.name = "lamp";
    scene.lights.push_back(light);
    scene.cameras.push_back(scene_camera({3.2f, 2.6f, 6.2f}, {0.0f, 0.25f, 0.1f}, 40.0f));
    return scene;
}

} // namespace

BuiltinScene fence_scene() {
    return builtin_scene<FenceParams>("fence", "A picket fence and a wire fence", fence_fields, build);
}

} // namespace gnomon
