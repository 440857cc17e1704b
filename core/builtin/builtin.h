#pragma once
// Scenes that need no file. Each has a source of its own in this folder, and a row in builtin.cpp.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/parameters.h"
#include "core/scene.h"

namespace gnomon {

struct BuiltinScene {
    std::string name, title;
    std::vector<ParameterInfo> parameters;
    // Throws UsageError for an unknown parameter or one out of range.
    std::function<Scene(const ParameterText&)> make;
};

std::span<const BuiltinScene> builtin_scenes();
// Throws UsageError with the nearest known name.
const BuiltinScene& find_builtin(const std::string& name);
inline constexpr std::string_view builtin_prefix = "builtin:"; // of specifications

// A row out of the scene's parameter struct, its table and its function.
template <class Params, class Table>
BuiltinScene builtin_scene(std::string name, std::string title, const Table& table, Scene (*build)(const Params&)) {
    BuiltinScene scene;
    for (const BoundParameter& parameter : bind<Params>(table)) scene.parameters.push_back(parameter.info);
    scene.make = [table, build, owner = "builtin scene '" + name + "'"](const ParameterText& text) {
        return build(parse_parameters<Params>(table, text, owner));
    };
    scene.name = std::move(name);
    scene.title = std::move(title);
    return scene;
}

// What the scenes are put together from.
std::uint32_t add_material(Scene& scene, const std::string& name, vec3 base_color, vec3 emission = vec3(0.0f));
// A rectangle (or, by `type`, a disk or sphere) that shines from `position` at `target`, so bright that a surface at
// `target` which faces it receives `irradiance` W/m².
Light light_for_irradiance(LightType type, vec3 position, vec3 target, vec2 size, float irradiance);
// As look_at, with the field of view in degrees; near at 0.1 m, far fitted once the scene is known.
Camera scene_camera(vec3 eye, vec3 target, float vertical_fov_degrees);

BuiltinScene default_scene();
BuiltinScene half_plane_scene();
BuiltinScene fence_scene();
BuiltinScene wire_ball_scene();
BuiltinScene tree_scene();
BuiltinScene colonnade_scene();
BuiltinScene stacked_plates_scene();
BuiltinScene cornell_scene();
BuiltinScene staircase_scene();

} // namespace gnomon
