#pragma once
// The rasterizer as a specification: every pixel centre against every triangle, one after the other, in the plainest
// arithmetic. The fast path must equal it bit for bit. Triangles come in window coordinates of 1/256 pixel, so that
// nothing is clipped or rounded.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/image.h"
#include "raster/draw.h"

namespace gnomon_tests {

struct FixedVertex {
    std::int64_t x, y; // 1/256 pixels
    float z;           // window depth
};

struct FixedTriangle {
    FixedVertex v[3];
};

// Covers: exact edge functions, points on left and bottom edges belong to the triangle.
inline bool covers(const FixedTriangle& t, int px, int py) {
    const FixedVertex* v[3] = {&t.v[0], &t.v[1], &t.v[2]};
    const auto area = (v[1]->x - v[0]->x) * (v[2]->y - v[0]->y) - (v[2]->x - v[0]->x) * (v[1]->y - v[0]->y);
    if (area == 0) return false;
    if (area < 0) std::swap(v[1], v[2]);
    const std::int64_t x = 256 * px + 128, y = 256 * py + 128;
    for (int e = 0; e < 3; ++e) {
        const FixedVertex &a = *v[e], &b = *v[(e + 1) % 3];
        const auto side = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
        const bool downwards = b.y < a.y, rightwards = b.y == a.y && b.x > a.x;
        if (side < 0 || (side == 0 && !downwards && !rightwards)) return false;
    }
    return true;
}

inline bool front(const FixedTriangle& t) {
    return (t.v[1].x - t.v[0].x) * (t.v[2].y - t.v[0].y) > (t.v[2].x - t.v[0].x) * (t.v[1].y - t.v[0].y);
}

// Depth at a pixel centre: the plane through the vertices, anchored at the smallest by (x, y), clamped to the vertices'
// range.
inline double depth(const FixedTriangle& t, int px, int py) {
    const FixedVertex* v[3] = {&t.v[0], &t.v[1], &t.v[2]};
    const auto before = [](const FixedVertex* a, const FixedVertex* b) {
        return a->x != b->x ? a->x < b->x : a->y < b->y;
    };
    std::sort(v, v + 3, before);
    const auto pixels = [](std::int64_t fixed) { return static_cast<double>(fixed) / 256.0; };
    const double e1x = pixels(v[1]->x - v[0]->x), e1y = pixels(v[1]->y - v[0]->y);
    const double e2x = pixels(v[2]->x - v[0]->x), e2y = pixels(v[2]->y - v[0]->y);
    const double area = e1x * e2y - e2x * e1y;
    const double z0 = v[0]->z, d1 = v[1]->z - z0, d2 = v[2]->z - z0;
    const double dx = (d1 * e2y - d2 * e1y) / area, dy = (d2 * e1x - d1 * e2x) / area;
    const double z = (z0 + dy * (py + 0.5 - pixels(v[0]->y))) + dx * (px + 0.5 - pixels(v[0]->x));
    const double least = std::min({t.v[0].z, t.v[1].z, t.v[2].z}), most = std::max({t.v[0].z, t.v[1].z, t.v[2].z});
    return std::min(std::max(z, least), most);
}

// The clip-space vertex (w = 1) that lands exactly on a fixed vertex in a target of this size, a power of two.
inline gnomon::vec4 to_clip(const FixedVertex& v, int width, int height) {
    const auto ndc = [](std::int64_t fixed, int size) {
        return static_cast<float>(static_cast<double>(fixed) / 128.0 / size - 1.0);
    };
    return {ndc(v.x, width), ndc(v.y, height), v.z * 2.0f - 1.0f, 1.0f};
}

} // namespace gnomon_tests
