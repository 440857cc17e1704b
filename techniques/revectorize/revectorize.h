#pragma once
// The visibility functions of revectorization, and what they say of one point of a source: conservative V,
// non-conservative V*, filtered V**. [Macedo 2018, algorithm 1 and eqs. 3.6, 3.9, 4.2]

#include "techniques/revectorize/silhouette.h"

namespace gnomon {

// Shadow fills the lit triangle between a step's corner and the line through the outer corners. Of lit points (3.6)
inline bool conservative_visibility(vec2 r) { return !(r.x * r.y > 0 && 1.0f - r.x > r.y); }

// The line goes through the middle of the steps, from both sides; on it a point is lit. (3.9)
inline bool nonconservative_visibility(vec2 r, bool lit) {
    const float v = lit ? 1.0f : 0.0f;
    if (r.x * r.y == 2.0f * v) return false; // only in the umbra: I- and U-shapes stay
    return !(std::abs(r.x) * std::abs(r.y) > 0 &&
             (1.0f - v) + (2.0f * v - 1.0f) * (std::abs(r.x) + std::abs(r.y)) < 0.5f);
}

// A ramp over the step instead of a line. (4.2)
inline float filtered_visibility(vec2 r, bool lit) {
    const float v = lit ? 1.0f : 0.0f, product = r.x * r.y;
    if (product < 0) return 1.0f - v + (2.0f * v - 1.0f) * std::max(r.x, r.y);
    if (product == 0) return v;
    return std::clamp(1.0f - v + (2.0f * v - 1.0f) * (r.x + r.y), 0.0f, 1.0f);
}

// A point's answer, and how it came about.
struct Revectorized {
    float visibility = 1.0f;
    bool lit = true;              // V_SM
    unsigned discontinuities = 0; // bits of Side
    vec2 relative{0.0f};          // zero where nothing was walked
};

// Whether a lit texel lies between two shadows, along x or along y.
inline bool closes_gap(unsigned sides) {
    constexpr unsigned both_x = x_minus | x_plus, both_y = y_minus | y_plus;
    return (sides & both_x) == both_x || (sides & both_y) == both_y;
}

struct ConservativeOptions {
    bool fill_gaps = false;       // a lit texel between two shadows is dark
    bool vertical_u_as_l = false; // a run along y that both ends close counts as closed above alone [listing B.5]
};

// Algorithm 1, the lit side alone.
template <class Source>
Revectorized conservative(const Source& source, const SilhouetteRules& rules, const MapSample& sample,
                          const ConservativeOptions& options = {}) {
    const Silhouette<Source> silhouette(source, rules);
    const SilhouettePoint p = silhouette.point(sample);
    if (!p.lit) return {0.0f, false, 0, vec2(0.0f)};
    const unsigned sides = silhouette.discontinuities(p.place, p.depth, true);
    if (sides == 0) return {1.0f, true, 0, vec2(0.0f)};
    if (options.fill_gaps && closes_gap(sides)) return {0.0f, true, sides, vec2(0.0f)};
    RunDistances distances = silhouette.distances(p, sides);
    if (options.vertical_u_as_l && distances.y_minus > 0 && distances.y_plus > 0)
        distances.y_minus = -distances.y_minus;
    const vec2 r = relative_position(distances, true, rules.max_size);
    return {conservative_visibility(r) ? 1.0f : 0.0f, true, sides, r};
}

// Algorithm 1, both sides. `flip_isolated`: a texel that differs from all four neighbours takes their state.
template <class Source>
Revectorized nonconservative(const Source& source, const SilhouetteRules& rules, const MapSample& sample,
                             bool flip_isolated) {
    const Silhouette<Source> silhouette(source, rules);
    const SilhouettePoint p = silhouette.point(sample);
    const unsigned sides = silhouette.discontinuities(p.place, p.depth, p.lit);
    if (sides == 0 || (flip_isolated && sides == all_sides))
        return {p.lit == (sides == 0) ? 1.0f : 0.0f, p.lit, sides, vec2(0.0f)};
    const vec2 r = relative_position(silhouette.distances(p, sides), p.lit, rules.max_size);
    return {nonconservative_visibility(r, p.lit) ? 1.0f : 0.0f, p.lit, sides, r};
}

// The same with fractions of light. [4.1.1]
template <class Source>
Revectorized filtered(const Source& source, const SilhouetteRules& rules, const MapSample& sample, bool flip_isolated) {
    const Silhouette<Source> silhouette(source, rules);
    const SilhouettePoint p = silhouette.point(sample);
    const unsigned sides = silhouette.discontinuities(p.place, p.depth, p.lit);
    if (sides == 0 || (flip_isolated && sides == all_sides))
        return {p.lit == (sides == 0) ? 1.0f : 0.0f, p.lit, sides, vec2(0.0f)};
    const vec2 r = signed_relative_position(silhouette.distances(p, sides), rules.max_size);
    return {filtered_visibility(r, p.lit), p.lit, sides, r};
}

} // namespace gnomon
