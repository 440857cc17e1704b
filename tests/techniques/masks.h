#pragma once
// Shadow maps that are a mask: a receiver of one depth under a caster of another, exactly as revectorization's closed
// forms have them. Texels are counted from the mask's own origin, either way. [Macedo 2018, section 4, MASK-k]

#include "techniques/revectorize/revectorize.h"

namespace gnomon_tests {

// shadow(i, j) -> bool
template <class Shadow> struct MaskSource {
    Shadow shadow;
    float caster = 0.25f, receiver = 0.75f;
    float behind(gnomon::ivec2 texel, float depth) const {
        return depth - (shadow(texel.x, texel.y) ? caster : receiver);
    }
};
template <class Shadow> MaskSource(Shadow) -> MaskSource<Shadow>;

enum class Variant { Plain, Conservative, Nonconservative, Filtered };

struct MaskOptions {
    gnomon::SilhouetteRules rules;
    bool flip_isolated = true;
    gnomon::ConservativeOptions conservative = {};
};

// The rules that the techniques have by default.
inline gnomon::SilhouetteRules default_rules(Variant variant) {
    gnomon::SilhouetteRules rules;
    if (variant == Variant::Conservative)
        rules.continuation = gnomon::Continuation::Any, rules.reject_isolated_end = false;
    return rules;
}

// The visibility of the receiver's point (u, v), in texels.
template <class Source>
gnomon::Revectorized look_up(const Source& source, Variant variant, gnomon::vec2 at, const MaskOptions& options) {
    const gnomon::MapSample sample = {at, 0.75f, 2.5e-5f};
    switch (variant) {
    case Variant::Conservative:
        return conservative(source, options.rules, sample, options.conservative);
    case Variant::Nonconservative:
        return nonconservative(source, options.rules, sample, options.flip_isolated);
    case Variant::Filtered:
        return filtered(source, options.rules, sample, options.flip_isolated);
    case Variant::Plain:
        break;
    }
    return {source.behind(gnomon::ivec2(glm::floor(at)), sample.depth) <= 0 ? 1.0f : 0.0f};
}

template <class Source>
float visibility_at(const Source& source, Variant variant, gnomon::vec2 at, const MaskOptions& options) {
    return look_up(source, variant, at, options).visibility;
}
template <class Source> float visibility_at(const Source& source, Variant variant, gnomon::vec2 at) {
    return visibility_at(source, variant, at, {.rules = default_rules(variant)});
}

// Integral of 1 − V over the texels [x0, x1) × [y0, y1), in texels²: 1024 points of a Kronecker sequence in every
// texel that has a discontinuity, which no straight edge lines up with, and one point in the others.
template <class Source>
double shadow_area(const Source& source, Variant variant, gnomon::ivec2 low, gnomon::ivec2 high,
                   const MaskOptions& options) {
    constexpr int points = 1024;
    double area = 0;
    for (int j = low.y; j < high.y; ++j)
        for (int i = low.x; i < high.x; ++i) {
            const gnomon::vec2 corner(static_cast<float>(i), static_cast<float>(j));
            const gnomon::Revectorized middle = look_up(source, variant, corner + 0.5f, options);
            if (middle.discontinuities == 0) {
                area += 1.0 - static_cast<double>(middle.visibility);
                continue;
            }
            double dark = 0;
            for (int k = 0; k < points; ++k) {
                const gnomon::dvec2 within = glm::fract(gnomon::dvec2(0.7548776662, 0.5698402910) * (k + 0.5));
                dark +=
                    1.0 - static_cast<double>(visibility_at(source, variant, corner + gnomon::vec2(within), options));
            }
            area += dark / points;
        }
    return area;
}
template <class Source>
double shadow_area(const Source& source, Variant variant, gnomon::ivec2 low, gnomon::ivec2 high) {
    return shadow_area(source, variant, low, high, {.rules = default_rules(variant)});
}

} // namespace gnomon_tests
