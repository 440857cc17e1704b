#pragma once
// The silhouette that a shadow map shows as a staircase of texels, walked from one point of it: on which sides of its
// texel the shadow begins or ends, how far the run of such texels goes each way, and where in the step the point lies.
// What all revectorization techniques are made of. [Macedo 2018, 3.1 and 3.2, eqs. 3.1 to 3.5, 4.1; listings A.2 to
// A.4]
//
// A source says how far a depth lies behind what a texel stores: `float behind(ivec2 texel, float depth) const`, in
// window depth, at most 0 where the point is lit. Shadow maps are sources, and so are masks in tests.
//
// Directions have the names of signs: the thesis itself calls the same one top and bottom.

#include <algorithm>
#include <cmath>

#include "core/math.h"

namespace gnomon {

enum Side : unsigned { x_minus = 1, x_plus = 2, y_minus = 4, y_plus = 8, all_sides = 15 };
inline constexpr ivec2 direction(Side side) {
    return {int{side == x_plus} - int{side == x_minus}, int{side == y_plus} - int{side == y_minus}};
}

// When a run goes on at the next texel, which has the point's own state.
enum class Continuation {
    Any,   // it has some discontinuity [listing A.3]
    Share, // it has one that the point's texel has too [3.1.3]
    Perp,  // it has one that the point's texel has too and that lies across the walk [the author's programs]
};

struct SilhouetteRules {
    int max_size = 16; // texels walked at most
    Continuation continuation = Continuation::Perp;
    bool reject_isolated_end = true; // a texel without a neighbour of its own state closes no run
    int float_steps = 0;             // 0: whole texels; else the map's side: steps of 1/side in float32 coordinates
};

// What a receiver, or a tap of its kernel, asks the map.
struct MapSample {
    vec2 texels{0.0f}; // from the map's lower left corner
    float depth = 0.0f;
    float slope_eps = 0.0f; // window depth: nearer than this counts as the receiver's own slope; 0: nothing does
};

// A texel, and the coordinates in [0, 1] that float steps go by.
struct MapPlace {
    ivec2 texel{0};
    vec2 uv{0.0f};
};

struct SilhouettePoint {
    MapPlace place;
    vec2 within{0.0f}; // of its texel, [0, 1)² (3.1)
    float depth = 0.0f, slope_eps = 0.0f;
    bool lit = true; // (3.2)
};

// Signed distances to the ends of the run, in texels: positive where the other state closes it.
struct RunDistances {
    float x_minus, x_plus, y_minus, y_plus;
};

template <class Source> class Silhouette {
public:
    Silhouette(const Source& source, const SilhouetteRules& rules) : source_(source), rules_(rules) {}

    // The sample's place in its texel, with its shadow test. (3.1), (3.2)
    SilhouettePoint point(const MapSample& sample) const {
        const vec2 corner = glm::floor(sample.texels);
        SilhouettePoint p = {{ivec2(corner)}, sample.texels - corner, sample.depth, sample.slope_eps, true};
        if (rules_.float_steps) p.place.uv = sample.texels / static_cast<float>(rules_.float_steps);
        p.lit = lit(p.place, p.depth);
        return p;
    }

    bool lit(const MapPlace& place, float depth) const { return source_.behind(place.texel, depth) <= 0.0f; }

    // The sides of a texel on which its state changes, where that is `state`. (3.3)
    unsigned discontinuities(const MapPlace& place, float depth, bool state) const {
        unsigned sides = 0;
        for (const Side side : {x_minus, x_plus, y_minus, y_plus})
            if (lit(neighbour(place, side), depth) != state) sides |= side;
        return sides;
    }

    // What the traversals give, for a point with these discontinuities.
    RunDistances distances(const SilhouettePoint& p, unsigned sides) const {
        return {walk(p, sides, x_minus, p.within.x), walk(p, sides, x_plus, 1.0f - p.within.x),
                walk(p, sides, y_minus, p.within.y), walk(p, sides, y_plus, 1.0f - p.within.y)};
    }

private:
    MapPlace neighbour(MapPlace place, Side side) const {
        if (rules_.float_steps == 0) {
            place.texel += direction(side);
            return place;
        }
        const float size = static_cast<float>(rules_.float_steps);
        place.uv += vec2(direction(side)) * (1.0f / size);
        place.texel = ivec2(glm::floor(place.uv * size));
        return place;
    }

    // The traversal in one direction; `to_edge` is the distance to the edge of the point's own texel. On the lit side a
    // texel less than ε before or behind moves the depth ε to the front, so that the surface's own slope ends no run.
    // [3.1.3, 3.2.3; listing A.3]
    float walk(const SilhouettePoint& p, unsigned sides, Side side, float to_edge) const {
        MapPlace at = p.place;
        float depth = p.depth;
        int steps = 0;
        bool closed = false;
        for (; steps < rules_.max_size; ++steps) {
            at = neighbour(at, side);
            float behind = source_.behind(at.texel, depth);
            if (p.lit && std::abs(behind) < p.slope_eps) depth -= p.slope_eps, behind = 0.0f;
            if ((behind <= 0.0f) != p.lit) {
                closed = !rules_.reject_isolated_end || discontinuities(at, depth, !p.lit) != all_sides;
                break;
            }
            if (!goes_on(at, p, sides, side, depth)) break;
        }
        const float distance = static_cast<float>(steps) + to_edge;
        return closed ? distance : -distance;
    }

    // Whether the run that `p` lies on goes on at a texel of its own state. On the umbra side it is here that a depth
    // less than ε from a texel's moves to the front; it stays there for the steps that follow.
    bool goes_on(const MapPlace& at, const SilhouettePoint& p, unsigned sides, Side side, float& depth) const {
        if (rules_.continuation != Continuation::Perp) {
            const unsigned here = discontinuities(at, depth, p.lit);
            return (rules_.continuation == Continuation::Any ? here : here & sides) != 0;
        }
        const bool along_x = side == x_minus || side == x_plus;
        for (const Side across : {along_x ? y_plus : x_minus, along_x ? y_minus : x_plus}) {
            if (!(sides & across)) continue;
            float behind = source_.behind(neighbour(at, across).texel, depth);
            if (!p.lit && std::abs(behind) < p.slope_eps) depth -= p.slope_eps, behind = 0.0f;
            if ((behind <= 0.0f) != p.lit) return true;
        }
        return false;
    }

    const Source& source_;
    const SilhouetteRules& rules_;
};

// The shape of the silhouette along one axis: −2 closed on both sides, 0 on neither, 1 on one. Literally, so that a
// distance of exactly 0 counts as neither sign. (3.4)
inline float run_shape(float a, float b) { return a > 0 && b > 0 ? -2.0f : a < 0 && b < 0 ? 0.0f : 1.0f; }

// The length that distances are divided by never exceeds what is walked. [listing A.4]
inline float run_length(float a, float b, int max_size) {
    return std::min(std::abs(a) + std::abs(b), static_cast<float>(max_size));
}

// Where on the step the point lies, per axis: 0 at its corner; for hard shadows in [−1, 1]. (3.5)
inline vec2 relative_position(const RunDistances& d, bool lit, int max_size) {
    const auto along = [&](float a, float b) {
        const float shape = run_shape(a, b);
        return std::max(shape, lit ? 1.0f : -1.0f) * std::abs(std::max(shape * a, shape * b)) /
               run_length(a, b, max_size);
    };
    return {along(d.x_minus, d.x_plus), along(d.y_minus, d.y_plus)};
}

// The same for filtered shadows, in [−2, 1]: negative exactly where both ends are closed. (4.1) as its text has it: as
// printed, without the absolute value, it would never be negative.
inline vec2 signed_relative_position(const RunDistances& d, int max_size) {
    const auto along = [&](float a, float b) {
        const float shape = run_shape(a, b);
        return shape * std::abs(std::max(shape * a, shape * b)) / run_length(a, b, max_size);
    };
    return {along(d.x_minus, d.x_plus), along(d.y_minus, d.y_plus)};
}

} // namespace gnomon
