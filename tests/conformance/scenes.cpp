#include "tests/conformance/scenes.h"

#include <cmath>
#include <filesystem>

namespace gnomon_conformance {

std::optional<Scene> find_scene(const std::string& name) {
    if (name.starts_with("builtin:")) return load_scene(name);
    const std::string path = std::string(GNOMON_SHARED "/scenes/") + name + "/" + name + ".glb";
    if (!std::filesystem::exists(path)) return std::nullopt;
    return load_scene(path);
}

mat4 random_view(const Scene& scene, double aspect, float fov, Random& random) {
    const auto direction = [&] {
        const double z = random.real(-1, 1), angle = random.real(0, 2 * pi), r = std::sqrt(1 - z * z);
        return vec3(dvec3(r * std::cos(angle), z, r * std::sin(angle)));
    };
    const float radius = 0.5f * scene.bounds.diagonal();
    // Looking at a point up to 0.1 radii off the centre, from where the sphere is at most the field of view.
    const double nearest = 1.05 / std::sin(0.5 * static_cast<double>(fov)) + 0.15;
    const vec3 eye = scene.bounds.center() + direction() * radius * static_cast<float>(nearest * random.real(1, 2));
    Camera camera = look_at(eye, scene.bounds.center() + direction() * (0.1f * radius), fov);
    fit_planes(camera, scene.bounds);
    return mat4(projection_matrix(camera, std::max(aspect, 1.0)) * view_matrix(camera));
}

} // namespace gnomon_conformance
