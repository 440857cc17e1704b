#pragma once
// Small scenes of known answer for the ray tracer's tests, built by hand so that nothing but core/scene.h is needed.

#include <algorithm>
#include <vector>

#include "core/light.h"
#include "core/receiver.h"
#include "core/scene.h"

namespace gnomon_tests {

using namespace gnomon;

// Appends a convex polygon as a fan; a new object.
inline void add_polygon(Scene& scene, const std::vector<vec3>& corners, bool light_source = false) {
    Object object;
    object.first_triangle = static_cast<std::uint32_t>(scene.triangles.size());
    object.triangle_count = static_cast<std::uint32_t>(corners.size() - 2);
    object.light_source = light_source;
    const auto first = static_cast<std::uint32_t>(scene.positions.size());
    for (const vec3 corner : corners) scene.positions.push_back(corner);
    for (std::uint32_t i = 2; i < corners.size(); ++i) {
        scene.triangles.push_back({first, first + i - 1, first + i});
        scene.triangle_objects.push_back(static_cast<std::uint32_t>(scene.objects.size()));
    }
    scene.objects.push_back(object);
}

// Horizontal rectangle [x0,x1]×[z0,z1] at y, seen from above as counter-clockwise.
inline void add_floor(Scene& scene, float x0, float x1, float z0, float z1, float y, bool light_source = false) {
    add_polygon(scene, {{x0, y, z0}, {x0, y, z1}, {x1, y, z1}, {x1, y, z0}}, light_source);
}

inline void add_box(Scene& scene, vec3 a, vec3 b) {
    add_polygon(scene, {{a.x, a.y, a.z}, {a.x, a.y, b.z}, {a.x, b.y, b.z}, {a.x, b.y, a.z}});
    add_polygon(scene, {{b.x, a.y, a.z}, {b.x, b.y, a.z}, {b.x, b.y, b.z}, {b.x, a.y, b.z}});
    add_polygon(scene, {{a.x, a.y, a.z}, {b.x, a.y, a.z}, {b.x, a.y, b.z}, {a.x, a.y, b.z}});
    add_polygon(scene, {{a.x, b.y, a.z}, {a.x, b.y, b.z}, {b.x, b.y, b.z}, {b.x, b.y, a.z}});
    add_polygon(scene, {{a.x, a.y, a.z}, {a.x, b.y, a.z}, {b.x, b.y, a.z}, {b.x, a.y, a.z}});
    add_polygon(scene, {{a.x, a.y, b.z}, {b.x, a.y, b.z}, {b.x, b.y, b.z}, {a.x, b.y, b.z}});
}

// Sphere of 2·rings × rings quads; counter-clockwise from outside.
inline void add_sphere(Scene& scene, vec3 center, float radius, int rings) {
    const auto point = [&](int i, int j) {
        const double theta = pi * j / rings, phi = pi * (i % (2 * rings)) / rings;
        const dvec3 unit(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
        return vec3(dvec3(center) + unit * double(radius));
    };
    for (int j = 0; j < rings; ++j)
        for (int i = 0; i < 2 * rings; ++i) {
            if (j > 0) add_polygon(scene, {point(i, j), point(i, j + 1), point(i + 1, j)});
            if (j < rings - 1) add_polygon(scene, {point(i + 1, j), point(i, j + 1), point(i + 1, j + 1)});
        }
}

inline vec3 normal_of(const Scene& scene, std::uint32_t triangle) {
    const uvec3 t = scene.triangles[triangle];
    const dvec3 a(scene.positions[t.x]), b(scene.positions[t.y]), c(scene.positions[t.z]);
    return vec3(glm::normalize(glm::cross(b - a, c - a)));
}

// The point of a triangle at barycentric coordinates, rounded to float as a G-buffer has it.
inline Receiver receiver_at(const Scene& scene, std::uint32_t triangle, float b1, float b2) {
    const uvec3 t = scene.triangles[triangle];
    const vec3 p = scene.positions[t.x] * (1.0f - b1 - b2) + scene.positions[t.y] * b1 + scene.positions[t.z] * b2;
    return {p, normal_of(scene, triangle), triangle};
}

// A row of receivers on a horizontal floor of triangle `triangle`.
inline Receivers receivers_on_floor(const std::vector<vec3>& points, std::uint32_t triangle) {
    Receivers receivers(static_cast<int>(points.size()), 1);
    for (size_t i = 0; i < points.size(); ++i) receivers(static_cast<int>(i), 0) = {points[i], vec3(0, 1, 0), triangle};
    return receivers;
}

inline Light light_at(LightType type, vec3 position, vec2 size = vec2(0.0f)) {
    Light light;
    light.type = type;
    light.position = position;
    light.size = size;
    light.tangent = any_tangent(light.direction);
    return light;
}

} // namespace gnomon_tests
