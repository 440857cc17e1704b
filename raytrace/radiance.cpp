#include "raytrace/radiance.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace gnomon {
namespace {

constexpr float inverse_pi = static_cast<float>(1.0 / pi);

vec3 ggx(const Surface& surface, vec3 to_light) {
    const float at_light = glm::dot(surface.normal, to_light), at_viewer = glm::dot(surface.normal, surface.to_viewer);
    if (at_light <= 0.0f || at_viewer <= 0.0f) return vec3(0.0f);
    const vec3 half = glm::normalize(to_light + surface.to_viewer);
    const float at_half = glm::dot(surface.normal, half);
    const float alpha = std::max(1e-3f, surface.roughness * surface.roughness), alpha2 = alpha * alpha;
    // 1 − (n·h)² from the cross product, which keeps its digits where a sharp highlight needs them.
    const vec3 across = glm::cross(surface.normal, half);
    const float spread = alpha2 * at_half * at_half + glm::dot(across, across);
    const float distribution = alpha2 * inverse_pi / (spread * spread);
    const auto lambda = [&](float cosine) { return std::sqrt(alpha2 + (1.0f - alpha2) * cosine * cosine); };
    const float shadowing = 0.5f / (at_viewer * lambda(at_light) + at_light * lambda(at_viewer)); // G₂ / (4 n·l n·v)
    const float grazing = std::clamp(1.0f - glm::dot(half, to_light), 0.0f, 1.0f);
    const float fresnel = grazing * grazing * grazing * grazing * grazing;
    const vec3 specular = vec3(distribution * shadowing);
    const float dielectric = 0.04f + 0.96f * fresnel;
    const vec3 of_dielectric = glm::mix(surface.albedo * inverse_pi, specular, dielectric);
    const vec3 of_metal = specular * (surface.albedo + (vec3(1.0f) - surface.albedo) * fresnel);
    return glm::mix(of_dielectric, of_metal, surface.metallic);
}

// Of one sample that is seen.
vec3 contribution(Brdf model, const Surface& surface, const LightSample& sample) {
    const vec3 way = sample.position - surface.position;
    const float distance2 = glm::dot(way, way);
    if (!(distance2 > 0.0f)) return vec3(0.0f);
    const vec3 to_light = way / std::sqrt(distance2);
    const float at_receiver = glm::dot(surface.normal, to_light), at_light = -glm::dot(sample.facing, to_light);
    if (at_receiver <= 0.0f || at_light <= 0.0f) return vec3(0.0f);
    return brdf(model, surface, to_light) * sample.radiance * (at_receiver * at_light * (sample.area / distance2));
}

} // namespace

vec3 brdf(Brdf model, const Surface& surface, vec3 to_light) {
    if (model == Brdf::Ggx) return ggx(surface, to_light);
    return glm::dot(surface.normal, to_light) > 0.0f ? surface.albedo * inverse_pi : vec3(0.0f);
}

vec3 reflected_radiance(Brdf model, const Surface& surface, const Light& light, std::span<const float> u,
                        std::span<const float> v, std::span<const std::uint32_t> index, const SampleBits& bits) {
    if (bits.seen() == 0) return vec3(0.0f);
    if (!is_area(light))
        return brdf(model, surface, direction_to_light(light, surface.position)) *
               unshadowed_irradiance(light, surface.position, surface.normal);
    std::vector<vec3> in_sequence(index.size(), vec3(0.0f));
    for (size_t k = 0; k < index.size(); ++k)
        if (bits[index[k]])
            in_sequence[index[k]] = contribution(model, surface, light_sample(light, u[k], v[k], surface.position));
    dvec3 sum(0.0);
    for (const vec3 part : in_sequence) sum += dvec3(part);
    return vec3(sum / static_cast<double>(index.size()));
}

} // namespace gnomon
