#include "core/scene.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "core/parallel.h"
#include "core/scene_load.h"

namespace gnomon {
namespace {

constexpr size_t grain = size_t{1} << 15;
constexpr size_t max_triangles = size_t{1} << 31;
constexpr size_t max_vertices = 0xffffffffu;

bool finite(vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

// Determinant times inverse transpose, which exists for flattening transforms too.
glm::dmat3 cofactors(const glm::dmat3& m) {
    return {glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1])};
}

vec3 transformed_normal(vec3 normal, const glm::dmat3& matrix, bool identity) {
    const dvec3 n = identity ? dvec3(normal) : matrix * dvec3(normal);
    const double length = glm::length(n);
    return std::isfinite(length) && length > 1e-30 ? unit(n) : vec3(0.0f);
}

// Vertices through the transform, appended; returns the index of the first. Under the identity they keep their bits (−0
// too).
size_t append_vertices(Scene& scene, const std::string& name, std::span<const vec3> positions,
                       std::span<const vec3> normals, std::span<const vec2> uvs, const dmat4& transform) {
    const size_t first = scene.positions.size(), count = positions.size();
    if (first + count > max_vertices)
        throw InputError("'" + name + "' brings the scene to more than 2^32 vertices; split it");
    const bool identity = transform == dmat4(1.0);
    const double orientation = glm::determinant(glm::dmat3(transform)) < 0 ? -1.0 : 1.0;
    const glm::dmat3 normal_matrix = cofactors(glm::dmat3(transform)) * orientation;
    const bool with_normals = normals.size() == count && count > 0, with_uvs = uvs.size() == count && count > 0;
    scene.positions.resize(first + count);
    if (with_normals || !scene.normals.empty()) scene.normals.resize(first + count, vec3(0.0f));
    if (with_uvs || !scene.uvs.empty()) scene.uvs.resize(first + count, vec2(0.0f));

    std::atomic<size_t> broken{count};
    parallel_for(count, grain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const vec3 p = identity ? positions[i] : vec3(dvec3(transform * dvec4(dvec3(positions[i]), 1.0)));
            scene.positions[first + i] = p;
            if (!finite(p)) {
                size_t lowest = broken.load();
                while (i < lowest && !broken.compare_exchange_weak(lowest, i)) {
                }
            }
            if (with_normals) scene.normals[first + i] = transformed_normal(normals[i], normal_matrix, identity);
            if (with_uvs) scene.uvs[first + i] = uvs[i];
        }
    });
    if (broken < count)
        throw InputError("the position of vertex " + std::to_string(broken.load()) + " of '" + name +
                         "' is not finite; repair the mesh or its transform");
    return first;
}

// Triangles over vertices from `first_vertex` on, appended without their object; returns the index of the first.
size_t append_triangles(Scene& scene, const std::string& name, std::span<const uvec3> triangles, size_t first_vertex,
                        bool mirrored) {
    const size_t first = scene.triangles.size(), count = triangles.size();
    const size_t vertices = scene.positions.size() - first_vertex;
    if (first + count > max_triangles)
        throw InputError("'" + name + "' brings the scene to more than 2^31 triangles; split it");
    scene.triangles.resize(first + count);
    std::atomic<size_t> broken{count};
    parallel_for(count, grain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = triangles[i];
            if (std::max({t.x, t.y, t.z}) >= vertices) {
                size_t lowest = broken.load();
                while (i < lowest && !broken.compare_exchange_weak(lowest, i)) {
                }
                continue;
            }
            const uvec3 world = t + static_cast<std::uint32_t>(first_vertex);
            scene.triangles[first + i] = mirrored ? uvec3(world.x, world.z, world.y) : world;
        }
    });
    if (broken < count) {
        const uvec3 t = triangles[broken];
        throw InputError("triangle " + std::to_string(broken.load()) + " of '" + name + "' uses vertex " +
                         std::to_string(std::max({t.x, t.y, t.z})) + ", but there are only " +
                         std::to_string(vertices) + " vertices; repair the index buffer");
    }
    return first;
}

Bounds triangle_bounds(const Scene& scene, size_t first, size_t count) {
    std::vector<Bounds> parts(chunk_count(count, grain));
    parallel_for(count, grain, [&](size_t begin, size_t end) {
        Bounds& part = parts[begin / grain];
        for (size_t i = begin; i < end; ++i)
            for (int corner = 0; corner < 3; ++corner) part.extend(scene.positions[scene.triangles[first + i][corner]]);
    });
    Bounds bounds;
    for (const Bounds& part : parts) bounds.extend(part.minimum), bounds.extend(part.maximum);
    return bounds;
}

bool is_mirrored(const dmat4& transform) { return glm::determinant(glm::dmat3(transform)) < 0; }

} // namespace

vec3 unit(dvec3 v) {
    const double length = glm::length(v);
    if (!(length > 0)) return vec3(0.0f);
    return std::abs(length - 1.0) < unit_tolerance ? vec3(v) : vec3(v / length);
}

vec3 unit_orthogonal(dvec3 v, vec3 n) {
    const double along = glm::dot(v, dvec3(n)) / glm::dot(dvec3(n), dvec3(n));
    return unit(std::abs(along) < unit_tolerance * glm::length(v) ? v : v - along * dvec3(n));
}

vec3 geometric_normal(const Scene& scene, std::uint32_t triangle) {
    const uvec3 t = scene.triangles[triangle];
    const dvec3 a(scene.positions[t.x]), b(scene.positions[t.y]), c(scene.positions[t.z]);
    const dvec3 n = glm::cross(b - a, c - a);
    // Scaled first: the squares of a microscopic triangle's normal would underflow.
    const double largest = std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)});
    return largest > 0 ? vec3(glm::normalize(n / largest)) : vec3(0.0f);
}

void add_object(Scene& scene, const std::string& name, const MeshData& mesh, const dmat4& transform,
                std::uint32_t material) {
    const size_t vertex = append_vertices(scene, name, mesh.positions, mesh.normals, mesh.uvs, transform);
    const size_t first = append_triangles(scene, name, mesh.triangles, vertex, is_mirrored(transform));
    scene.triangle_objects.resize(scene.triangles.size(), static_cast<std::uint32_t>(scene.objects.size()));
    Object object;
    object.name = name;
    object.first_triangle = static_cast<std::uint32_t>(first);
    object.triangle_count = static_cast<std::uint32_t>(mesh.triangles.size());
    object.material = material;
    object.bounds = triangle_bounds(scene, first, mesh.triangles.size());
    scene.objects.push_back(std::move(object));
}

void append_scene(Scene& scene, const Scene& other, const dmat4& transform, AppendOptions options) {
    const size_t vertex = append_vertices(scene, other.name, other.positions, other.normals, other.uvs, transform);
    const size_t first = append_triangles(scene, other.name, other.triangles, vertex, is_mirrored(transform));
    const auto first_object = static_cast<std::uint32_t>(scene.objects.size());
    const auto first_material = static_cast<std::uint32_t>(scene.materials.size());
    const int first_texture = static_cast<int>(scene.textures.size());
    for (const std::uint32_t object : other.triangle_objects) scene.triangle_objects.push_back(first_object + object);
    for (Object object : other.objects) {
        object.first_triangle += static_cast<std::uint32_t>(first);
        object.material += first_material;
        object.bounds = triangle_bounds(scene, object.first_triangle, object.triangle_count);
        object.light_source = object.light_source && options.lights;
        scene.objects.push_back(std::move(object));
    }
    for (Material material : other.materials) {
        if (material.base_color_texture >= 0) material.base_color_texture += first_texture;
        scene.materials.push_back(std::move(material));
    }
    scene.textures.insert(scene.textures.end(), other.textures.begin(), other.textures.end());
    scene.warnings.insert(scene.warnings.end(), other.warnings.begin(), other.warnings.end());
    if (options.lights)
        for (const Light& light : other.lights) {
            scene.lights.push_back(transformed(light, transform));
            scene.lights.back().name.clear();
            scene.lights.back().name = unique_light_name(scene, light.name);
        }
    if (options.cameras)
        for (const Camera& camera : other.cameras) {
            scene.cameras.push_back(transformed(camera, transform));
            scene.cameras.back().name.clear();
            scene.cameras.back().name = unique_camera_name(scene, camera.name);
        }
}

namespace {

float linear(std::uint8_t value) {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> t{};
        for (size_t i = 0; i < t.size(); ++i) {
            const double s = static_cast<double>(i) / 255.0;
            t[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
        }
        return t;
    }();
    return table[value];
}

// A texture coordinate brought into [0, 1], so that no later arithmetic can overflow.
float wrapped(float u, Texture::Wrap wrap) {
    if (!std::isfinite(u)) return 0.0f;
    if (wrap == Texture::Wrap::Clamp) return std::clamp(u, 0.0f, 1.0f);
    if (wrap == Texture::Wrap::Repeat) return u - std::floor(u);
    const float period = u - 2.0f * std::floor(0.5f * u);
    return period > 1.0f ? 2.0f - period : period;
}

int texel(int i, int size, Texture::Wrap wrap) {
    return wrap == Texture::Wrap::Repeat ? (i % size + size) % size : std::clamp(i, 0, size - 1);
}

} // namespace

vec4 sample_texture(const Texture& texture, vec2 uv) {
    if (texture.image.empty()) return vec4(1.0f);
    const int width = texture.image.width(), height = texture.image.height();
    const float x = wrapped(uv.x, texture.wrap_u) * static_cast<float>(width) - 0.5f;
    const float y = wrapped(uv.y, texture.wrap_v) * static_cast<float>(height) - 0.5f;
    const float left = std::floor(x), top = std::floor(y);
    const auto fetch = [&](int dx, int dy) {
        const glm::u8vec4 t = texture.image(texel(static_cast<int>(left) + dx, width, texture.wrap_u),
                                            texel(static_cast<int>(top) + dy, height, texture.wrap_v));
        return vec4(linear(t.x), linear(t.y), linear(t.z), static_cast<float>(t.w) / 255.0f);
    };
    return glm::mix(glm::mix(fetch(0, 0), fetch(1, 0), x - left), glm::mix(fetch(0, 1), fetch(1, 1), x - left),
                    y - top);
}

} // namespace gnomon
