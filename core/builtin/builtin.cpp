#include "core/builtin/builtin.h"

#include "core/error.h"

namespace gnomon {

std::span<const BuiltinScene> builtin_scenes() {
    static const std::vector<BuiltinScene> scenes = {
        default_scene(),   half_plane_scene(),     fence_scene(),   wire_ball_scene(), tree_scene(),
        colonnade_scene(), stacked_plates_scene(), cornell_scene(), staircase_scene(),
    };
    return scenes;
}

const BuiltinScene& find_builtin(const std::string& name) {
    std::vector<std::string> names;
    for (const BuiltinScene& builtin : builtin_scenes()) {
        if (builtin.name == name) return builtin;
        names.push_back(builtin.name);
    }
    throw UsageError("there is no builtin scene '" + name + "'" + did_you_mean(name, names));
}

std::uint32_t add_material(Scene& scene, const std::string& name, vec3 base_color, vec3 emission) {
    scene.materials.push_back({name, base_color, emission, -1});
    return static_cast<std::uint32_t>(scene.materials.size() - 1);
}

Light light_for_irradiance(LightType type, vec3 position, vec3 target, vec2 size, float irradiance) {
    Light light;
    light.type = type;
    light.position = position;
    light.direction = glm::normalize(target - position);
    light.tangent = any_tangent(light.direction);
    light.size = size;
    light.intensity = vec3(irradiance / unshadowed_irradiance(light, target, -light.direction).x);
    return light;
}

Camera scene_camera(vec3 eye, vec3 target, float vertical_fov_degrees) {
    Camera camera = look_at(eye, target, glm::radians(vertical_fov_degrees));
    camera.far_plane = 0.0f; // finish_scene fits it
    camera.near_plane = 0.1f;
    return camera;
}

} // namespace gnomon
