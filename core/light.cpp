#include "core/light.h"

#include <algorithm>
#include <cmath>

#include "core/vector_clones.h"

namespace gnomon {

bool is_area(LightType type) { return (bit(type) & area_lights) != 0; }

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
    }
    return "";
}

std::vector<std::string> light_type_names(LightTypes types) {
    std::vector<std::string> names;
    for (int i = 0; i <= static_cast<int>(LightType::TexturedRectangle); ++i)
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

// Cosine-weighted sum over light_point's 8×8 cells; each cell carries the same share of the light.
constexpr int quadrature_side = 8;

vec3 area_irradiance(const Light& light, vec3 p, vec3 n) {
    const bool sphere = light.type == LightType::Sphere;
    const vec3 to_center = light.position - p;
    const float distance2 = glm::dot(to_center, to_center);
    const float radius = 0.5f * light.size.x;
    if (sphere && distance2 <= radius * radius) return vec3(0.0f);
    // A sphere seen from p is the disk of light_point, which faces p and radiates as much towards it.
    const float limb2 = sphere ? radius * radius * (1.0f - radius * radius / distance2) : 0.0f;
    const float area = sphere ? static_cast<float>(pi) * limb2 : surface_area(light);
    const vec3 facing = sphere ? -to_center / std::sqrt(distance2) : light.direction;
    vec3 sum(0.0f);
    for (int j = 0; j < quadrature_side; ++j)
        for (int i = 0; i < quadrature_side; ++i) {
            const float u = (static_cast<float>(i) + 0.5f) / quadrature_side;
            const float v = (static_cast<float>(j) + 0.5f) / quadrature_side;
            const vec3 d = light_point(light, u, v, p) - p;
            const float d2 = glm::dot(d, d);
            if (d2 <= 0.0f) continue;
            const float at_receiver = glm::dot(n, d), at_light = -glm::dot(facing, d);
            if (at_receiver <= 0.0f || at_light <= 0.0f) continue;
            vec3 radiance = light.intensity;
            if (light.type == LightType::TexturedRectangle && !light.texture.empty())
                radiance *= light.texture(std::min(static_cast<int>(u * static_cast<float>(light.texture.width())),
                                                   light.texture.width() - 1),
                                          std::min(static_cast<int>(v * static_cast<float>(light.texture.height())),
                                                   light.texture.height() - 1));
            sum += radiance * (at_receiver * at_light / (d2 * d2));
        }
    return sum * (area / (quadrature_side * quadrature_side));
}

float spot_factor(const Light& light, vec3 to_light) {
    // KHR_lights_punctual: smooth between the two cosines.
    const float cosine = -glm::dot(light.direction, to_light);
    const float outer = std::cos(light.outer_cone), inner = std::cos(light.inner_cone);
    const float t = std::clamp((cosine - outer) / std::max(1e-4f, inner - outer), 0.0f, 1.0f);
    return t * t;
}

} // namespace

vec3 light_point(const Light& light, float u, float v, vec3 receiver) {
    const Figure figure = figure_of(light, receiver);
    return point_on(figure, figure.disk, u, v);
}

GNOMON_VECTOR_CLONES
void light_points(const Light& light, vec3 receiver, std::span<const float> u, std::span<const float> v,
                  std::span<float> x, std::span<float> y, std::span<float> z) {
    const Figure figure = figure_of(light, receiver);
    if (figure.disk)
        points_on<true>(figure, u, v, x.data(), y.data(), z.data());
    else
        points_on<false>(figure, u, v, x.data(), y.data(), z.data());
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
