#include "tests/conformance/explain.h"

#include <array>
#include <cmath>

#include "tests/raster/scalar.h"

namespace gnomon_conformance {
namespace {

constexpr double half_ulp = 0x1p-24; // of a float, relative

struct Coordinate {
    double value, error; // pixels
};

// x/w·half + middle, and what four roundings and the error of x and w may do to it.
Coordinate window(double x, double w, double clip_error, double half, double middle) {
    const double ndc = x / w, offset = ndc * half;
    const double error = std::abs(offset) * 3 * half_ulp + std::abs(offset + middle) * half_ulp +
                         half * clip_error * (1 + std::abs(ndc)) / std::abs(w);
    return {offset + middle, error};
}

bool coverage_varies(const std::array<Coordinate, 6>& c, ivec2 pixel) {
    std::array<std::array<std::int64_t, 2>, 6> steps;
    for (size_t i = 0; i < 6; ++i)
        steps[i] = {std::llrint((c[i].value - c[i].error) * 256.0), std::llrint((c[i].value + c[i].error) * 256.0)};
    bool inside = false, outside = false;
    for (unsigned choice = 0; choice < 64; ++choice) {
        const auto at = [&](size_t i) { return steps[i][choice >> i & 1]; };
        const gnomon_tests::FixedTriangle t = {{{at(0), at(1), 0}, {at(2), at(3), 0}, {at(4), at(5), 0}}};
        (gnomon_tests::covers(t, pixel.x, pixel.y) ? inside : outside) = true;
    }
    return inside && outside;
}

} // namespace

std::vector<ExactVertex> exact_vertices(std::span<const vec4> clip) {
    std::vector<ExactVertex> vertices;
    for (const vec4& v : clip) vertices.push_back({dvec4(v)});
    return vertices;
}

std::vector<ExactVertex> exact_vertices(std::span<const vec3> positions, const mat4& to_clip) {
    std::vector<ExactVertex> vertices;
    const dmat4 exact(to_clip);
    for (const vec3& p : positions) {
        double largest = 0; // of the sums of magnitudes: three roundings in each, products included
        for (int i = 0; i < 4; ++i) {
            const double sum = std::abs(exact[0][i] * p.x) + std::abs(exact[1][i] * p.y) + std::abs(exact[2][i] * p.z) +
                               std::abs(exact[3][i]);
            largest = std::max(largest, i == 2 ? 0.0 : sum);
        }
        vertices.push_back({exact * dvec4(p, 1.0), 3 * half_ulp * largest});
    }
    return vertices;
}

bool hangs_on_rounding(std::span<const ExactVertex> vertices, std::span<const uvec3> triangles,
                       const Rectangle& viewport, ivec2 pixel) {
    const double half_x = 0.5 * viewport.width, half_y = 0.5 * viewport.height;
    for (const uvec3& t : triangles) {
        std::array<Coordinate, 6> c;
        dvec2 least(infinity), most(-infinity);
        bool behind = false;
        for (glm::length_t i = 0; i < 3; ++i) {
            const ExactVertex& v = vertices[t[i]];
            behind |= v.clip.w <= 0;
            const auto k = static_cast<size_t>(2 * i);
            c[k] = window(v.clip.x, v.clip.w, v.clip_error, half_x, viewport.x + half_x);
            c[k + 1] = window(v.clip.y, v.clip.w, v.clip_error, half_y, viewport.y + half_y);
            least = glm::min(least, dvec2(c[k].value, c[k + 1].value));
            most = glm::max(most, dvec2(c[k].value, c[k + 1].value));
        }
        const dvec2 center = dvec2(pixel) + 0.5;
        constexpr double reach = 0.02; // more than any rounding
        if (behind || glm::any(glm::lessThan(center, least - reach)) ||
            glm::any(glm::greaterThan(center, most + reach)))
            continue;
        if (coverage_varies(c, pixel)) return true;
    }
    return false;
}

std::optional<double> homogeneous_depth(const dvec4& a, const dvec4& b, const dvec4& c, const Rectangle& viewport,
                                        dvec2 point) {
    const dvec2 ndc = (point - dvec2(viewport.x, viewport.y)) / dvec2(viewport.width, viewport.height) * 2.0 - 1.0;
    const auto flat = [](const dvec4& v) { return dvec3(v.x, v.y, v.w); };
    const dvec3 p(ndc, 1.0), n0 = glm::cross(flat(b), flat(c)), n1 = glm::cross(flat(c), flat(a)),
                             n2 = glm::cross(flat(a), flat(b));
    const double volume = glm::dot(flat(a), n0);
    if (volume == 0) return std::nullopt;
    // The combination of the vertices that lands on the point, scaled to w = 1; inside where no weight is negative.
    const dvec3 weights = dvec3(glm::dot(n0, p), glm::dot(n1, p), glm::dot(n2, p)) / volume;
    if (weights.x < 0 || weights.y < 0 || weights.z < 0) return std::nullopt;
    return weights.x * a.z + weights.y * b.z + weights.z * c.z;
}

} // namespace gnomon_conformance
