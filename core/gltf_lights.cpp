#include "core/gltf_lights.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

#include "core/error.h"
#include "core/scene_load.h"

namespace gnomon {
namespace {

constexpr double largest = 1e30;

// The corners of two triangles in order around the quad that they form, or nothing.
std::optional<std::array<dvec3, 4>> quad_corners(const Scene& scene, const Object& object) {
    if (object.triangle_count != 2) return std::nullopt;
    std::array<std::array<dvec3, 3>, 2> triangles;
    for (std::uint32_t t = 0; t < 2; ++t)
        for (int corner = 0; corner < 3; ++corner)
            triangles[t][static_cast<size_t>(corner)] =
                dvec3(scene.positions[scene.triangles[object.first_triangle + t][corner]]);
    // The diagonal is the edge that the triangles traverse in opposite directions.
    for (size_t i = 0; i < 3; ++i)
        for (size_t j = 0; j < 3; ++j) {
            const dvec3 start = triangles[0][i], end = triangles[0][(i + 1) % 3];
            if (start == triangles[1][(j + 1) % 3] && end == triangles[1][j])
                return std::array{start, triangles[1][(j + 2) % 3], end, triangles[0][(i + 2) % 3]};
        }
    return std::nullopt;
}

void read_area_size(const JsonReader& area, Light& light) {
    const bool round = light.type == LightType::Disk || light.type == LightType::Sphere;
    if (round && area.has("diameter")) {
        light.size = vec2(area.at("diameter").real(1e-6, largest));
        return;
    }
    if (!area.has("size")) area.fail(round ? "needs a 'diameter'" : "needs a 'size' of two numbers");
    const JsonReader size = area.at("size");
    if (size.size() != 2) size.fail("must be an array of two numbers");
    light.size = {size[0].real(1e-6, largest), size[1].real(1e-6, largest)};
    if (round && light.size.x != light.size.y) size.fail("must be the diameter twice");
}

void read_area_texture(const GltfFile& file, const JsonReader& area, Light& light) {
    const JsonReader texture = area.at("texture");
    const int width = texture.at("width").integer(1, max_image_side),
              height = texture.at("height").integer(1, max_image_side);
    const auto accessor = static_cast<int>(texture.at("accessor").index(file.model.accessors.size(), "accessors"));
    const size_t texels = static_cast<size_t>(width) * static_cast<size_t>(height);
    const std::vector<vec3> values = read_vec3(file, accessor, texels, texture.path());
    light.texture = Image<vec3>(width, height);
    std::copy(values.begin(), values.end(), light.texture.data());
}

void read_area_triangles(const GltfFile& file, const JsonReader& area, Light& light) {
    const JsonReader triangles = area.at("triangles");
    const int count = triangles.at("count").integer(1, 1 << 28);
    const auto accessor = static_cast<int>(triangles.at("accessor").index(file.model.accessors.size(), "accessors"));
    set_triangles(light, read_vec3(file, accessor, size_t{3} * static_cast<size_t>(count), triangles.path()));
    if (light.triangles.empty()) triangles.fail("have no area");
}

void read_area(const GltfFile& file, const JsonReader& area, Light& light) {
    area.only({"shape", "size", "diameter", "texture", "triangles"});
    const std::string shape = area.at("shape").text();
    bool known = false;
    for (const LightType type :
         {LightType::Rectangle, LightType::Disk, LightType::Sphere, LightType::TexturedRectangle, LightType::Mesh})
        if (shape == light_type_name(type)) light.type = type, known = true;
    if (!known) area.at("shape").fail("must be 'rectangle', 'disk', 'sphere', 'textured-rectangle' or 'mesh'");
    if (light.type == LightType::Mesh) return read_area_triangles(file, area, light);
    read_area_size(area, light);
    if (light.type == LightType::TexturedRectangle) read_area_texture(file, area, light);
}

void read_cones(const JsonReader& definition, Light& light) {
    if (!definition.has("spot")) return;
    const JsonReader spot = definition.at("spot");
    if (spot.has("innerConeAngle")) light.inner_cone = spot.at("innerConeAngle").real(0, pi / 2 + 1e-6);
    if (spot.has("outerConeAngle")) light.outer_cone = spot.at("outerConeAngle").real(0, pi / 2 + 1e-6);
    if (light.inner_cone > light.outer_cone) spot.fail("has an innerConeAngle beyond its outerConeAngle");
}

} // namespace

std::optional<Light> quad_light(const Scene& scene, const Object& object) {
    const auto corners = quad_corners(scene, object);
    if (!corners) return std::nullopt;
    const auto& [a, b, c, d] = *corners;
    const dvec3 along = b - a, across = d - a;
    const double width = glm::length(along), height = glm::length(across);
    constexpr double tolerance = 1e-3;
    const bool parallelogram = glm::length((a + c) - (b + d)) <= tolerance * std::min(width, height);
    const bool rectangular = std::abs(glm::dot(along, across)) <= tolerance * width * height;
    if (!(width > 0 && height > 0 && parallelogram && rectangular)) return std::nullopt;

    Light light;
    light.type = LightType::Rectangle;
    light.position = vec3((a + b + c + d) * 0.25);
    light.direction = vec3(glm::normalize(glm::cross(along, across)));
    light.tangent = unit_orthogonal(along, light.direction);
    light.size = vec2(width, height);
    light.intensity = scene.materials[object.material].emission;
    return light;
}

Light node_light(const GltfFile& file, const JsonReader& document, const JsonReader& node) {
    const JsonReader lights = document.at("extensions").at("KHR_lights_punctual").at("lights");
    const size_t index = node.at("extensions").at("KHR_lights_punctual").at("light").index(lights.size(), "lights");
    const JsonReader definition = lights[index];
    Light light;
    light.direction = {0, 0, -1};
    light.tangent = {1, 0, 0};
    const std::string type = definition.at("type").text();
    if (type == "point")
        light.type = LightType::Point;
    else if (type == "spot")
        light.type = LightType::Spot;
    else if (type == "directional")
        light.type = LightType::Directional;
    else
        definition.at("type").fail("must be 'point', 'spot' or 'directional'");
    read_cones(definition, light);
    if (definition.has("range")) light.range = definition.at("range").real(1e-6, largest);
    const double intensity = definition.has("intensity") ? definition.at("intensity").number(0, largest) : 1.0;
    const dvec3 color = definition.has("color") ? definition.at("color").vector3(0, largest) : dvec3(1.0);
    light.intensity = vec3(color * intensity);
    if (node.has("extras") && node.at("extras").has("area")) read_area(file, node.at("extras").at("area"), light);
    light.name = node.has("name") ? node.at("name").text() : "";
    if (light.name.empty() && definition.has("name")) light.name = definition.at("name").text();
    if (light.name.empty()) light.name = "light";
    return light;
}

} // namespace gnomon
