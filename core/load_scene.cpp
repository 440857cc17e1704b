#include <algorithm>
#include <filesystem>
#include <numeric>

#include <fmt/format.h>

#include "core/adjacency.h"
#include "core/builtin/builtin.h"
#include "core/parallel.h"
#include "core/scene.h"
#include "core/scene_load.h"

namespace gnomon {
namespace {

std::string lower_extension(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return extension;
}

std::vector<std::uint8_t> find_degenerate(const Scene& scene) {
    std::vector<std::uint8_t> degenerate(scene.triangles.size());
    parallel_for(degenerate.size(), size_t{1} << 14, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = scene.triangles[i];
            degenerate[i] = zero_area(scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]);
        }
    });
    return degenerate;
}

void drop_degenerate_triangles(Scene& scene) {
    const std::vector<std::uint8_t> degenerate = find_degenerate(scene);
    const size_t count = std::accumulate(degenerate.begin(), degenerate.end(), size_t{0});
    if (count == 0 && std::all_of(scene.objects.begin(), scene.objects.end(),
                                  [](const Object& object) { return object.triangle_count > 0; }))
        return;
    std::vector<Object> objects;
    std::uint32_t kept = 0;
    for (Object object : scene.objects) {
        const std::uint32_t first = kept;
        const auto index = static_cast<std::uint32_t>(objects.size());
        object.bounds = {};
        for (std::uint32_t i = object.first_triangle; i < object.first_triangle + object.triangle_count; ++i) {
            if (degenerate[i]) continue;
            for (int corner = 0; corner < 3; ++corner)
                object.bounds.extend(scene.positions[scene.triangles[i][corner]]);
            scene.triangles[kept] = scene.triangles[i];
            scene.triangle_objects[kept++] = index;
        }
        object.first_triangle = first;
        object.triangle_count = kept - first;
        if (object.triangle_count > 0) objects.push_back(std::move(object));
    }
    scene.objects = std::move(objects);
    scene.triangles.resize(kept);
    scene.triangle_objects.resize(kept);
    if (count > 0)
        scene.warnings.push_back(fmt::format("{}: {} triangles of zero area are left out", scene.name, count));
}

} // namespace

void finish_scene(Scene& scene, const std::string& specification) {
    drop_degenerate_triangles(scene);
    if (scene.triangles.empty())
        throw InputError(specification + ": the scene is empty: it has no triangle with an area; add a mesh to it");
    scene.bounds = {};
    for (const Object& object : scene.objects) {
        scene.bounds.extend(object.bounds.minimum);
        scene.bounds.extend(object.bounds.maximum);
    }
    for (Camera& camera : scene.cameras) {
        const bool near_given = camera.near_plane > 0.0f || (camera.orthographic && camera.near_plane == 0.0f);
        if (near_given && camera.near_plane < camera.far_plane) continue;
        // A plane that the author chose stays, unless near is too near for the depth range that the scene needs.
        const float chosen_near = camera.near_plane, chosen_far = camera.far_plane;
        fit_planes(camera, scene.bounds);
        if (chosen_far > 0.0f) camera.far_plane = chosen_far;
        if (chosen_near >= 1e-4f * camera.far_plane && chosen_near < camera.far_plane) camera.near_plane = chosen_near;
        if (camera.near_plane >= camera.far_plane) camera.near_plane = 1e-4f * camera.far_plane;
    }
    if (scene.cameras.empty()) scene.cameras.push_back(default_camera(scene));
    if (scene.lights.empty()) scene.lights.push_back(default_light(scene));
}

Scene load_raw_scene(const std::string& specification) {
    if (specification.starts_with(builtin_prefix)) {
        const Specification parsed = parse_specification(specification.substr(builtin_prefix.size()));
        Scene scene = find_builtin(parsed.name).make(parsed.parameters);
        scene.name = specification;
        return scene;
    }
    const std::string extension = lower_extension(specification);
    const bool gltf = extension == ".gltf" || extension == ".glb";
    if (!gltf && extension != ".json")
        throw InputError(specification + ": a scene is a file ending in .gltf, .glb or .json, or builtin:NAME");
    if (!std::filesystem::exists(specification))
        throw InputError(specification + ": there is no such file; check the path");
    Scene scene = gltf ? load_gltf(specification) : load_scene_json(specification);
    if (scene.name.empty()) scene.name = std::filesystem::path(specification).filename().string();
    return scene;
}

Scene load_scene(const std::string& specification) {
    Scene scene = load_raw_scene(specification);
    finish_scene(scene, specification);
    return scene;
}

} // namespace gnomon
