// What a scene lacks: cameras, lights, planes, names.

#include <algorithm>
#include <cmath>

#include "core/scene.h"
#include "core/scene_load.h"

namespace gnomon {

Camera default_camera(const Scene& scene) {
    const Bounds& bounds = scene.bounds;
    constexpr float fov = 0.6108652f; // 35°, the view of a 57 mm lens
    const vec3 center = bounds.center();
    const vec3 from = glm::normalize(vec3(0.65f, 0.55f, 1.0f));
    Camera camera = look_at(center + from, center, fov);

    // The nearest eye on this line from which every corner of the box falls inside a square image, with a margin.
    const vec3 right = glm::cross(camera.forward, camera.up);
    const float tangent = std::tan(0.5f * fov) / 1.05f;
    float distance = 0.0f;
    for (int i = 0; i < 8; ++i) {
        const vec3 d = bounds.corner(i) - center;
        const float across = std::max(std::abs(glm::dot(d, right)), std::abs(glm::dot(d, camera.up)));
        distance = std::max(distance, across / tangent - glm::dot(d, camera.forward));
    }
    camera.position = center + from * distance;
    camera.name = "default";
    fit_planes(camera, bounds);
    return camera;
}

Light default_light(const Scene& scene) {
    const vec3 center = scene.bounds.center();
    const float diagonal = scene.bounds.diagonal();
    const vec3 from = glm::normalize(vec3(-0.6f, 1.0f, 0.35f));
    Light light;
    light.name = "default";
    light.type = LightType::Rectangle;
    light.position = center + from * diagonal;
    light.direction = -from;
    light.tangent = any_tangent(light.direction);
    light.size = vec2(0.18f * diagonal);
    const float irradiance = unshadowed_irradiance(light, center, from).x;
    light.intensity = vec3(static_cast<float>(pi) / irradiance);
    return light;
}

void add_light_surface(Scene& scene, const Light& light) {
    const vec3 along = light.tangent * (0.5f * light.size.x), across = bitangent(light) * (0.5f * light.size.y);
    const vec3 p = light.position;
    MeshData quad;
    quad.positions = {p - along - across, p + along - across, p + along + across, p - along + across};
    quad.triangles = {{0, 1, 2}, {0, 2, 3}};
    scene.materials.push_back({light.name, vec3(0.0f), light.intensity, -1});
    add_object(scene, light.name, quad, dmat4(1.0), static_cast<std::uint32_t>(scene.materials.size() - 1));
    scene.objects.back().light_source = true;
}

bool add_mesh_light(Scene& scene, Object& object) {
    const vec3 emission = scene.materials[object.material].emission;
    if (std::max({emission.x, emission.y, emission.z}) <= 0.0f) return false;
    std::vector<vec3> corners;
    corners.reserve(size_t{3} * object.triangle_count);
    for (std::uint32_t t = 0; t < object.triangle_count; ++t)
        for (int corner = 0; corner < 3; ++corner)
            corners.push_back(scene.positions[scene.triangles[object.first_triangle + t][corner]]);
    Light light;
    light.type = LightType::Mesh;
    light.intensity = emission;
    set_triangles(light, corners);
    if (light.triangles.empty()) return false;
    light.name = unique_light_name(scene, object.name);
    object.light_source = true;
    scene.lights.push_back(std::move(light));
    return true;
}

Light transformed(Light light, const dmat4& transform) {
    const glm::dmat3 linear(transform);
    if (light.type == LightType::Mesh) {
        const bool mirrored = glm::determinant(linear) < 0;
        std::vector<vec3> corners;
        for (const LightTriangle& t : light.triangles)
            for (const vec3 corner : {t.a, mirrored ? t.c : t.b, mirrored ? t.b : t.c})
                corners.emplace_back(transform * dvec4(dvec3(corner), 1.0));
        set_triangles(light, corners);
        return light;
    }
    const dvec3 tangent = linear * dvec3(light.tangent), across = linear * dvec3(bitangent(light));
    const auto scaled = [](float size, dvec3 axis) {
        const double length = glm::length(axis);
        return std::abs(length - 1.0) < unit_tolerance ? size : static_cast<float>(size * length);
    };
    light.position = vec3(dvec3(transform * dvec4(dvec3(light.position), 1.0)));
    light.direction = unit(linear * dvec3(light.direction));
    light.tangent = unit_orthogonal(tangent, light.direction);
    light.size = vec2(scaled(light.size.x, tangent), scaled(light.size.y, across));
    if (light.type == LightType::Disk || light.type == LightType::Sphere) light.size.y = light.size.x;
    return light;
}

Camera transformed(Camera camera, const dmat4& transform) {
    const glm::dmat3 linear(transform);
    camera.position = vec3(dvec3(transform * dvec4(dvec3(camera.position), 1.0)));
    camera.forward = unit(linear * dvec3(camera.forward));
    camera.up = unit_orthogonal(linear * dvec3(camera.up), camera.forward);
    return camera;
}

namespace {

template <class Named> std::string unique_name(const std::vector<Named>& taken, const std::string& wanted) {
    const auto exists = [&](const std::string& name) {
        return std::any_of(taken.begin(), taken.end(), [&](const Named& item) { return item.name == name; });
    };
    std::string name = wanted;
    for (int i = 2; exists(name); ++i) name = wanted + "-" + std::to_string(i);
    return name;
}

} // namespace

std::string unique_light_name(const Scene& scene, const std::string& wanted) {
    return unique_name(scene.lights, wanted);
}
std::string unique_camera_name(const Scene& scene, const std::string& wanted) {
    return unique_name(scene.cameras, wanted);
}

} // namespace gnomon
