#include <algorithm>
#include <array>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/image_file.h"
#include "core/scene_json.h"
#include "core/scene_load.h"

namespace gnomon {
namespace {

constexpr double far_away = 1e9; // metres
constexpr double smallest = 1e-6;

LightType read_type(const JsonReader& value) {
    const std::string wanted = value.text();
    std::vector<std::string> known;
    for (const LightType type : {LightType::Point, LightType::Spot, LightType::Directional, LightType::Rectangle,
                                 LightType::Disk, LightType::Sphere, LightType::TexturedRectangle}) {
        if (wanted == light_type_name(type)) return type;
        known.emplace_back(light_type_name(type));
    }
    if (wanted == light_type_name(LightType::Mesh))
        value.fail("is 'mesh': give the object that shines \"light\": true instead");
    value.fail("is '" + wanted + "', which is no type of light" + did_you_mean(wanted, known));
}

// The keys that mean something for a type of light.
JsonReader::Keys keys_of(LightType type) {
    JsonReader::Keys keys = {"name", "type", "intensity"};
    const auto add = [&](JsonReader::Keys more) { keys.insert(keys.end(), more.begin(), more.end()); };
    if (type != LightType::Directional) add({"position"});
    if (type != LightType::Point && type != LightType::Sphere) add({"direction", "target"});
    if (type == LightType::Point || type == LightType::Spot) add({"range"});
    if (type == LightType::Spot) add({"inner_cone", "outer_cone"});
    if (type == LightType::Disk || type == LightType::Sphere) add({"diameter"});
    if (type == LightType::Rectangle || type == LightType::TexturedRectangle) add({"size", "tangent", "visible"});
    if (type == LightType::TexturedRectangle) add({"image"});
    return keys;
}

// `direction`, or from `position` to `target`; (0, −1, 0) or along −z where there is neither.
vec3 read_direction(const JsonReader& owner, vec3 position, vec3 otherwise) {
    if (owner.has("direction") && owner.has("target"))
        owner.at("target").fail("cannot stand beside 'direction'; leave one of them out");
    if (!owner.has("direction") && !owner.has("target")) return otherwise;
    const JsonReader source = owner.at(owner.has("direction") ? "direction" : "target");
    const dvec3 value = source.vector3(-far_away, far_away);
    const dvec3 direction = owner.has("direction") ? value : value - dvec3(position);
    if (glm::length(direction) < smallest)
        source.fail(owner.has("direction") ? "must not be zero" : "must differ from the position");
    return unit(direction);
}

void read_size(const JsonReader& owner, Light& light) {
    if (light.type == LightType::Disk || light.type == LightType::Sphere) {
        light.size = vec2(owner.at("diameter").real(smallest, far_away));
        return;
    }
    const JsonReader size = owner.at("size");
    if (!size.value().is_array())
        light.size = vec2(size.real(smallest, far_away));
    else if (size.size() == 2)
        light.size = {size[0].real(smallest, far_away), size[1].real(smallest, far_away)};
    else
        size.fail("must be one number, or two: along the tangent and across it");
}

void read_tangent(const JsonReader& owner, Light& light) {
    light.tangent = any_tangent(light.direction);
    if (!owner.has("tangent")) return;
    const dvec3 tangent = owner.at("tangent").vector3(-far_away, far_away);
    if (glm::length(glm::cross(tangent, dvec3(light.direction))) < smallest * std::max(1.0, glm::length(tangent)))
        owner.at("tangent").fail("must not be zero or along the direction");
    light.tangent = unit_orthogonal(tangent, light.direction);
}

void read_cones(const JsonReader& owner, Light& light) {
    if (owner.has("inner_cone")) light.inner_cone = glm::radians(owner.at("inner_cone").real(0, 90));
    if (owner.has("outer_cone")) light.outer_cone = glm::radians(owner.at("outer_cone").real(0, 90));
    if (light.inner_cone > light.outer_cone) owner.fail("has an inner_cone beyond its outer_cone");
}

// EXR and HDR files hold linear values; the others are sRGB.
void read_texture(const JsonReader& value, const std::filesystem::path& folder, Light& light) {
    const std::string path = (folder / value.text()).string();
    ChannelImage image;
    try {
        image = read_image(path);
    } catch (const Error& error) {
        value.fail(std::string(": ") + error.what());
    }
    const bool gray = image.channels.size() < 3;
    const std::array names = {"R", "G", "B"};
    std::array<const Channel*, 3> channels{};
    for (size_t i = 0; i < 3; ++i) {
        channels[i] = image.find(names[i]);
        if (!channels[i] && gray && !image.channels.empty()) channels[i] = &image.channels.front();
        if (!channels[i]) value.fail(": " + path + " has no channel " + names[i]);
    }
    const std::string extension = std::filesystem::path(path).extension().string();
    const bool linear = extension == ".exr" || extension == ".hdr" || extension == ".pfm";
    light.texture = Image<vec3>(image.width, image.height);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            for (int i = 0; i < 3; ++i) {
                const float stored = channels[static_cast<size_t>(i)]->values(x, y);
                light.texture(x, y)[i] = linear ? stored : linear_from_srgb(stored);
            }
}

} // namespace

void read_light(const JsonReader& owner, const std::filesystem::path& folder, Scene& scene) {
    Light light;
    light.type = read_type(owner.at("type"));
    owner.only(keys_of(light.type));
    if (owner.has("position"))
        light.position = vec3(owner.at("position").vector3(-far_away, far_away));
    else if (light.type != LightType::Directional)
        owner.fail("has no 'position'");
    light.direction = read_direction(owner, light.position, {0, -1, 0});
    if (owner.has("intensity")) {
        const JsonReader intensity = owner.at("intensity");
        light.intensity =
            intensity.value().is_array() ? vec3(intensity.vector3(0, 1e12)) : vec3(intensity.real(0, 1e12));
    }
    if (is_area(light)) read_size(owner, light);
    read_tangent(owner, light);
    read_cones(owner, light);
    if (owner.has("range")) light.range = owner.at("range").real(smallest, far_away);
    if (light.type == LightType::TexturedRectangle) read_texture(owner.at("image"), folder, light);
    light.name = unique_light_name(scene, owner.has("name") ? owner.at("name").text() : "light");
    if (owner.has("visible") && owner.at("visible").boolean()) add_light_surface(scene, light);
    scene.lights.push_back(std::move(light));
}

void read_camera(const JsonReader& owner, Scene& scene) {
    owner.only({"name", "position", "target", "direction", "up", "fov", "view_height", "near", "far"});
    Camera camera;
    const vec3 position(owner.at("position").vector3(-far_away, far_away));
    const vec3 forward = read_direction(owner, position, {0, 0, -1});
    camera = look_at(vec3(0.0f), forward, camera.vertical_fov);
    camera.position = position;
    if (owner.has("up")) {
        const dvec3 up = owner.at("up").vector3(-far_away, far_away);
        if (glm::length(glm::cross(up, dvec3(camera.forward))) < smallest * std::max(1.0, glm::length(up)))
            owner.at("up").fail("must not be zero or along the view");
        camera.up = unit_orthogonal(up, camera.forward);
    }
    if (owner.has("fov") && owner.has("view_height"))
        owner.at("view_height")
            .fail("makes the camera orthographic and cannot stand beside 'fov'; leave one of them out");
    if (owner.has("fov")) camera.vertical_fov = glm::radians(owner.at("fov").real(0.1, 179));
    if (owner.has("view_height")) {
        camera.orthographic = true;
        camera.view_height = owner.at("view_height").real(smallest, far_away);
    }
    camera.near_plane = owner.has("near") ? owner.at("near").real(smallest, far_away) : 0.0f;
    camera.far_plane = owner.has("far") ? owner.at("far").real(smallest, far_away) : 0.0f; // 0: fitted by finish_scene
    if (owner.has("near") && owner.has("far") && camera.near_plane >= camera.far_plane)
        owner.at("far").fail("must be beyond 'near'");
    camera.name = unique_camera_name(scene, owner.has("name") ? owner.at("name").text() : "camera");
    scene.cameras.push_back(camera);
}

} // namespace gnomon
