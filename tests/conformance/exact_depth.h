#pragma once
// Depth as exact arithmetic has it: the plane through the snapped vertices, in extended precision.

#include <array>
#include <cmath>

#include "tests/conformance/duel.h"

namespace gnomon_conformance {

struct SnappedTriangle {
    std::array<double, 3> x, y; // pixels, multiples of 1/256
    std::array<double, 3> z;    // window depth, a float
};

struct SnappedVertex {
    double x, y, z;
};

// Clip space to window as the contract has it: float32, each operation rounded.
inline SnappedVertex snap(const vec4& p, const Rectangle& viewport) {
    const float half_width = 0.5f * static_cast<float>(viewport.width);
    const float half_height = 0.5f * static_cast<float>(viewport.height);
    const float oow = 1.0f / p.w;
    const float x = p.x * oow * half_width + (static_cast<float>(viewport.x) + half_width);
    const float y = p.y * oow * half_height + (static_cast<float>(viewport.y) + half_height);
    const auto fixed = [](float pixels) { return std::nearbyint(static_cast<double>(pixels) * 256.0) / 256.0; };
    return {fixed(x), fixed(y), static_cast<double>(p.z * oow * 0.5f + 0.5f)};
}

inline SnappedTriangle snap(const std::array<vec4, 3>& corners, const Rectangle& viewport) {
    SnappedTriangle t{};
    for (size_t i = 0; i < 3; ++i) {
        const SnappedVertex v = snap(corners[i], viewport);
        t.x[i] = v.x, t.y[i] = v.y, t.z[i] = v.z;
    }
    return t;
}

inline SnappedTriangle snap(const Batch& batch, std::uint32_t triangle, const Rectangle& viewport) {
    const uvec3 t = batch.triangles[triangle];
    return snap({batch.positions[t.x], batch.positions[t.y], batch.positions[t.z]}, viewport);
}

struct ExactPlane {
    long double value, dx, dy; // at the first vertex, and per pixel
    long double x0, y0;

    explicit ExactPlane(const SnappedTriangle& t) : value(t.z[0]), x0(t.x[0]), y0(t.y[0]) {
        const long double x1 = t.x[1] - x0, y1 = t.y[1] - y0, x2 = t.x[2] - x0, y2 = t.y[2] - y0;
        const long double d1 = t.z[1] - value, d2 = t.z[2] - value, area = x1 * y2 - x2 * y1;
        dx = (d1 * y2 - d2 * y1) / area;
        dy = (d2 * x1 - d1 * x2) / area;
    }
    double at(int x, int y) const { // pixel centre
        return static_cast<double>(value + dx * (x + 0.5L - x0) + dy * (y + 0.5L - y0));
    }
    double slope() const { return static_cast<double>(std::max(std::abs(dx), std::abs(dy))); }
};

} // namespace gnomon_conformance
