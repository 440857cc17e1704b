#pragma once
// Tessellation: triangle and quad patches split by factors per edge, as OpenGL's tessellator does: concentric rings
// inside, and an outer ring that meets each edge at that edge's own factor. [OpenGL 4.6, 11.2.2] What OpenGL leaves
// open is fixed here:
//
//  * Weights, not (u, v): every point has the weights of its patch's corners (the barycentric coordinates of a
//  triangle;
//    (1−u)(1−v), u(1−v), uv, (1−u)v of a quad). Point k of an edge has the weight t(n − k) for the edge's one end and
//    t(k) for the other, both by the same formula, and 0 for all else. So the points of an edge depend on its factor
//    alone, are the same bits seen from either end, and two patches that share an edge, its factor and its end points
//    evaluate to the same bits by patch_value(): no cracks, no T-junctions. [Navrátil 2015, 2.9]
//  * Subdivision: n = ⌈f⌉, rounded up to odd or even where the spacing is fractional, f clamped to 64 (63 for odd);
//    t(k) = (f − n + 2k)/(2f): n − 2 pieces of length 1/f between two shorter ones at the ends; equal pieces for f = n.
//  * An inner factor that rounds to 1 beside an outer one that does not is taken as 1 + 2⁻¹⁰.
//  * A ring is filled side by side, always stepping along the side whose next piece has its middle nearer, the outer
//  one
//    on a tie; cells of a quad's inside are split as triangles_of_quads does. All triangles wind as their patch does.
//
// The evaluation program is the vertex program of the draw that follows.

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "core/math.h"
#include "raster/geometry.h"

namespace gnomon {

enum class PatchShape : std::uint8_t { Triangle, Quad };
enum class Spacing : std::uint8_t { Equal, FractionalOdd, FractionalEven };

// Corners A, B, C: outer factors of the edges BC, CA, AB (u = 0, v = 0, w = 0), inner[0]. Corners (0,0), (1,0), (1,1),
// (0,1): outer factors of the edges u = 0, v = 0, u = 1, v = 1, inner factors along u and v. A patch with an outer
// factor that is not above 0 is culled.
struct PatchLevels {
    std::array<float, 4> outer = {1, 1, 1, 1};
    std::array<float, 2> inner = {1, 1};

    static PatchLevels uniform(float factor) { return {{factor, factor, factor, factor}, {factor, factor}}; }
    // Inner factors from the edges': their maximum. [Navrátil 2015, 2.9]
    static PatchLevels from_edges(PatchShape shape, std::array<float, 4> outer);
};

// clamp(⌈|a − b|/piece⌉, 1, most): the same for (a, b) and (b, a). [Navrátil 2015, 2.9]
float edge_level(vec2 a, vec2 b, float piece, int most);

// One patch's points, as the weights of its corners (the fourth is 0 for a triangle), and its triangles.
struct PatchPattern {
    std::vector<dvec4> weights;
    std::vector<uvec3> triangles;
};
PatchPattern tessellate_patch(PatchShape shape, Spacing spacing, const PatchLevels& levels);

// A vertex of a tessellated mesh.
struct PatchPoint {
    std::uint32_t patch;
    vec4 weights;
};

// What an attribute of the corners is at a point, in one documented order of operations. Corners must be finite.
template <class T> T patch_value(const vec4& w, const T& a, const T& b, const T& c) {
    return (a * w.x + b * w.y) + c * w.z;
}
template <class T> T patch_value(const vec4& w, const T& a, const T& b, const T& c, const T& d) {
    return ((a * w.x + b * w.y) + c * w.z) + d * w.w;
}

namespace detail {
using PatternKey = std::array<float, 6>;
PatternKey pattern_key(Spacing spacing, const PatchLevels& levels); // equal keys: equal patterns
} // namespace detail

// The tessellation stage: levels(patch) -> PatchLevels for each patch, points and triangles in the order of the
// patches. Counts as amplify() does.
template <class Levels>
Stream<PatchPoint> tessellate(Pass& pass, std::uint32_t patches, PatchShape shape, Spacing spacing,
                              const Levels& levels) {
    return detail::amplify_chunks<PatchPoint>(
        pass, patches, size_t{1} << 20, [&](std::uint32_t begin, std::uint32_t end, Emitter<PatchPoint>& emitter) {
            std::map<detail::PatternKey, PatchPattern> patterns; // neighbours in a mesh share theirs
            for (std::uint32_t patch = begin; patch < end; ++patch) {
                const PatchLevels wanted = levels(patch);
                const auto [at, fresh] = patterns.try_emplace(detail::pattern_key(spacing, wanted));
                if (fresh) at->second = tessellate_patch(shape, spacing, wanted);
                emitter.begin_primitive();
                for (const dvec4& w : at->second.weights) emitter.vertex({patch, vec4(w)});
                for (const uvec3& t : at->second.triangles) emitter.triangle(t.x, t.y, t.z);
            }
        });
}

} // namespace gnomon
