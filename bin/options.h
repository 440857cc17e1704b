#pragma once
// What render, truth and export have in common on the command line: which scene, seen by which camera, under which
// lights. Options are kept as text and read in `read_scene_options`, before any file is touched; names are looked up
// once the scene is loaded.

#include <optional>
#include <string>
#include <vector>

#include "core/scene.h"

namespace CLI {
class App;
}

namespace gnomon {

// As written by the user; empty where not given.
struct SceneOptions {
    std::string scene = "builtin:default";
    std::string camera, look_from, look_at, fov;
    std::string light, light_aim, light_size, light_intensity;
    bool quiet = false;
};
void add_scene_options(CLI::App& command, SceneOptions& options);

// A light described by TYPE:x,y,z and the --light-… options.
struct LightRequest {
    LightType type = LightType::Point;
    vec3 position{0.0f};
    std::optional<vec3> aim;
    vec2 size{1.0f};
    std::optional<vec3> intensity;
};

struct SceneRequest {
    std::string scene;
    std::string camera; // a name, or empty
    std::optional<vec3> look_from, look_at;
    std::optional<float> fov;              // radians
    std::string light;                     // a name, or empty
    std::optional<LightRequest> new_light; // instead, unless the scene has a light of the name `light`
    bool quiet = false;
};
// Throws UsageError.
SceneRequest read_scene_options(const SceneOptions& options);

// A scene with the one camera and the lights that a run uses. Light names are unique and not empty.
struct Stage {
    Scene scene;
    Camera camera;
    std::vector<Light> lights;
};
// Loads the scene, prints its warnings to standard error unless quiet, and settles camera and lights. Throws
// InputError, UsageError.
Stage load_stage(const SceneRequest& request);
// The same for a scene that is loaded already; prints nothing.
Stage make_stage(Scene scene, const SceneRequest& request);

} // namespace gnomon
