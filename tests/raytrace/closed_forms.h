#pragma once
// What a light, an occluder parallel to the floor and a receiver give in closed form: the visible fraction of the light
// and the integral of any integrand over its visible part. Every set is convex and bounded by straight lines or a
// circle, so a chord of the light meets the occluder's projection in one interval whose ends are exact; only the chords
// are summed.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "core/light.h"

namespace gnomon_tests {

using namespace gnomon;

// A light as a plane figure: center + s·a + t·b with |s|, |t| ≤ 1, or s² + t² ≤ 1.
struct FlatLight {
    dvec3 center, a, b;
    bool disk = false;
    dvec3 facing;
    double area() const { return glm::length(glm::cross(a, b)) * (disk ? pi : 4.0); }
};

// A sphere is the disk through its limb, which is what light_point says it is.
inline FlatLight flat(const Light& light, dvec3 receiver) {
    if (light.type != LightType::Sphere)
        return {dvec3(light.position), dvec3(light.tangent) * (0.5 * double(light.size.x)),
                dvec3(bitangent(light)) * (0.5 * double(light.size.y)), light.type == LightType::Disk,
                dvec3(light.direction)};
    const dvec3 away = receiver - dvec3(light.position);
    const double r = 0.5 * double(light.size.x), d = glm::length(away);
    const dvec3 axis = away / d, u(any_tangent(vec3(axis))), v = glm::cross(axis, u);
    const double limb = r * std::sqrt(1 - r * r / (d * d));
    return {dvec3(light.position) + axis * (r * r / d), u * limb, v * limb, true, axis};
}

// Hides where all edges say so: normal · (x, z) ≥ offset at height y, and within the circle where there is one.
struct FlatOccluder {
    struct Edge {
        dvec2 normal;
        double offset;
    };
    double y = 0;
    std::vector<Edge> edges;
    double radius = 0; // around the origin of (x, z); 0: no circle
};

struct Interval {
    double low, high;
    void cut(double from, double to) { low = std::max(low, from), high = std::min(high, to); }
};

// Hidden part, in s, of the chord of constant t.
inline Interval hidden(const FlatLight& light, const FlatOccluder& occluder, dvec3 p, double t, double half) {
    // At height y the way to q(s) is at p + (q − p)·h/w with w = q.y − p.y; everything is multiplied by w > 0.
    const dvec3 start = light.center + light.b * t - p;
    const double h = occluder.y - p.y;
    Interval interval{-half, half};
    for (const FlatOccluder::Edge& edge : occluder.edges) {
        const auto along = [&](dvec3 v) { return edge.normal.x * v.x + edge.normal.y * v.z; };
        const double at_p = along(p) - edge.offset;
        const double constant = at_p * start.y + h * along(start), slope = at_p * light.a.y + h * along(light.a);
        if (std::abs(slope) < 1e-15 * std::abs(constant) || slope == 0) {
            if (constant < 0) return {half, half};
        } else if (slope > 0) {
            interval.cut(-constant / slope, half);
        } else {
            interval.cut(-half, -constant / slope);
        }
    }
    if (occluder.radius > 0) {
        const dvec2 c(p.x * start.y + h * start.x, p.z * start.y + h * start.z);
        const dvec2 m(p.x * light.a.y + h * light.a.x, p.z * light.a.y + h * light.a.z);
        const double r2 = occluder.radius * occluder.radius;
        const double A = glm::dot(m, m) - r2 * light.a.y * light.a.y, B = glm::dot(m, c) - r2 * light.a.y * start.y,
                     C = glm::dot(c, c) - r2 * start.y * start.y;
        const double D = B * B - A * C;
        if (D <= 0) return {half, half};
        interval.cut((-B - std::sqrt(D)) / A, (-B + std::sqrt(D)) / A);
    }
    if (interval.low >= interval.high) return {half, half};
    return interval;
}

// ∫ over the visible part of f(point of the light) dA; 1 / area of it with f = 1 is the visible fraction.
inline dvec3 visible_integral(const FlatLight& light, const FlatOccluder* occluder, dvec3 p,
                              const std::function<dvec3(dvec3)>& f) {
    constexpr int rows = 3000;
    constexpr std::array<double, 4> node = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                            0.9602898564975363}; // Gauss and Legendre's, of eight points
    constexpr std::array<double, 4> weight = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                              0.1012285362903763};
    dvec3 sum(0);
    for (int row = 0; row < rows; ++row) {
        const double t = 2 * (row + 0.5) / rows - 1, half = light.disk ? std::sqrt(1 - t * t) : 1.0;
        const Interval gone = occluder ? hidden(light, *occluder, p, t, half) : Interval{half, half};
        for (const Interval part : {Interval{-half, gone.low}, Interval{gone.high, half}}) {
            const double middle = 0.5 * (part.low + part.high), reach = 0.5 * (part.high - part.low);
            if (reach <= 0) continue;
            for (size_t i = 0; i < node.size(); ++i)
                for (const double s : {middle - reach * node[i], middle + reach * node[i]})
                    sum += f(light.center + light.a * s + light.b * t) * (weight[i] * reach);
        }
    }
    return sum * (glm::length(glm::cross(light.a, light.b)) * 2 / rows);
}

inline double visible_fraction(const FlatLight& light, const FlatOccluder* occluder, dvec3 p) {
    return visible_integral(light, occluder, p, [](dvec3) { return dvec3(1); }).x / light.area();
}

} // namespace gnomon_tests
