#pragma once
// Direct illumination, integrated: the light that a receiver's surface sends to the viewer, from the light samples that
// it sees. The estimator is (1/N) Σ seen · f(ω) · L · cos θ · cos θ_light · area / distance², by area as visibility is.

#include <cstdint>
#include <functional>

#include "core/light.h"
#include "raytrace/sample_bits.h"

namespace gnomon {

enum class Brdf : std::uint8_t { Lambert, Ggx };

// What the light falls on.
struct Surface {
    vec3 position{0.0f};
    vec3 normal{0.0f, 1.0f, 0.0f}; // unit, for shading
    vec3 to_viewer{0.0f};          // unit
    vec3 albedo{0.0f};             // linear base colour
    float roughness = 1, metallic = 0;
};

// Per steradian, without the cosine; `to_light` and the surface's vectors are unit. 0 where the light is below the
// horizon of `normal`; of Ggx also where the viewer is.
// - Lambert: albedo / π.
// - Ggx: glTF 2.0's metallic-roughness model (appendix B): diffuse and microfacet reflection, mixed by Schlick's
//   Fresnel term with F₀ = 0.04 (dielectric) or the base colour (metal); α = roughness², GGX distribution [Walter et
//   al. 2007, eq. 33] and height-correlated Smith shadowing [Heitz 2014, eq. 99]. α is at least 10⁻³, so that a mirror
//   is a very small highlight instead of none.
vec3 brdf(Brdf model, const Surface& surface, vec3 to_light);

// W/(m² sr) towards the viewer, from the first `count` samples of the light. `u`, `v` are their coordinates and `index`
// their places in the sequence: sums are in double and in that sequence, so that they do not depend on how the samples
// came. A punctual light is its one sample.
vec3 reflected_radiance(Brdf model, const Surface& surface, const Light& light, std::span<const float> u,
                        std::span<const float> v, std::span<const std::uint32_t> index, const SampleBits& bits);

} // namespace gnomon
