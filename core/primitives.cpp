#include "core/primitives.h"

#include <array>
#include <cassert>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "core/random.h"
#include "core/scene_load.h"

namespace gnomon {
namespace {

std::uint32_t u32(int value) { return static_cast<std::uint32_t>(value); }

// Point i of n on the unit circle in the xz plane; the same bits for the same i modulo n.
vec2 circle(int i, int n) {
    const double angle = 2.0 * pi * (i % n) / n;
    return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
}

void add_quad(MeshData& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.emplace_back(a, b, c);
    mesh.triangles.emplace_back(a, c, d);
}

// A flat, round lid over a ring of `sides` positions, counter-clockwise seen along −normal.
void add_cap(MeshData& mesh, std::span<const vec3> ring, vec3 center, vec3 normal) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const auto sides = static_cast<std::uint32_t>(ring.size());
    mesh.positions.push_back(center);
    mesh.positions.insert(mesh.positions.end(), ring.begin(), ring.end());
    mesh.normals.insert(mesh.normals.end(), ring.size() + 1, normal);
    for (std::uint32_t i = 0; i < sides; ++i)
        mesh.triangles.emplace_back(first, first + 1 + i, first + 1 + (i + 1) % sides);
}

} // namespace

MeshData plane_mesh(vec2 size, int segments_x, int segments_z) {
    MeshData mesh;
    for (int j = 0; j <= segments_z; ++j)
        for (int i = 0; i <= segments_x; ++i) {
            const float u = static_cast<float>(i) / static_cast<float>(segments_x);
            const float v = static_cast<float>(j) / static_cast<float>(segments_z);
            mesh.positions.emplace_back((u - 0.5f) * size.x, 0.0f, (v - 0.5f) * size.y);
        }
    const std::uint32_t row = u32(segments_x) + 1;
    for (std::uint32_t j = 0; j < u32(segments_z); ++j)
        for (std::uint32_t i = 0; i < u32(segments_x); ++i) {
            const std::uint32_t a = j * row + i;
            add_quad(mesh, a, a + row, a + row + 1, a + 1);
        }
    return mesh;
}

MeshData box_mesh(vec3 minimum, vec3 maximum) {
    const Bounds box{minimum, maximum};
    MeshData mesh;
    for (int i = 0; i < 8; ++i) mesh.positions.push_back(box.corner(i));
    add_quad(mesh, 0, 4, 6, 2); // −x
    add_quad(mesh, 1, 3, 7, 5); // +x
    add_quad(mesh, 0, 1, 5, 4); // −y
    add_quad(mesh, 2, 6, 7, 3); // +y
    add_quad(mesh, 0, 2, 3, 1); // −z
    add_quad(mesh, 4, 5, 7, 6); // +z
    return mesh;
}

MeshData sphere_mesh(float radius, int slices, int stacks) {
    MeshData mesh;
    const auto add = [&](vec3 direction) {
        mesh.positions.push_back(direction * radius);
        mesh.normals.push_back(direction);
    };
    add({0, 1, 0});
    for (int j = 1; j < stacks; ++j) {
        const double polar = pi * j / stacks;
        const auto y = static_cast<float>(std::cos(polar)), r = static_cast<float>(std::sin(polar));
        for (int i = 0; i < slices; ++i) {
            const vec2 c = circle(i, slices);
            add(unit({r * c.x, y, -r * c.y}));
        }
    }
    add({0, -1, 0});
    const std::uint32_t n = u32(slices), last = u32(stacks - 1) * n + 1;
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t next = (i + 1) % n;
        mesh.triangles.emplace_back(0, 1 + i, 1 + next);
        for (std::uint32_t j = 0; j + 2 < u32(stacks); ++j)
            add_quad(mesh, 1 + j * n + i, 1 + (j + 1) * n + i, 1 + (j + 1) * n + next, 1 + j * n + next);
        mesh.triangles.emplace_back(last, last - n + next, last - n + i);
    }
    return mesh;
}

MeshData cylinder_mesh(float bottom_radius, float top_radius, float height, int segments) {
    MeshData mesh;
    const std::uint32_t n = u32(segments);
    std::vector<vec3> bottom, top;
    for (int i = 0; i < segments; ++i) {
        const vec2 c = circle(i, segments);
        bottom.emplace_back(bottom_radius * c.x, 0.0f, -bottom_radius * c.y);
        top.emplace_back(top_radius * c.x, height, -top_radius * c.y);
        const vec3 normal = unit({height * c.x, bottom_radius - top_radius, -height * c.y});
        mesh.positions.insert(mesh.positions.end(), {bottom.back(), top.back()});
        mesh.normals.insert(mesh.normals.end(), {normal, normal});
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % n);
        if (bottom_radius > 0.0f) mesh.triangles.emplace_back(a, b, b + 1);
        if (top_radius > 0.0f) mesh.triangles.emplace_back(a, b + 1, a + 1);
        // A cone's side is one triangle a segment; at the apex the top vertices coincide.
        if (bottom_radius > 0.0f && top_radius == 0.0f) mesh.triangles.back() = {a, b, a + 1};
    }
    if (top_radius > 0.0f) add_cap(mesh, top, {0, height, 0}, {0, 1, 0});
    if (bottom_radius > 0.0f) {
        const std::vector<vec3> reversed(bottom.rbegin(), bottom.rend());
        add_cap(mesh, reversed, {0, 0, 0}, {0, -1, 0});
    }
    return mesh;
}

MeshData torus_mesh(float radius, float tube_radius, int segments, int sides) {
    MeshData mesh;
    for (int i = 0; i < segments; ++i)
        for (int j = 0; j < sides; ++j) {
            const vec2 around = circle(i, segments), tube = circle(j, sides);
            const float r = radius + tube_radius * tube.x;
            mesh.positions.emplace_back(r * around.x, tube_radius * tube.y, -r * around.y);
            mesh.normals.push_back(unit({tube.x * around.x, tube.y, -tube.x * around.y}));
        }
    const std::uint32_t n = u32(segments), m = u32(sides);
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < m; ++j)
            add_quad(mesh, i * m + j, (i + 1) % n * m + j, (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m);
    return mesh;
}

MeshData tube_mesh(std::span<const vec3> points, std::span<const float> radii, int sides) {
    assert(points.size() >= 2 && points.size() == radii.size());
    MeshData mesh;
    const size_t count = points.size();
    const auto direction = [&](size_t from, size_t to) {
        return glm::normalize(dvec3(points[to]) - dvec3(points[from]));
    };
    dvec3 forward = direction(0, 1);
    dvec3 right(any_tangent(vec3(forward)));
    std::vector<std::vector<vec3>> rings;
    for (size_t k = 0; k < count; ++k) {
        // The frame is carried along the line, so that the tube does not twist.
        const dvec3 before = direction(k == 0 ? 0 : k - 1, k == 0 ? 1 : k);
        const dvec3 after = k + 1 < count ? direction(k, k + 1) : before;
        const dvec3 sum = before + after;
        forward = glm::dot(sum, sum) > 1e-12 ? glm::normalize(sum) : before;
        right = glm::normalize(right - glm::dot(right, forward) * forward);
        const dvec3 up = glm::cross(forward, right);
        std::vector<vec3>& ring = rings.emplace_back();
        for (int i = 0; i < sides; ++i) {
            const vec2 c = circle(i, sides);
            const dvec3 outward = right * double(c.x) + up * double(c.y);
            ring.push_back(vec3(dvec3(points[k]) + outward * double(radii[k])));
            mesh.normals.push_back(unit(outward));
        }
        mesh.positions.insert(mesh.positions.end(), ring.begin(), ring.end());
    }
    const std::uint32_t n = u32(sides);
    for (std::uint32_t k = 0; k + 1 < count; ++k)
        for (std::uint32_t i = 0; i < n; ++i)
            add_quad(mesh, k * n + i, k * n + (i + 1) % n, (k + 1) * n + (i + 1) % n, (k + 1) * n + i);
    add_cap(mesh, rings.back(), points.back(), vec3(direction(count - 2, count - 1)));
    const std::vector<vec3> reversed(rings.front().rbegin(), rings.front().rend());
    add_cap(mesh, reversed, points.front(), vec3(-direction(0, 1)));
    return mesh;
}

MeshData rod_mesh(vec3 from, vec3 to, float radius, int sides) {
    return tube_mesh(std::array{from, to}, std::array{radius, radius}, sides);
}

float value_noise(vec2 p, std::uint32_t seed) {
    const vec2 cell = glm::floor(p), f = p - cell;
    const vec2 fade = f * f * (3.0f - 2.0f * f);
    const auto lattice = [&](int dx, int dy) {
        return to_unit(hash(static_cast<std::uint32_t>(static_cast<int>(cell.x) + dx),
                            static_cast<std::uint32_t>(static_cast<int>(cell.y) + dy), seed));
    };
    return glm::mix(glm::mix(lattice(0, 0), lattice(1, 0), fade.x), glm::mix(lattice(0, 1), lattice(1, 1), fade.x),
                    fade.y);
}

MeshData grid_mesh(vec2 size, int segments, float height, float bump_size, std::uint32_t seed) {
    MeshData mesh = plane_mesh(size, segments, segments);
    for (vec3& p : mesh.positions) {
        const vec2 at = vec2(p.x, p.z) / bump_size;
        p.y = height * (0.75f * value_noise(at, seed) + 0.25f * value_noise(at * 2.0f, seed + 1));
    }
    return mesh;
}

void append_mesh(MeshData& mesh, const MeshData& part, const dmat4& transform) {
    const bool was_empty = mesh.positions.empty();
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    // One implementation of transforming vertices: that of add_object.
    Scene scratch;
    add_object(scratch, "part", part, transform, 0);
    mesh.positions.insert(mesh.positions.end(), scratch.positions.begin(), scratch.positions.end());
    if (was_empty || !mesh.normals.empty())
        mesh.normals.insert(mesh.normals.end(), scratch.normals.begin(), scratch.normals.end());
    if (mesh.normals.size() != mesh.positions.size()) mesh.normals.clear();
    for (const uvec3 t : scratch.triangles) mesh.triangles.push_back(t + first);
}

dmat4 translation(dvec3 offset) { return glm::translate(dmat4(1.0), offset); }
dmat4 rotation(double degrees, dvec3 axis) { return glm::rotate(dmat4(1.0), degrees * (pi / 180.0), axis); }
dmat4 scaling(dvec3 factors) { return glm::scale(dmat4(1.0), factors); }

} // namespace gnomon
