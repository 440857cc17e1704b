// Stairs between a railing of thin rods and a thin wall: shadows that break at every edge of a step, and light that
// leaks past the wall where it stands on the stairs.

#include "core/builtin/builtin.h"
#include "core/primitives.h"

namespace gnomon {
namespace {

struct StaircaseParams {
    int steps = 10;
    float wall_thickness = 0.01f;
    float light_size = 1.0f;
};
constexpr auto staircase_fields =
    fields(field("steps", &StaircaseParams::steps, 2, 200, "", "number of steps"),
           field("wall_thickness", &StaircaseParams::wall_thickness, 0.0005, 0.2, "m",
                 "thickness of the wall beside the stairs"),
           field("light_size", &StaircaseParams::light_size, 0.001, 10, "m", "side of the square light"));

constexpr float tread = 0.30f, rise = 0.17f, width = 1.6f;

// One closed mesh: two sides of columns under the treads, and the skin between them.
MeshData stairs_mesh(int steps) {
    MeshData mesh;
    const auto vertex = [&](float x, float y, bool front) {
        mesh.positions.emplace_back(x, y, front ? 0.5f * width : -0.5f * width);
        return static_cast<std::uint32_t>(mesh.positions.size() - 1);
    };
    const auto add_side = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, bool front) {
        if (front)
            mesh.triangles.emplace_back(a, b, c);
        else
            mesh.triangles.emplace_back(a, c, b);
    };
    const auto add_strip = [&](vec2 from, vec2 to) { // faces right of the way from `from` to `to`, seen from the front
        const std::uint32_t a = vertex(from.x, from.y, true), b = vertex(to.x, to.y, true);
        const std::uint32_t c = vertex(to.x, to.y, false), d = vertex(from.x, from.y, false);
        mesh.triangles.emplace_back(a, d, c);
        mesh.triangles.emplace_back(a, c, b);
    };
    for (int i = 0; i < steps; ++i) {
        const float left = tread * static_cast<float>(i), right = tread * static_cast<float>(i + 1);
        const float before = rise * static_cast<float>(i), height = rise * static_cast<float>(i + 1);
        for (const bool front : {true, false}) {
            // A fan, because the step before ends on this one's left side and must find a vertex there.
            const std::uint32_t corner = vertex(right, 0, front), top = vertex(right, height, front);
            const std::uint32_t edge = vertex(left, height, front), base = vertex(left, 0, front);
            add_side(corner, top, edge, front);
            if (i == 0) {
                add_side(corner, edge, base, front);
            } else {
                const std::uint32_t joint = vertex(left, before, front);
                add_side(corner, edge, joint, front);
                add_side(corner, joint, base, front);
            }
        }
        add_strip({left, 0}, {right, 0});           // underside
        add_strip({left, height}, {left, before});  // riser
        add_strip({right, height}, {left, height}); // tread
    }
    const float end = tread * static_cast<float>(steps);
    add_strip({end, 0}, {end, rise * static_cast<float>(steps)}); // back
    return mesh;
}

MeshData railing_mesh(int steps) {
    MeshData mesh;
    const float z = 0.5f * width - 0.08f;
    for (int i = 0; i < steps; ++i) {
        const float x = tread * (static_cast<float>(i) + 0.5f), y = rise * static_cast<float>(i + 1);
        append_mesh(mesh, rod_mesh({x, y + 0.001f, z}, {x, y + 0.9f, z}, 0.012f, 16));
    }
    const float first = 0.5f * tread, last = tread * (static_cast<float>(steps) - 0.5f);
    append_mesh(mesh,
                rod_mesh({first - 0.1f, rise + 0.93f - 0.1f * rise / tread, z},
                         {last + 0.1f, rise * static_cast<float>(steps) + 0.93f + 0.1f * rise / tread, z}, 0.025f, 24));
    return mesh;
}

Scene build(const StaircaseParams& params) {
    Scene scene;
    const std::uint32_t ground = add_material(scene, "ground", {0.60f, 0.58f, 0.54f});
    const std::uint32_t stone = add_material(scene, "stone", {0.74f, 0.69f, 0.60f});
    const std::uint32_t iron = add_material(scene, "iron", {0.22f, 0.24f, 0.27f});
    const std::uint32_t plaster = add_material(scene, "plaster", {0.76f, 0.56f, 0.42f});
    const float length = tread * static_cast<float>(params.steps), height = rise * static_cast<float>(params.steps);
    const dvec3 centered(-0.5 * static_cast<double>(length), 0.0, 0.0);
    add_object(scene, "ground", plane_mesh({length + 6.0f, 8.0f}, 6, 6), dmat4(1.0), ground);
    add_object(scene, "stairs", stairs_mesh(params.steps), translation(centered + dvec3(0, 0.001, 0)), stone);
    add_object(scene, "railing", railing_mesh(params.steps), translation(centered), iron);
    const float z = -0.5f * width - params.wall_thickness - 0.002f;
    add_object(scene, "wall", box_mesh({-0.4f, 0.0f, z}, {length, height + 1.1f, z + params.wall_thickness}),
               translation(centered + dvec3(0, 0.001, 0)), plaster);
    Light light = light_for_irradiance(LightType::Rectangle, {-0.6f * length, height + 3.2f, 3.6f},
                                       {0, 0.5f * height, 0}, vec2(params.light_size), 3.6f);
    light.name = "lamp";
    scene.lights.push_back(light);
    const float reach = 1.2f * length + 1.4f;
    scene.cameras.push_back(
        scene_camera({-0.75f * reach, 0.65f * reach, 0.95f * reach}, {0.0f, 0.4f * height, 0.0f}, 38.0f));
    return scene;
}

} // namespace

BuiltinScene staircase_scene() {
    return builtin_scene<StaircaseParams>("staircase", "Stairs with a railing and a thin wall", staircase_fields,
                                          build);
}

} // namespace gnomon
