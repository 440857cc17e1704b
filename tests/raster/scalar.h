#pragma once
// The rasterizer as a specification: every pixel centre against every triangle, one after the other, in the plainest
// arithmetic. The fast path must equal it bit for bit. Triangles come in window coordinates of 1/256 pixel, so that
// nothing is clipped or rounded.

#include <algorithm>
#include <cmath>
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

// The plane of any value through the vertices, anchored at the smallest by (x, y): value there and gradients per pixel.
struct ScalarPlane {
    double x0, y0, value, dx, dy;
    double at(int px, int py) const { return (value + dy * (py + 0.5 - y0)) + dx * (px + 0.5 - x0); }
};

inline ScalarPlane plane(const FixedTriangle& t, const double (&f)[3]) {
    int order[3] = {0, 1, 2};
    std::sort(order, order + 3,
              [&](int i, int j) { return t.v[i].x != t.v[j].x ? t.v[i].x < t.v[j].x : t.v[i].y < t.v[j].y; });
    const FixedVertex &a = t.v[order[0]], &b = t.v[order[1]], &c = t.v[order[2]];
    const auto pixels = [](std::int64_t fixed) { return static_cast<double>(fixed) / 256.0; };
    const double e1x = pixels(b.x - a.x), e1y = pixels(b.y - a.y), e2x = pixels(c.x - a.x), e2y = pixels(c.y - a.y);
    const double area = e1x * e2y - e2x * e1y;
    const double d1 = f[order[1]] - f[order[0]], d2 = f[order[2]] - f[order[0]];
    return {pixels(a.x), pixels(a.y), f[order[0]], (d1 * e2y - d2 * e1y) / area, (d2 * e1x - d1 * e2x) / area};
}

// Depth at a pixel centre: its plane, clamped to the vertices' range.
inline double depth(const FixedTriangle& t, int px, int py) {
    const double z = plane(t, {t.v[0].z, t.v[1].z, t.v[2].z}).at(px, py);
    const double least = std::min({t.v[0].z, t.v[1].z, t.v[2].z}), most = std::max({t.v[0].z, t.v[1].z, t.v[2].z});
    return std::min(std::max(z, least), most);
}

// Polygon offset in window depth. [OpenGL 4.6, 14.6.5]
inline double offset(const FixedTriangle& t, const gnomon::PolygonOffset& o, gnomon::Format format) {
    const ScalarPlane z = plane(t, {t.v[0].z, t.v[1].z, t.v[2].z});
    const double slope = std::max(std::abs(z.dx), std::abs(z.dy));
    const double most = std::max({t.v[0].z, t.v[1].z, t.v[2].z});
    double value =
        static_cast<double>(o.factor) * slope + static_cast<double>(o.units) * depth_resolution(format, most);
    if (o.clamp > 0) value = std::min(value, static_cast<double>(o.clamp));
    if (o.clamp < 0) value = std::max(value, static_cast<double>(o.clamp));
    return value;
}

// The clip-space vertex (w = 1) that lands exactly on a fixed vertex in a target of this size, a power of two.
inline gnomon::vec4 to_clip(const FixedVertex& v, int width, int height) {
    const auto ndc = [](std::int64_t fixed, int size) {
        return static_cast<float>(static_cast<double>(fixed) / 128.0 / size - 1.0);
    };
    return {ndc(v.x, width), ndc(v.y, height), v.z * 2.0f - 1.0f, 1.0f};
}

} // namespace gnomon_tests
