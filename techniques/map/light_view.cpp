#include "techniques/map/light_view.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "core/parallel.h"

namespace gnomon {
namespace {

constexpr double widest_single_view = 60.0 * pi / 180.0; // half angle
constexpr double widest_cone = 80.0 * pi / 180.0;        // a spot's; beyond, the map would waste itself on the rim
constexpr double least_near = 1e-5;                      // of the far plane

// View x, view y and face axis of each face: +X −X +Y −Y +Z −Z.
struct Face {
    dvec3 right, up, forward;
};
constexpr std::array<Face, 6> cube_faces = {{
    {{0, 0, -1}, {0, -1, 0}, {1, 0, 0}},
    {{0, 0, 1}, {0, -1, 0}, {-1, 0, 0}},
    {{1, 0, 0}, {0, 0, 1}, {0, 1, 0}},
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
    {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}},
    {{-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
}};

dvec3 closest_point(dvec3 a, dvec3 b, dvec3 c) {
    // The point of triangle abc nearest to the origin, by Voronoi region [Ericson 2005, 5.1.5].
    const dvec3 ab = b - a, ac = c - a;
    const double d1 = -glm::dot(ab, a), d2 = -glm::dot(ac, a);
    if (d1 <= 0 && d2 <= 0) return a;
    const double d3 = -glm::dot(ab, b), d4 = -glm::dot(ac, b);
    if (d3 >= 0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
    const double d5 = -glm::dot(ab, c), d6 = -glm::dot(ac, c);
    if (d6 >= 0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    const double sum = va + vb + vc;
    return sum != 0 ? a + ab * (vb / sum) + ac * (vc / sum) : a;
}

// Range of a function of the casters' triangles, over chunks combined in order (minimum and maximum do not depend on
// it).
template <class Measure> std::pair<double, double> caster_range(const Frame& frame, const Measure& measure) {
    const std::span<const uvec3> casters = frame.casters();
    constexpr size_t grain = 16384;
    std::vector<std::pair<double, double>> ranges(chunk_count(casters.size(), grain), {infinity, -infinity});
    parallel_for(casters.size(), grain, [&](size_t begin, size_t end) {
        auto& [least, most] = ranges[begin / grain];
        for (size_t i = begin; i < end; ++i) measure(casters[i], least, most);
    });
    std::pair<double, double> range = {infinity, -infinity};
    for (const auto& [least, most] : ranges) range = {std::min(range.first, least), std::max(range.second, most)};
    return range;
}

// Least and largest value of f(position) over the corners of all casters: the range of a linear f over all their
// points.
template <class Function> std::pair<double, double> corner_range(const Frame& frame, const Function& f) {
    const std::vector<vec3>& positions = frame.scene().positions;
    return caster_range(frame, [&](const uvec3& t, double& least, double& most) {
        for (int c = 0; c < 3; ++c) {
            const double value = f(dvec3(positions[t[c]]));
            least = std::min(least, value), most = std::max(most, value);
        }
    });
}

void finish(LightView& view) {
    const dmat4 projection =
        view.orthographic ? orthographic_matrix(view.half_extent, view.half_extent, view.near_plane, view.far_plane)
                          : perspective_matrix(2.0 * std::atan(view.half_extent), 1.0, view.near_plane, view.far_plane);
    view.to_clip = mat4(projection * frame_matrix(view.origin, view.right, view.up, view.forward));
}

// Near and far from the range of distances along the view, slightly wider so that rounding cuts nothing.
void set_planes(LightView& view, double least, double most, float near_plane) {
    const double margin = 1e-3 * std::max(most - least, 1e-6 * std::abs(most));
    if (view.orthographic) {
        view.near_plane = least - margin;
        view.far_plane = most + margin;
        return;
    }
    view.far_plane = most + margin;
    view.near_plane = std::max(least * 0.999, view.far_plane * least_near);
    if (near_plane > 0) view.near_plane = std::min(static_cast<double>(near_plane), 0.999 * view.far_plane);
}

LightView oriented(const Light& light, dvec3 forward) {
    LightView view{};
    view.origin = dvec3(light.position);
    view.forward = glm::normalize(forward);
    // The map's x axis follows the light's own, so that a rectangle's kernel lies along its sides.
    const dvec3 tangent(light.tangent);
    dvec3 right = tangent - view.forward * glm::dot(tangent, view.forward);
    if (glm::dot(right, right) < 1e-6) right = dvec3(any_tangent(vec3(view.forward)));
    view.right = glm::normalize(right - view.forward * glm::dot(right, view.forward));
    view.up = glm::cross(view.right, view.forward);
    return view;
}

LightView directional_view(const Frame& frame, const Light& light, float near_plane) {
    LightView view = oriented(light, dvec3(light.direction));
    view.orthographic = true;
    const auto [x0, x1] = corner_range(frame, [&](dvec3 p) { return glm::dot(p, view.right); });
    const auto [y0, y1] = corner_range(frame, [&](dvec3 p) { return glm::dot(p, view.up); });
    const auto [z0, z1] = corner_range(frame, [&](dvec3 p) { return glm::dot(p, view.forward); });
    view.origin = view.right * (0.5 * (x0 + x1)) + view.up * (0.5 * (y0 + y1)) + view.forward * z0;
    view.half_extent = 0.5 * std::max(x1 - x0, y1 - y0) * 1.001;
    set_planes(view, 0.0, z1 - z0, near_plane);
    finish(view);
    return view;
}

// A perspective view; half_extent is set. Casters behind it or beside it do not matter.
void finish_perspective(const Frame& frame, LightView& view, float near_plane) {
    const auto [unused, most] = corner_range(frame, [&](dvec3 p) { return glm::dot(p - view.origin, view.forward); });
    // A point at distance r inside a square view of half width h·z is at least r/√(1 + 2h²) along the axis.
    const auto [nearest2, unused2] = caster_range(frame, [&](const uvec3& t, double& least, double&) {
        const auto at = [&](int c) { return dvec3(frame.scene().positions[t[c]]) - view.origin; };
        const dvec3 p = closest_point(at(0), at(1), at(2));
        least = std::min(least, glm::dot(p, p));
    });
    const double nearest = std::sqrt(nearest2 / (1.0 + 2.0 * view.half_extent * view.half_extent));
    const double farthest = most > 0 ? most : 1.0;
    set_planes(view, std::min(nearest, 0.5 * farthest), farthest, near_plane);
    finish(view);
}

LightView spot_view(const Frame& frame, const Light& light, float near_plane) {
    LightView view = oriented(light, dvec3(light.direction));
    view.half_extent = std::tan(std::min(static_cast<double>(light.outer_cone), widest_cone)) * 1.001;
    finish_perspective(frame, view, near_plane);
    return view;
}

// Half the field of view that shows all casters around `forward`, as a tangent; infinite where some lie behind or too
// far aside.
double fitted_extent(const Frame& frame, const LightView& view) {
    const auto [least, most] = corner_range(frame, [&](dvec3 p) {
        const dvec3 d = p - view.origin;
        const double z = glm::dot(d, view.forward);
        const double across = std::max(std::abs(glm::dot(d, view.right)), std::abs(glm::dot(d, view.up)));
        return z > 0 && across <= z * std::tan(widest_single_view) ? across / z : infinity;
    });
    return most;
}

std::vector<LightView> point_views(const Frame& frame, const Light& light, const ViewOptions& options) {
    const auto [projection, near_plane, size, gutter] = options;
    if (projection != Projection::Cube) {
        LightView view = oriented(light, dvec3(frame.scene().bounds.center()) - dvec3(light.position));
        const double extent = fitted_extent(frame, view);
        if (extent < static_cast<double>(infinity)) {
            view.half_extent = extent * 1.001;
            finish_perspective(frame, view, near_plane);
            return {view};
        }
        if (projection == Projection::Single)
            throw UsageError(
                fmt::format("light '{}' has shadow casters beyond 60 degrees around its view of the scene; "
                            "use projection=cube",
                            light.name));
    }
    std::vector<LightView> views;
    for (const Face& face : cube_faces) {
        LightView view{};
        view.origin = dvec3(light.position);
        view.right = face.right, view.up = face.up, view.forward = face.forward;
        view.half_extent = static_cast<double>(size) / std::max(1, size - 2 * gutter);
        views.push_back(view);
    }
    // All faces share their planes, so that depths compare across edges.
    finish_perspective(frame, views[0], near_plane);
    const auto [unused, far_plane] = corner_range(frame, [&](dvec3 p) {
        const dvec3 d = glm::abs(p - views[0].origin);
        return std::max({d.x, d.y, d.z});
    });
    for (LightView& view : views) {
        view.far_plane = far_plane * 1.001;
        view.near_plane = std::min(views[0].near_plane, 0.5 * view.far_plane);
        if (near_plane <= 0) view.near_plane = std::max(view.near_plane, view.far_plane * least_near);
    }
    for (LightView& view : views) finish(view);
    return views;
}

} // namespace

std::vector<LightView> light_views(const Frame& frame, const Light& light, const ViewOptions& options) {
    if (light.type == LightType::Directional) {
        if (options.projection == Projection::Cube)
            throw UsageError(
                fmt::format("light '{}' is directional: it has no position for projection=cube", light.name));
        return {directional_view(frame, light, options.near_plane)};
    }
    if (light.type == LightType::Spot && options.projection != Projection::Cube && light.outer_cone <= widest_cone)
        return {spot_view(frame, light, options.near_plane)};
    return point_views(frame, light, options);
}

int cube_face(dvec3 d) {
    const dvec3 m = glm::abs(d);
    if (m.x >= m.y && m.x >= m.z) return d.x > 0 ? 0 : 1;
    if (m.y >= m.z) return d.y > 0 ? 2 : 3;
    return d.z > 0 ? 4 : 5;
}

int view_of(const std::vector<LightView>& views, vec3 p) {
    return views.size() == 1 ? 0 : cube_face(dvec3(p) - views[0].origin);
}

} // namespace gnomon
