#include "raster/geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace gnomon {
namespace {

// assemble(part, triangles) for each run of indices between restarts.
template <class Assemble>
std::vector<uvec3> for_each_run(std::span<const std::uint32_t> indices, const Assemble& assemble) {
    std::vector<uvec3> triangles;
    triangles.reserve(indices.size());
    for (size_t begin = 0; begin < indices.size();) {
        const auto rest = indices.subspan(begin);
        const auto length = static_cast<size_t>(std::find(rest.begin(), rest.end(), restart_index) - rest.begin());
        assemble(rest.first(length), triangles);
        begin += length + 1;
    }
    return triangles;
}

} // namespace

std::vector<uvec3> triangles_of_strip(std::span<const std::uint32_t> indices) {
    return for_each_run(indices, [](std::span<const std::uint32_t> v, std::vector<uvec3>& out) {
        for (size_t i = 0; i + 2 < v.size(); ++i) {
            const size_t odd = i % 2;
            out.push_back({v[i + odd], v[i + 1 - odd], v[i + 2]});
        }
    });
}

std::vector<uvec3> triangles_of_fan(std::span<const std::uint32_t> indices) {
    return for_each_run(indices, [](std::span<const std::uint32_t> v, std::vector<uvec3>& out) {
        for (size_t i = 0; i + 2 < v.size(); ++i) out.push_back({v[0], v[i + 1], v[i + 2]});
    });
}

std::vector<uvec3> triangles_of_quads(std::span<const std::uint32_t> indices) {
    return for_each_run(indices, [](std::span<const std::uint32_t> v, std::vector<uvec3>& out) {
        for (size_t i = 0; i + 3 < v.size(); i += 4) {
            out.push_back({v[i], v[i + 1], v[i + 3]});
            out.push_back({v[i + 1], v[i + 2], v[i + 3]});
        }
    });
}

std::vector<uvec3> triangles_of_quad_strip(std::span<const std::uint32_t> indices) {
    return for_each_run(indices, [](std::span<const std::uint32_t> v, std::vector<uvec3>& out) {
        for (size_t i = 0; i + 3 < v.size(); i += 2) {
            out.push_back({v[i + 2], v[i], v[i + 3]});
            out.push_back({v[i], v[i + 1], v[i + 3]});
        }
    });
}

std::vector<std::uint32_t> sequence(std::uint32_t count) {
    std::vector<std::uint32_t> indices(count);
    std::iota(indices.begin(), indices.end(), 0u);
    return indices;
}

std::optional<WideLine> wide_line(const vec4& a, const vec4& b, float width_pixels, glm::ivec2 viewport_size) {
    // Cut at the near plane, in double.
    const dvec4 ends[2] = {dvec4(a), dvec4(b)};
    const double near_a = ends[0].z + ends[0].w, near_b = ends[1].z + ends[1].w;
    if (!(near_a >= 0.0) && !(near_b >= 0.0)) return std::nullopt;
    double t[2] = {0.0, 1.0};
    if (near_a < 0.0) t[0] = near_a / (near_a - near_b);
    if (near_b < 0.0) t[1] = near_a / (near_a - near_b);
    dvec4 p[2];
    for (int i = 0; i < 2; ++i) {
        p[i] = t[i] == i ? ends[i] : ends[0] + (ends[1] - ends[0]) * t[i];
        if (!(p[i].w > 0.0)) return std::nullopt;
    }

    const dvec2 size(viewport_size);
    const dvec2 step = (dvec2(p[1]) / p[1].w - dvec2(p[0]) / p[0].w) * size * 0.5; // pixels
    const bool x_major = std::abs(step.x) >= std::abs(step.y);
    const double width = std::max(1.0, std::floor(static_cast<double>(width_pixels) + 0.5));
    // Half the width in normalised device coordinates, to the left of the direction a → b.
    const dvec2 left = x_major ? dvec2(0.0, step.x >= 0.0 ? 1.0 : -1.0) : dvec2(step.y >= 0.0 ? -1.0 : 1.0, 0.0);
    const dvec2 offset = left * width / size;
    WideLine line;
    for (size_t i = 0; i < 4; ++i) {
        const size_t end = i == 1 || i == 2;
        const dvec4& q = p[end];
        const double side = i < 2 ? -1.0 : 1.0;
        line.corners[i] = vec4(dvec4(dvec2(q) + offset * (side * q.w), q.z, q.w));
        line.along[i] = static_cast<float>(t[end]);
    }
    return line;
}

void detail::check_stream_size(size_t vertices) {
    if (vertices > std::numeric_limits<std::uint32_t>::max())
        throw UsageError(fmt::format("a geometry program emits {} vertices in all; 32-bit indices name at most {}",
                                     vertices, std::numeric_limits<std::uint32_t>::max()));
}

} // namespace gnomon
