#include "bin/options.h"

#include <algorithm>
#include <cmath>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/text.h"
#include "core/error.h"

namespace gnomon {
namespace {

struct LightWord {
    const char* word;
    LightType type;
};
constexpr LightWord light_words[] = {
    {"point", LightType::Point},   {"spot", LightType::Spot},      {"directional", LightType::Directional},
    {"disk", LightType::Disk},     {"rect", LightType::Rectangle}, {"rectangle", LightType::Rectangle},
    {"sphere", LightType::Sphere},
};

const LightWord* find_light_word(const std::string& word) {
    const auto* found = std::find_if(std::begin(light_words), std::end(light_words),
                                     [&](const LightWord& row) { return row.word == word; });
    return found == std::end(light_words) ? nullptr : found;
}

vec3 parse_intensity(const std::string& text) {
    const std::string what = "--light-intensity";
    const vec3 value = text.find(',') == std::string::npos ? vec3(static_cast<float>(parse_real(text, what, 0, 1e30)))
                                                           : parse_vec3(text, what);
    if (value.x < 0 || value.y < 0 || value.z < 0)
        throw UsageError(fmt::format("{} is '{}', but must not be negative", what, text));
    return value;
}

std::optional<LightRequest> read_light(const SceneOptions& options) {
    const size_t colon = options.light.find(':');
    const LightWord* word = colon == std::string::npos ? nullptr : find_light_word(options.light.substr(0, colon));
    if (!word) {
        for (const auto& [text, option] :
             {std::pair(&options.light_aim, "--light-aim"), std::pair(&options.light_size, "--light-size"),
              std::pair(&options.light_intensity, "--light-intensity")})
            if (!text->empty())
                throw UsageError(
                    fmt::format("{} goes with a light made on the command line: --light TYPE:x,y,z", option));
        return {};
    }
    LightRequest light;
    light.type = word->type;
    light.position = parse_vec3(options.light.substr(colon + 1), "--light " + std::string(word->word));
    if (!options.light_aim.empty()) light.aim = parse_vec3(options.light_aim, "--light-aim");
    if (light.aim == light.position)
        throw UsageError("--light-aim is the light's own position, so the light points nowhere");
    if (!options.light_size.empty()) {
        if (!is_area(light.type))
            throw UsageError(fmt::format("a {} light has no size; --light-size goes with rect, disk and sphere",
                                         light_type_name(light.type)));
        light.size = parse_extent(options.light_size, "--light-size");
        if (light.type != LightType::Rectangle && light.size.x != light.size.y)
            throw UsageError(fmt::format("--light-size is '{}', but the size of a {} is one number, its diameter",
                                         options.light_size, light_type_name(light.type)));
    }
    if (!options.light_intensity.empty()) light.intensity = parse_intensity(options.light_intensity);
    return light;
}

// The light's type decides its unit; unless told, it gives π W/m² where it points, so that white paper there has
// radiance 1.
Light make_light(const LightRequest& request, const Scene& scene) {
    Light light;
    light.name = "light";
    light.type = request.type;
    light.position = request.position;
    vec3 aim = request.aim.value_or(scene.bounds.center());
    if (aim == light.position) aim.y -= 1.0f;
    light.direction = glm::normalize(aim - light.position);
    light.tangent = any_tangent(light.direction);
    if (is_area(light)) light.size = request.size;
    light.intensity = vec3(1.0f);
    const float irradiance = unshadowed_irradiance(light, aim, -light.direction).x;
    light.intensity = request.intensity.value_or(vec3(irradiance > 0 ? static_cast<float>(pi) / irradiance : 1.0f));
    return light;
}

template <class Named>
const Named& find_named(const std::vector<Named>& items, const std::string& name, const std::string& what) {
    std::vector<std::string> names;
    for (const Named& item : items) {
        if (item.name == name) return item;
        names.push_back(item.name);
    }
    throw UsageError(fmt::format("the scene has no {} '{}'{} (it has {})", what, name, did_you_mean(name, names),
                                 fmt::join(names, ", ")));
}

Camera choose_camera(const SceneRequest& request, const Scene& scene) {
    Camera camera =
        request.camera.empty() ? scene.cameras.front() : find_named(scene.cameras, request.camera, "camera");
    if (request.look_from || request.look_at) {
        const vec3 eye = request.look_from.value_or(camera.position);
        const vec3 target = request.look_at.value_or(scene.bounds.center());
        if (eye == target)
            throw UsageError(request.look_from && request.look_at ? "--look-from and --look-at are the same point"
                                                                  : "the camera would stand on the point it looks at; "
                                                                    "give both --look-from and --look-at");
        camera = look_at(eye, target, camera.orthographic ? Camera().vertical_fov : camera.vertical_fov);
        camera.name = "command line";
        fit_planes(camera, scene.bounds);
    }
    if (request.fov) {
        if (camera.orthographic)
            throw UsageError(fmt::format("--fov needs a perspective camera, but '{}' is orthographic", camera.name));
        camera.vertical_fov = *request.fov;
    }
    return camera;
}

// 'rct:0,4,0' is a misspelt type rather than a misspelt name.
[[noreturn]] void fail_light_type(const std::string& text) {
    std::vector<std::string> words;
    for (const LightWord& row : light_words) words.emplace_back(row.word);
    const std::string word = text.substr(0, text.find(':'));
    throw UsageError(fmt::format("--light is '{}', but '{}' is no type of light{} (types are {})", text, word,
                                 did_you_mean(word, words), fmt::join(words, ", ")));
}

std::vector<Light> choose_lights(const SceneRequest& request, const Scene& scene) {
    if (request.light.empty()) return scene.lights;
    const auto named = [&](const Light& light) { return light.name == request.light; };
    const bool known = std::any_of(scene.lights.begin(), scene.lights.end(), named);
    if (!known && request.new_light) return {make_light(*request.new_light, scene)};
    if (!known && request.light.find(':') != std::string::npos) fail_light_type(request.light);
    return {find_named(scene.lights, request.light, "light")};
}

} // namespace

void add_scene_options(CLI::App& command, SceneOptions& options) {
    const auto text = [&](const char* name, std::string& value, const char* type, const char* help) {
        return command.add_option(name, value, help)->type_name(type)->group("Scene");
    };
    command.add_option("scene", options.scene, "a .gltf, .glb or .json file, or builtin:NAME[:key=value,...]")
        ->type_name("SCENE")
        ->capture_default_str();
    text("--camera", options.camera, "NAME", "camera of the scene to look through (default: its first)");
    text("--look-from", options.look_from, "x,y,z", "eye of a camera made here, in metres");
    text("--look-at", options.look_at, "x,y,z", "point that it looks at (default: the middle of the scene)");
    text("--fov", options.fov, "DEGREES", "vertical field of view, above 0 and below 180 (default: the camera's)");
    text(
        "--light", options.light, "NAME|TYPE:x,y,z",
        "one light of the scene (default: all), or a new one at x,y,z instead of them: point, spot, directional, rect, "
        "disk, sphere");
    text("--light-aim", options.light_aim, "x,y,z",
         "where the new light points; a directional light shines from its x,y,z to here (default: the middle of the "
         "scene)");
    text("--light-size", options.light_size, "WxH|D",
         "size of a rect, diameter of a disk or sphere, in metres, above 0 "
         "(default: 1)");
    text("--light-intensity", options.light_intensity, "I|R,G,B",
         "W/sr for point and spot, W/m2 for directional, W/(m2 sr) for area lights (default: pi W/m2 where it points)");
    command.add_flag("-q,--quiet", options.quiet, "no warnings, notes or progress on standard error");
}

SceneRequest read_scene_options(const SceneOptions& options) {
    SceneRequest request;
    request.scene = options.scene;
    request.camera = options.camera;
    request.quiet = options.quiet;
    if (!options.look_from.empty()) request.look_from = parse_vec3(options.look_from, "--look-from");
    if (!options.look_at.empty()) request.look_at = parse_vec3(options.look_at, "--look-at");
    if (!request.camera.empty() && (request.look_from || request.look_at))
        throw UsageError(
            "--camera takes a camera of the scene, --look-from and --look-at make one: give one or the other");
    if (request.look_from && request.look_from == request.look_at)
        throw UsageError("--look-from and --look-at are the same point");
    if (!options.fov.empty()) {
        const double degrees = parse_real(options.fov, "--fov", 0, 180);
        if (degrees < 0.001 || degrees > 179.9)
            throw UsageError(fmt::format("--fov is '{}', but must be above 0 and below 180 degrees", options.fov));
        request.fov = static_cast<float>(degrees * pi / 180.0);
    }
    request.light = options.light;
    request.new_light = read_light(options);
    return request;
}

Stage load_stage(const SceneRequest& request) {
    Scene scene = load_scene(request.scene);
    if (!request.quiet)
        for (const std::string& warning : scene.warnings) print_message("warning: " + warning);
    return make_stage(std::move(scene), request);
}

Stage make_stage(Scene scene, const SceneRequest& request) {
    Stage stage;
    stage.scene = std::move(scene);
    stage.camera = choose_camera(request, stage.scene);
    stage.lights = choose_lights(request, stage.scene);
    return stage;
}

} // namespace gnomon
