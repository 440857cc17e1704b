#include "core/light.h"

#include <algorithm>
#include <cmath>

#include "core/vector_clones.h"

namespace gnomon {

bool is_area(LightType type) { return (bit(type) & punctual_lights) == 0; }

const char* light_type_name(LightType type) {
    switch (type) {
    case LightType::Point:
        return "point";
    case LightType::Spot:
        return "spot";
    case LightType::Directional:
        return "directional";
    case LightType::Rectangle:
        return "rectangle";
    case LightType::Disk:
        return "disk";
    case LightType::Sphere:
        return "sphere";
    case LightType::TexturedRectangle:
        return "textured-rectangle";
    case LightType::Mesh:
        return "mesh";
    }
    return "";
}

std::vector<std::string> light_type_names(LightTypes types) {
    std::vector<std::string> names;
    for (int i = 0; i <= static_cast<int>(LightType::Mesh); ++i)
        if (const auto type = static_cast<LightType>(i); types & bit(type)) names.emplace_back(light_type_name(type));
    return names;
}

vec3 any_tangent(vec3 n) {
    const vec3 axis = std::abs(n.x) < 0.9f ? vec3(1, 0, 0) : vec3(0, 0, 1);
    return glm::normalize(axis - n * glm::dot(axis, n));
}

float surface_area(const Light& light) {
    const auto square = static_cast<float>(pi) * 0.25f * light.size.x * light.size.x;
    switch (light.type) {
    case LightType::Rectangle:
    case LightType::TexturedRectangle:
        return light.size.x * light.size.y;
    case LightType::Disk:
        return square;
    case LightType::Sphere:
        return 4.0f * square;
    case LightType::Mesh:
        return light.triangles.empty() ? 0.0f : light.triangles.back().area_up_to;
    default:
        return 0.0f;
    }
}

namespace {

// Unit square to unit disk, area-preserving, centre to centre [Shirley and Chiu 1997]. The angle from the nearer axis
// is at most π/4, where these Taylor polynomials are exact to float: the same bits from every library, and loops over
// samples vectorise.
inline vec2 concentric(float u, float v) {
    const float a = 2.0f * u - 1.0f, b = 2.0f * v - 1.0f;
    const bool wide = std::abs(a) > std::abs(b);
    const float radius = wide ? a : b, other = wide ? b : a;
    const float angle = static_cast<float>(pi / 4) * (other / (radius == 0.0f ? 1.0f : radius));
    const float t = angle * angle;
    const float sine = angle * (1 + t * (-1.0f / 6 + t * (1.0f / 120 + t * (-1.0f / 5040 + t * (1.0f / 362880)))));
    const float cosine = 1 + t * (-0.5f + t * (1.0f / 24 + t * (-1.0f / 720 + t * (1.0f / 40320))));
    return vec2(wide ? cosine : sine, wide ? sine : cosine) * radius;
}

// The plane figure that stands for a light as seen from one receiver: center + axes × coordinates.
struct Figure {
    vec3 center, axis_u, axis_v;
    float scale_u = 0, scale_v = 0; // width and height of a rectangle, radius of a disk; 0 for a point
    bool disk = false;
};

inline vec3 point_on(const Figure& figure, bool disk, float u, float v) {
    const vec2 d = disk ? concentric(u, v) : vec2(u - 0.5f, v - 0.5f);
    return figure.center + figure.axis_u * (d.x * figure.scale_u) + figure.axis_v * (d.y * figure.scale_v);
}

Figure figure_of(const Light& light, vec3 receiver) {
    Figure point{light.position, vec3(0.0f), vec3(0.0f)};
    const float radius = 0.5f * light.size.x;
    switch (light.type) {
    case LightType::Rectangle:
    case LightType::TexturedRectangle:
        return {light.position, light.tangent, bitangent(light), light.size.x, light.size.y, false};
    case LightType::Disk:
        return {light.position, light.tangent, bitangent(light), radius, radius, true};
    case LightType::Sphere: {
        const vec3 to_receiver = receiver - light.position;
        const float distance2 = glm::dot(to_receiver, to_receiver);
        if (distance2 <= radius * radius) return point;
        const vec3 axis = to_receiver / std::sqrt(distance2);
        const vec3 tangent = any_tangent(axis);
        const vec3 limb_center = light.position + axis * (radius * radius / std::sqrt(distance2));
        const float limb_radius = radius * std::sqrt(1.0f - radius * radius / distance2);
        return {limb_center, tangent, glm::cross(axis, tangent), limb_radius, limb_radius, true};
    }
    default:
        return point;
    }
}

template <bool disk>
inline void points_on(const Figure& figure, std::span<const float> u, std::span<const float> v, float* __restrict x,
                      float* __restrict y, float* __restrict z) {
    for (size_t i = 0; i < u.size(); ++i) {
        const vec3 p = point_on(figure, disk, u[i], v[i]);
        x[i] = p.x;
        y[i] = p.y;
        z[i] = p.z;
    }
}

vec3 texel_at(const Image<vec3>& texture, float u, float v) {
    const auto texel = [](float at, int count) {
        return std::min(static_cast<int>(at * static_cast<float>(count)), count - 1);
    };
    return texture(texel(u, texture.width()), texel(v, texture.height()));
}

// The triangle of a mesh that u falls on, and where in it u lies: in [0, 1).
const LightTriangle& triangle_at(const Light& light, float& u) {
    const float area = u * light.triangles.back().area_up_to;
    auto found = std::upper_bound(light.triangles.begin(), light.triangles.end(), area,
                                  [](float value, const LightTriangle& t) { return value < t.area_up_to; });
    if (found == light.triangles.end()) --found;
    const float before = found == light.triangles.begin() ? 0.0f : (found - 1)->area_up_to;
    u = std::clamp((area - before) / (found->area_up_to - before), 0.0f, 1.0f);
    return *found;
}

vec3 point_on_mesh(const Light& light, float u, float v) {
    const LightTriangle& t = triangle_at(light, u);
    const float shift = 0.5f * std::min(u, v);
    const float b = u > v ? u - shift : shift, c = u > v ? shift : v - shift;
    return t.a + (t.b - t.a) * b + (t.c - t.a) * c;
}

// A light seen from one receiver: what its samples have in common. A sphere is the disk of light_point, which faces the
// receiver and radiates as much towards it; from inside it sends nothing.
struct Emitter {
    const Light& light;
    Figure figure;
    LightSample common;
};

Emitter emitter_of(const Light& light, vec3 receiver) {
    Emitter emitter{light, figure_of(light, receiver), {{}, light.direction, light.intensity, surface_area(light)}};
    if (light.type != LightType::Sphere) return emitter;
    const vec3 to_receiver = receiver - light.position;
    const float radius2 = 0.25f * light.size.x * light.size.x, distance2 = glm::dot(to_receiver, to_receiver);
    if (distance2 <= radius2) {
        emitter.common.radiance = vec3(0.0f);
        emitter.common.area = 0.0f;
        return emitter;
    }
    emitter.common.facing = to_receiver / std::sqrt(distance2);
    emitter.common.area = static_cast<float>(pi) * radius2 * (1.0f - radius2 / distance2);
    return emitter;
}

LightSample sample_of(const Emitter& emitter, float u, float v) {
    LightSample sample = emitter.common;
    const Light& light = emitter.light;
    if (light.type == LightType::Mesh) {
        sample.position = point_on_mesh(light, u, v);
        sample.facing = triangle_at(light, u).normal;
        return sample;
    }
    sample.position = point_on(emitter.figure, emitter.figure.disk, u, v);
    if (light.type == LightType::TexturedRectangle && !light.texture.empty())
        sample.radiance *= texel_at(light.texture, u, v);
    return sample;
}

// Cosine-weighted sum over light_point's 8×8 cells; each cell carries the same share of the light. A row of cells would
// meet only eight places of a mesh, whose u goes through its triangles: there all 64 samples differ in u, and v steps
// by the golden ratio.
constexpr int quadrature_side = 8, quadrature_samples = quadrature_side * quadrature_side;

vec2 quadrature_point(LightType type, int i) {
    if (type != LightType::Mesh)
        return (vec2(i % quadrature_side, i / quadrature_side) + 0.5f) / static_cast<float>(quadrature_side);
    const float k = static_cast<float>(i) + 0.5f, turns = k * 0.618034f;
    return {k / static_cast<float>(quadrature_samples), turns - std::floor(turns)};
}

vec3 area_irradiance(const Light& light, vec3 p, vec3 n) {
    const Emitter emitter = emitter_of(light, p);
    vec3 sum(0.0f);
    for (int i = 0; i < quadrature_samples; ++i) {
        const vec2 uv = quadrature_point(light.type, i);
        const LightSample sample = sample_of(emitter, uv.x, uv.y);
        const vec3 d = sample.position - p;
        const float d2 = glm::dot(d, d);
        if (d2 <= 0.0f) continue;
        const float at_receiver = glm::dot(n, d), at_light = -glm::dot(sample.facing, d);
        if (at_receiver <= 0.0f || at_light <= 0.0f) continue;
        sum += sample.radiance * (sample.area * at_receiver * at_light / (d2 * d2));
    }
    return sum / static_cast<float>(quadrature_samples);
}

float spot_factor(const Light& light, vec3 to_light) {
    // KHR_lights_punctual: smooth between the two cosines.
    const float cosine = -glm::dot(light.direction, to_light);
    const float outer = std::cos(light.outer_cone), inner = std::cos(light.inner_cone);
    const float t = std::clamp((cosine - outer) / std::max(1e-4f, inner - outer), 0.0f, 1.0f);
    return t * t;
}

} // namespace

void set_triangles(Light& light, std::span<const vec3> corners) {
    light.triangles.clear();
    double area = 0;
    dvec3 center(0), normals(0);
    for (size_t i = 0; i + 2 < corners.size(); i += 3) {
        const dvec3 a(corners[i]), b(corners[i + 1]), c(corners[i + 2]);
        const dvec3 normal = glm::cross(b - a, c - a) * 0.5;
        const double own = glm::length(normal);
        const auto up_to = static_cast<float>(area + own);
        if (!(up_to > static_cast<float>(area))) continue;
        area += own;
        center += (a + b + c) / 3.0 * own;
        normals += normal;
        light.triangles.push_back({corners[i], corners[i + 1], corners[i + 2], vec3(normal / own), up_to});
    }
    if (area > 0) light.position = vec3(center / area);
    const double length = glm::length(normals);
    light.direction = length > 1e-6 * area ? vec3(normals / length) : vec3(0, -1, 0);
    light.tangent = any_tangent(light.direction);
}

vec3 light_point(const Light& light, float u, float v, vec3 receiver) {
    if (light.type == LightType::Mesh) return point_on_mesh(light, u, v);
    const Figure figure = figure_of(light, receiver);
    return point_on(figure, figure.disk, u, v);
}

GNOMON_VECTOR_CLONES
void light_points(const Light& light, vec3 receiver, std::span<const float> u, std::span<const float> v,
                  std::span<float> x, std::span<float> y, std::span<float> z) {
    if (light.type == LightType::Mesh) {
        for (size_t i = 0; i < u.size(); ++i) {
            const vec3 p = point_on_mesh(light, u[i], v[i]);
            x[i] = p.x, y[i] = p.y, z[i] = p.z;
        }
        return;
    }
    const Figure figure = figure_of(light, receiver);
    if (figure.disk)
        points_on<true>(figure, u, v, x.data(), y.data(), z.data());
    else
        points_on<false>(figure, u, v, x.data(), y.data(), z.data());
}

LightSample light_sample(const Light& light, float u, float v, vec3 receiver) {
    return sample_of(emitter_of(light, receiver), u, v);
}

vec3 direction_to_light(const Light& light, vec3 p) {
    if (light.type == LightType::Directional) return -light.direction;
    const vec3 d = light.position - p;
    const float length = glm::length(d);
    return length > 0.0f ? d / length : vec3(0.0f);
}

vec3 unshadowed_irradiance(const Light& light, vec3 p, vec3 n) {
    if (is_area(light)) return area_irradiance(light, p, n);
    const vec3 to_light = direction_to_light(light, p);
    const float cosine = std::max(0.0f, glm::dot(n, to_light));
    if (light.type == LightType::Directional) return light.intensity * cosine;
    const vec3 d = light.position - p;
    const float distance2 = std::max(glm::dot(d, d), 1e-12f);
    float factor = cosine / distance2;
    if (light.range < infinity) {
        const float ratio2 = distance2 / (light.range * light.range);
        factor *= std::clamp(1.0f - ratio2 * ratio2, 0.0f, 1.0f);
    }
    if (light.type == LightType::Spot) factor *= spot_factor(light, to_light);
    return light.intensity * factor;
}

} // namespace gnomon
