#include "raster/clip.h"

#include <algorithm>
#include <cmath>

#include "raster/setup.h"

namespace gnomon {
namespace {

bool precedes(const vec4& a, const vec4& b) {
    if (a.x != b.x) return a.x < b.x;
    if (a.y != b.y) return a.y < b.y;
    if (a.z != b.z) return a.z < b.z;
    return a.w < b.w;
}

// Half-spaces dot(normal, position) ≥ 0.
struct ClipPlanes {
    std::array<dvec4, 6> normals;
    size_t count = 0;
};

ClipPlanes clip_planes(const SetupState& state) {
    ClipPlanes planes;
    const auto add = [&](dvec4 normal) { planes.normals[planes.count++] = normal; };
    if (!state.depth_clamp) {
        add(state.clip_depth == ClipDepth::ZeroToOne ? dvec4(0, 0, 1, 0) : dvec4(0, 0, 1, 1));
        add(dvec4(0, 0, -1, 1));
    }
    const double gx = 2.0 * guard_band_pixels / state.viewport.width;
    const double gy = 2.0 * guard_band_pixels / state.viewport.height;
    add(dvec4(1, 0, 0, gx)), add(dvec4(-1, 0, 0, gx));
    add(dvec4(0, 1, 0, gy)), add(dvec4(0, -1, 0, gy));
    return planes;
}

// The point where the edge meets the plane, cut from the smaller end point whichever way the edge runs.
ClipVertex cut(const ClipVertex& a, double distance_a, const ClipVertex& b, double distance_b) {
    if (precedes(b.position, a.position)) return cut(b, distance_b, a, distance_a);
    const double t = distance_a / (distance_a - distance_b);
    const dvec4 pa(a.position), pb(b.position);
    return {vec4(pa + (pb - pa) * t), a.barycentric + (b.barycentric - a.barycentric) * t};
}

void clip_by(ClippedPolygon& polygon, const dvec4& normal) {
    std::array<double, 9> distance;
    bool whole = true;
    const auto count = static_cast<size_t>(polygon.count);
    for (size_t i = 0; i < count; ++i) {
        distance[i] = glm::dot(normal, dvec4(polygon.corners[i].position));
        whole = whole && distance[i] >= 0;
    }
    if (whole) return;
    const std::array<ClipVertex, 9> corners = polygon.corners;
    polygon.count = 0;
    const auto keep = [&](const ClipVertex& v) { polygon.corners[static_cast<size_t>(polygon.count++)] = v; };
    for (size_t a = 0; a < count; ++a) {
        const size_t b = (a + 1) % count;
        if (distance[a] >= 0) keep(corners[a]);
        if ((distance[a] >= 0) != (distance[b] >= 0)) keep(cut(corners[a], distance[a], corners[b], distance[b]));
    }
}

} // namespace

ClippedPolygon clip(const SetupState& state, const std::array<vec4, 3>& triangle) {
    ClippedPolygon polygon;
    for (const vec4& p : triangle)
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z) || !std::isfinite(p.w)) return polygon;
    std::array<size_t, 3> order = {0, 1, 2};
    std::sort(order.begin(), order.end(), [&](size_t i, size_t j) { return precedes(triangle[i], triangle[j]); });
    polygon.order = order;
    polygon.mirrored = (order[1] - order[0] + 3) % 3 != 1;
    polygon.count = 3;
    for (size_t i = 0; i < 3; ++i) {
        polygon.corners[i] = {triangle[order[i]], dvec3(0.0)};
        polygon.corners[i].barycentric[static_cast<glm::length_t>(order[i])] = 1.0;
    }
    const ClipPlanes planes = clip_planes(state);
    for (size_t p = 0; p < planes.count && polygon.count >= 3; ++p) clip_by(polygon, planes.normals[p]);
    if (polygon.count < 3) polygon.count = 0;
    return polygon;
}

} // namespace gnomon
