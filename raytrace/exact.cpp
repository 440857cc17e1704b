#include "raytrace/exact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <polyclipping/clipper.hpp>

#include "core/error.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "raytrace/pyramid.h"
#include "raytrace/shaft.h"

namespace gnomon {
namespace {

using Path = ClipperLib::Path;

constexpr int disk_sides = 256;
constexpr double beyond_light = 1.001; // where triangles are cut off, in halves of the light's size
constexpr double grid = 0x1p29;        // units of Clipper's integers in half the light's size

// A flat light, or a triangle of a mesh light: an outline in the coordinates of a parallelogram center + s·a + t·b.
struct Piece {
    LightFrame frame;
    std::vector<dvec2> outline; // counter-clockwise, s and t in [−1, 1]
    double area;                // metres²
};

// Corners on a circle just so much larger that the polygon has the disk's area.
std::vector<dvec2> disk_outline() {
    constexpr double step = 2 * pi / disk_sides;
    const double radius = std::sqrt(step / std::sin(step));
    std::vector<dvec2> outline;
    for (int i = 0; i < disk_sides; ++i) outline.push_back(radius * dvec2(std::cos(step * i), std::sin(step * i)));
    return outline;
}

std::vector<Piece> pieces_of(const Light& light, vec3 receiver) {
    std::vector<Piece> pieces;
    if (light.type == LightType::Mesh) {
        for (const LightTriangle& t : light.triangles) {
            const dvec3 corner(t.a), a = 0.5 * (dvec3(t.b) - corner), b = 0.5 * (dvec3(t.c) - corner);
            pieces.push_back(
                {{corner + a + b, a, b, {}}, {{-1, -1}, {1, -1}, {-1, 1}}, 2 * glm::length(glm::cross(a, b))});
        }
        return pieces;
    }
    const LightFrame frame = light_frame(light, receiver);
    const bool round = light.type == LightType::Disk || light.type == LightType::Sphere;
    pieces.push_back({frame, round ? disk_outline() : std::vector<dvec2>{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}, 1.0});
    return pieces;
}

// Half spaces normal·p ≥ offset around what can be seen of a piece from the origin of the coordinates, in coordinates
// (s·w, t·w, w) with w = 1 in the light's plane.
struct Cut {
    dvec3 normal;
    double offset;
};

using Polygon = std::vector<dvec3>;

// Sutherland and Hodgman 1974. The cut of an edge is computed from its ends in one order, so that two polygons that
// share an edge share its cut.
void clip(Polygon& polygon, const Cut& cut, Polygon& scratch) {
    const auto side = [&](const dvec3& p) { return glm::dot(cut.normal, p) - cut.offset; };
    const auto before = [](const dvec3& a, const dvec3& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    };
    scratch.clear();
    for (size_t i = 0; i < polygon.size(); ++i) {
        const dvec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double at_a = side(a), at_b = side(b);
        if (at_a >= 0) scratch.push_back(a);
        if ((at_a >= 0) == (at_b >= 0)) continue;
        scratch.push_back(before(a, b) ? a + (b - a) * (at_a / (at_a - at_b)) : b + (a - b) * (at_b / (at_b - at_a)));
    }
    polygon.swap(scratch);
}

ClipperLib::IntPoint on_grid(dvec2 p) {
    const dvec2 q = glm::clamp(p, dvec2(-1.5), dvec2(1.5)) * grid;
    return {std::llround(q.x), std::llround(q.y)};
}

double area_of(const ClipperLib::Paths& paths) {
    double area = 0;
    for (const Path& path : paths) area += ClipperLib::Area(path);
    return area;
}

// The view of one piece of a light from one receiver.
class View {
public:
    View(const Piece& piece, const Receiver& receiver, const ShadowOrigin& origin, const std::array<vec3, 3>& own)
        : piece_(piece), own_(own) {
        origin_ = dvec3(origin.position);
        const LightFrame& frame = piece.frame;
        dvec3 center = frame.center - origin_;
        const dvec3 up = glm::normalize(glm::cross(frame.a, frame.b));
        // In the light's plane the projection does not exist; a little beside it the light is as good as edge-on.
        const double least = 1e-7 * (glm::length(frame.a) + glm::length(frame.b)), height = glm::dot(up, center);
        if (std::abs(height) < least) center += up * (height < 0 ? -least : least);
        to_light_ = glm::inverse(glm::dmat3(frame.a, frame.b, center));
        // Rays end short of the light's points by the rounding of their coordinates.
        const dvec3 reach = glm::abs(center) + glm::abs(frame.a) + glm::abs(frame.b);
        const double rounding =
            std::max(static_cast<double>(origin.rounding), static_cast<double>(relative_step) * largest(frame.center));
        cuts_.push_back({{0, 0, 1}, 1e-12});
        cuts_.push_back({{0, 0, -1}, rounding / largest(reach) - 1});
        for (const double sign : {1.0, -1.0}) {
            cuts_.push_back({{sign, 0, beyond_light}, 0});
            cuts_.push_back({{0, sign, beyond_light}, 0});
        }
        // The receiver's horizon, which goes through the receiver, not through the rays' origin. What lies in it is not
        // seen.
        const dvec3 n(receiver.geometric_normal);
        horizon_ = {dvec3(glm::dot(n, frame.a), glm::dot(n, frame.b), glm::dot(n, center)),
                    glm::dot(n, dvec3(receiver.position) - origin_) + 1e-12 * largest(reach)};
        Polygon outline, scratch;
        for (const dvec2& p : piece.outline) outline.emplace_back(p, 1.0);
        clip(outline, horizon_, scratch);
        for (const dvec3& p : outline) visible_.push_back(on_grid(dvec2(p)));
    }

    bool below_horizon() const { return visible_.size() < 3; }

    void add_triangle(const std::array<vec3, 3>& corners) {
        // As for rays: what starts in the plane of a triangle, in a crease of a surface, leaves it behind.
        const HitTriangle hit = hit_triangle(corners);
        const RelativeSides own = sides_of(hit, own_);
        const double side = glm::dot(hit.normal, origin_ - hit.corner);
        if ((own.in_front && side < 0) || (own.behind && side > 0)) return;
        polygon_.clear();
        for (size_t k = 0; k < 3; ++k) polygon_.push_back(to_light_ * (dvec3(corners[k]) - origin_));
        for (const Cut& cut : cuts_) {
            clip(polygon_, cut, scratch_);
            if (polygon_.size() < 3) return;
        }
        Path path;
        for (const dvec3& p : polygon_) path.push_back(on_grid(dvec2(p) / p.z));
        const double area = ClipperLib::Area(path);
        if (area == 0) return;
        if (area < 0) std::reverse(path.begin(), path.end());
        hidden_.push_back(std::move(path));
    }

    // Of the piece.
    double visible_fraction() const {
        Path whole;
        for (const dvec2& p : piece_.outline) whole.push_back(on_grid(p));
        const double all = ClipperLib::Area(whole);
        if (hidden_.empty()) return ClipperLib::Area(visible_) / all;
        ClipperLib::Clipper clipper;
        clipper.AddPath(visible_, ClipperLib::ptSubject, true);
        clipper.AddPaths(hidden_, ClipperLib::ptClip, true);
        ClipperLib::Paths left;
        clipper.Execute(ClipperLib::ctDifference, left, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
        return std::clamp(area_of(left) / all, 0.0, 1.0);
    }

private:
    static double largest(dvec3 v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

    const Piece& piece_;
    std::array<vec3, 3> own_; // corners of the receiver's triangle
    dvec3 origin_;
    glm::dmat3 to_light_;
    std::vector<Cut> cuts_;
    Cut horizon_;
    Path visible_; // the piece above the horizon
    ClipperLib::Paths hidden_;
    Polygon polygon_, scratch_;
};

// All but the scene in the clusters' local coordinates.
double visible_fraction(const Scene& scene, const TriangleClusters& clusters, const Receiver& receiver,
                        const Piece& piece) {
    const auto corners_of = [&](std::uint32_t triangle) {
        const uvec3 t = scene.triangles[triangle];
        return std::array{scene.positions[t.x] - clusters.shift, scene.positions[t.y] - clusters.shift,
                          scene.positions[t.z] - clusters.shift};
    };
    const auto own = corners_of(receiver.triangle);
    const ShadowOrigin origin = shadow_origin(receiver, own, clusters.shift);
    View view(piece, receiver, origin, own);
    if (view.below_horizon()) return 0.0;
    const dvec3 spread = glm::abs(piece.frame.a) + glm::abs(piece.frame.b);
    const Bounds around{vec3(piece.frame.center - spread), vec3(piece.frame.center + spread)};
    const auto nearby = clusters_in(shaft_between({origin.position, origin.position}, around), clusters,
                                    std::numeric_limits<size_t>::max());
    for (const std::uint32_t index : nearby->clusters) {
        const TriangleCluster& cluster = clusters.clusters[index];
        for (std::uint32_t i = 0; i < cluster.count; ++i)
            if (cluster.triangle[i] != receiver.triangle) view.add_triangle(corners_of(cluster.triangle[i]));
    }
    return view.visible_fraction();
}

} // namespace

double exact_visibility(const Scene& scene, const TriangleClusters& clusters, const Receiver& receiver,
                        const Light& light) {
    double seen = 0, all = 0;
    const Receiver local = to_local(receiver, clusters.shift);
    for (const Piece& piece : pieces_of(to_local(light, clusters.shift), local.position)) {
        seen += piece.area * visible_fraction(scene, clusters, local, piece);
        all += piece.area;
    }
    return all > 0 ? seen / all : 1.0;
}

Image<float> exact_visibility(const Scene& scene, const TriangleClusters& clusters, const Receivers& receivers,
                              const Light& light, Progress* progress) {
    if (!is_area(light))
        throw UsageError("the exact method needs an area light, and '" + light.name + "' is a " +
                         light_type_name(light.type) + " light: its visibility is exact with one ray");
    Image<float> visibility(receivers.width(), receivers.height(), 1.0f);
    const auto row = [&](size_t begin, size_t) {
        const int y = static_cast<int>(begin);
        for (int x = 0; x < receivers.width(); ++x)
            if (const Receiver& receiver = receivers(x, y); receiver.valid())
                visibility(x, y) = static_cast<float>(exact_visibility(scene, clusters, receiver, light));
        if (progress) progress->advance(receivers.width());
    };
    parallel_for(static_cast<size_t>(receivers.height()), 1, row);
    return visibility;
}

} // namespace gnomon
