#include "bench/scenes.h"

#include <cmath>
#include <filesystem>

#include "core/primitives.h"
#include "core/random.h"

namespace gnomon_bench {
namespace {

// A point of a closed surface around the origin: a sphere with waves that vanish at the poles.
dvec3 bumpy(double polar, double azimuth, double phase1, double phase2) {
    const double s = std::sin(polar);
    const double radius = 1 + 0.10 * std::sin(5 * azimuth + phase1) * s * std::sin(4 * polar + phase2) +
                          0.02 * std::sin(17 * polar + phase1) * s * std::cos(13 * azimuth + phase2);
    return radius * dvec3(s * std::cos(azimuth), std::cos(polar), s * std::sin(azimuth));
}

// 2·slices·(stacks − 1) triangles, wound outwards.
MeshData bumpy_sphere(vec3 center, float radius, double phase1, double phase2, unsigned slices, unsigned stacks) {
    MeshData mesh;
    const auto add = [&](double polar, double azimuth) {
        mesh.positions.push_back(center + radius * vec3(bumpy(polar, azimuth, phase1, phase2)));
    };
    add(0, 0);
    for (unsigned j = 1; j < stacks; ++j)
        for (unsigned i = 0; i < slices; ++i) add(pi * j / stacks, 2 * pi * i / slices);
    add(pi, 0);
    const auto at = [&](unsigned j, unsigned i) { return 1 + (j - 1) * slices + i % slices; };
    const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    for (unsigned i = 0; i < slices; ++i) mesh.triangles.push_back({0, at(1, i + 1), at(1, i)});
    for (unsigned j = 1; j + 1 < stacks; ++j)
        for (unsigned i = 0; i < slices; ++i) {
            mesh.triangles.push_back({at(j, i), at(j, i + 1), at(j + 1, i)});
            mesh.triangles.push_back({at(j, i + 1), at(j + 1, i + 1), at(j + 1, i)});
        }
    for (unsigned i = 0; i < slices; ++i) mesh.triangles.push_back({at(stacks - 1, i), at(stacks - 1, i + 1), last});
    return mesh;
}

// Means of the triangles' normals around each vertex, weighted by area.
void smooth_normals(MeshData& mesh) {
    mesh.normals.assign(mesh.positions.size(), vec3(0.0f));
    for (const uvec3& t : mesh.triangles) {
        const vec3 a = mesh.positions[t.x], n = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
        for (glm::length_t i = 0; i < 3; ++i) mesh.normals[t[i]] += n;
    }
    for (vec3& n : mesh.normals) n = glm::normalize(n);
}

Light point_light(vec3 position) {
    Light light;
    light.position = position;
    return light;
}

Scene scene_of(const char* name, const MeshData& mesh, const Camera& camera, const Light& light) {
    Scene scene;
    scene.name = name;
    scene.materials.emplace_back();
    add_object(scene, name, mesh, dmat4(1.0), 0);
    scene.bounds = scene.objects.front().bounds;
    scene.cameras = {camera};
    scene.lights = {light};
    return scene;
}

} // namespace

Scene spheres(bool big) {
    const unsigned slices = big ? 144 : 20;
    MeshData mesh;
    for (std::uint32_t s = 0; s < 24; ++s) {
        const auto random = [&](std::uint32_t k) { return to_unit(hash(s, k, 7u)); };
        const vec3 center(-5.0f + 2.0f * static_cast<float>(s % 6) + 0.8f * (random(0) - 0.5f), 1.0f + 2.0f * random(1),
                          -3.3f + 2.2f * static_cast<float>(s / 6) + 0.8f * (random(2) - 0.5f));
        append_mesh(mesh, bumpy_sphere(center, 0.6f + 0.3f * random(3), 2 * pi * static_cast<double>(random(4)),
                                       2 * pi * static_cast<double>(random(5)), slices, slices + 1));
    }
    append_mesh(mesh, plane_mesh(vec2(16.0f), big ? 64 : 20, big ? 64 : 20));
    smooth_normals(mesh);
    Camera camera = look_at({0, 6.5f, 13}, {0, 1, 0}, 0.7853982f),
           from_light = look_at({4, 11, 3}, {0, 1, 0}, 1.3089969f);
    camera.near_plane = 0.5f, camera.far_plane = 60.0f;
    from_light.near_plane = 1.0f, from_light.far_plane = 40.0f;
    Scene scene = scene_of(big ? "big" : "small", mesh, camera, point_light({4, 11, 3}));
    scene.cameras.push_back(from_light);
    return scene;
}

Scene height_field() {
    MeshData mesh = grid_mesh(vec2(20.0f), 708, 2.5f, 1.7f, 5);
    smooth_normals(mesh);
    Camera camera = look_at({0, 9, 15}, {0, 0, 0}, 0.7853982f);
    camera.near_plane = 0.5f, camera.far_plane = 60.0f;
    return scene_of("height-field", mesh, camera, point_light({8, 7, -6}));
}

std::optional<Scene> shared_scene(const char* name) {
    const std::string path = std::string(GNOMON_SHARED "/scenes/") + name + "/" + name + ".glb";
    if (!std::filesystem::exists(path)) return std::nullopt;
    Scene scene = load_scene(path);
    scene.name = name;
    const float size = scene.bounds.diagonal();
    scene.lights = {point_light(scene.bounds.center() + vec3(0.5f, 0.9f, 0.4f) * size)};
    fit_planes(scene.cameras.front(), scene.bounds);
    return scene;
}

Light rectangle(vec3 position, vec3 target, float side) {
    Light light;
    light.type = LightType::Rectangle;
    light.position = position;
    light.direction = glm::normalize(target - position);
    light.tangent = any_tangent(light.direction);
    light.size = vec2(side);
    return light;
}

mat4 to_clip(const Camera& camera, int width, int height) {
    return mat4(projection_matrix(camera, static_cast<double>(width) / height) * view_matrix(camera));
}

} // namespace gnomon_bench
