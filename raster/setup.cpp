#include "raster/setup.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <emmintrin.h>
#include <fmt/format.h>

#include "core/error.h"

namespace gnomon {
namespace {

constexpr double guard_band_pixels = 16384.0;
constexpr double subpixels = 256.0;

// A vertex on its way: clip position, and its barycentric coordinates in the submitted triangle.
struct ClipVertex {
    vec4 position;
    dvec3 barycentric;
};

bool precedes(const vec4& a, const vec4& b) {
    if (a.x != b.x) return a.x < b.x;
    if (a.y != b.y) return a.y < b.y;
    if (a.z != b.z) return a.z < b.z;
    return a.w < b.w;
}

// Half-spaces dot(normal, position) ≥ 0.
struct ClipPlanes {
    std::array<dvec4, 6> normals;
    int count = 0;
};

ClipPlanes clip_planes(const SetupState& state) {
    ClipPlanes planes;
    if (!state.depth_clamp) {
        planes.normals[0] = state.clip_depth == ClipDepth::ZeroToOne ? dvec4(0, 0, 1, 0) : dvec4(0, 0, 1, 1);
        planes.normals[1] = dvec4(0, 0, -1, 1);
        planes.count = 2;
    }
    const double gx = 2.0 * guard_band_pixels / state.viewport.width;
    const double gy = 2.0 * guard_band_pixels / state.viewport.height;
    planes.normals[static_cast<size_t>(planes.count++)] = dvec4(1, 0, 0, gx);
    planes.normals[static_cast<size_t>(planes.count++)] = dvec4(-1, 0, 0, gx);
    planes.normals[static_cast<size_t>(planes.count++)] = dvec4(0, 1, 0, gy);
    planes.normals[static_cast<size_t>(planes.count++)] = dvec4(0, -1, 0, gy);
    return planes;
}

// The point where the edge meets the plane, cut from the smaller end point whichever way the edge runs.
ClipVertex cut(const ClipVertex& a, double distance_a, const ClipVertex& b, double distance_b) {
    if (precedes(b.position, a.position)) return cut(b, distance_b, a, distance_a);
    const double t = distance_a / (distance_a - distance_b);
    const dvec4 pa(a.position), pb(b.position);
    return {vec4(pa + (pb - pa) * t), a.barycentric + (b.barycentric - a.barycentric) * t};
}

using Polygon = std::array<ClipVertex, 9>; // 3 corners and at most one more for each of 6 planes

int clip(Polygon& polygon, const ClipPlanes& planes) {
    int count = 3;
    for (int p = 0; p < planes.count && count >= 3; ++p) {
        const dvec4& normal = planes.normals[static_cast<size_t>(p)];
        Polygon kept;
        int kept_count = 0;
        std::array<double, 9> distance;
        for (int i = 0; i < count; ++i)
            distance[static_cast<size_t>(i)] = glm::dot(normal, dvec4(polygon[static_cast<size_t>(i)].position));
        for (int i = 0; i < count; ++i) {
            const auto a = static_cast<size_t>(i), b = static_cast<size_t>((i + 1) % count);
            if (distance[a] >= 0) kept[static_cast<size_t>(kept_count++)] = polygon[a];
            if ((distance[a] >= 0) != (distance[b] >= 0))
                kept[static_cast<size_t>(kept_count++)] = cut(polygon[a], distance[a], polygon[b], distance[b]);
        }
        polygon = kept;
        count = kept_count;
    }
    return count;
}

using Corners = std::array<WindowVertex, 3>;

struct Box {
    std::int32_t x0, y0, x1, y1;
};

// Signed doubled area and box of pixel centres; false where the triangle is culled.
bool survives(const SetupState& state, const Corners& v, bool mirrored, std::int64_t& area, bool& front, Box& box) {
    area = std::int64_t{v[1].x - v[0].x} * (v[2].y - v[0].y) - std::int64_t{v[2].x - v[0].x} * (v[1].y - v[0].y);
    if (area == 0) return false;
    front = ((area > 0) != mirrored) == (state.front_face == FrontFace::CounterClockwise);
    if (state.cull == (front ? Cull::Front : Cull::Back)) return false;
    const Rectangle& d = state.drawable;
    const bool whole_pixels = state.conservative || state.multisampled;
    const auto first_center = [&](std::int32_t fixed) { return (fixed + (whole_pixels ? 0 : 127)) >> 8; };
    const auto last_center = [&](std::int32_t fixed) { return (fixed - (whole_pixels ? 0 : 128)) >> 8; };
    box.x0 = std::max(first_center(std::min(std::min(v[0].x, v[1].x), v[2].x)), d.x);
    box.x1 = std::min(last_center(std::max(std::max(v[0].x, v[1].x), v[2].x)), d.x + d.width - 1);
    box.y0 = std::max(first_center(std::min(std::min(v[0].y, v[1].y), v[2].y)), d.y);
    box.y1 = std::min(last_center(std::max(std::max(v[0].y, v[1].y), v[2].y)), d.y + d.height - 1);
    return box.x0 <= box.x1 && box.y0 <= box.y1;
}

bool comes_before(const WindowVertex& a, const WindowVertex& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }

// The planes' frame: anchor and edges from the vertices in the order of their positions, independent of winding and
// submission.
struct PlaneFrame {
    std::array<int, 3> order;
    dvec2 e1, e2; // pixels
    double area;

    explicit PlaneFrame(const Corners& v) : order{0, 1, 2} {
        const auto sort_pair = [&](size_t i, size_t j) {
            if (comes_before(v[static_cast<size_t>(order[j])], v[static_cast<size_t>(order[i])]))
                std::swap(order[i], order[j]);
        };
        sort_pair(0, 1), sort_pair(1, 2), sort_pair(0, 1);
        const WindowVertex &s0 = v[static_cast<size_t>(order[0])], &s1 = v[static_cast<size_t>(order[1])],
                           &s2 = v[static_cast<size_t>(order[2])];
        e1 = dvec2(s1.x - s0.x, s1.y - s0.y) * (1.0 / subpixels);
        e2 = dvec2(s2.x - s0.x, s2.y - s0.y) * (1.0 / subpixels);
        area = e1.x * e2.y - e2.x * e1.y;
    }
    // Through three values at the corners, gradients per pixel.
    Plane plane(const std::array<double, 3>& f) const {
        const double f0 = f[static_cast<size_t>(order[0])];
        const double d1 = f[static_cast<size_t>(order[1])] - f0, d2 = f[static_cast<size_t>(order[2])] - f0;
        return {f0, (d1 * e2.y - d2 * e1.y) / area, (d2 * e1.x - d1 * e2.x) / area};
    }
};

void set_edges(SetupTriangle& t, const Corners& v, bool clockwise, bool conservative) {
    const std::array<size_t, 3> order = clockwise ? std::array<size_t, 3>{0, 2, 1} : std::array<size_t, 3>{0, 1, 2};
    for (size_t i = 0; i < 3; ++i) {
        const WindowVertex &p = v[order[i]], &q = v[order[(i + 1) % 3]];
        const std::int64_t dx = q.x - p.x, dy = q.y - p.y;
        const bool inclusive = dy < 0 || (dy == 0 && dx > 0); // a left edge, or a bottom edge
        t.a[i] = -dy;
        t.b[i] = dx;
        t.c[i] = dy * p.x - dx * p.y - (inclusive ? 0 : 1);
        if (conservative) t.c[i] += 128 * (std::abs(dx) + std::abs(dy)); // the pixel's corner that is most inside
    }
}

double offset_of(const SetupState& state, const SetupTriangle& t) {
    const PolygonOffset& offset = state.polygon_offset;
    if (offset.factor == 0 && offset.units == 0) return 0;
    const double slope = std::max(std::abs(t.depth.dx), std::abs(t.depth.dy));
    double o = static_cast<double>(offset.factor) * slope +
               static_cast<double>(offset.units) * depth_resolution(state.depth_format, t.depth_maximum);
    if (offset.clamp > 0) o = std::min(o, static_cast<double>(offset.clamp));
    if (offset.clamp < 0) o = std::max(o, static_cast<double>(offset.clamp));
    return o;
}

// Snapped triangle to set-up; false where it is culled. `barycentric` and `w` of the corners matter for attributes
// only.
bool emit(const SetupState& state, const Corners& v, const std::array<dvec3, 3>& barycentric,
          const std::array<float, 3>& w, bool mirrored, std::uint32_t primitive, std::vector<SetupTriangle>& triangles,
          std::vector<AttributePlanes>& attributes) {
    std::int64_t area;
    bool front;
    Box box;
    if (!survives(state, v, mirrored, area, front, box)) return false;
    const PlaneFrame frame(v);
    SetupTriangle& t = triangles.emplace_back();
    t.x0 = box.x0, t.x1 = box.x1, t.y0 = box.y0, t.y1 = box.y1;
    t.primitive = primitive;
    t.front = front;
    t.anchor_x = v[static_cast<size_t>(frame.order[0])].x * (1.0 / subpixels);
    t.anchor_y = v[static_cast<size_t>(frame.order[0])].y * (1.0 / subpixels);
    t.depth = frame.plane({v[0].z, v[1].z, v[2].z});
    t.depth_minimum = std::min(std::min(v[0].z, v[1].z), v[2].z);
    t.depth_maximum = std::max(std::max(v[0].z, v[1].z), v[2].z);
    t.depth_offset = offset_of(state, t);
    set_edges(t, v, area < 0, state.conservative);
    if (state.attributes) {
        std::array<double, 3> inverse_w, second, third;
        for (size_t i = 0; i < 3; ++i) {
            inverse_w[i] = 1.0 / static_cast<double>(w[i]);
            second[i] = barycentric[i].y * inverse_w[i];
            third[i] = barycentric[i].z * inverse_w[i];
        }
        attributes.push_back({frame.plane(inverse_w), frame.plane(second), frame.plane(third),
                              frame.plane({barycentric[0].y, barycentric[1].y, barycentric[2].y}),
                              frame.plane({barycentric[0].z, barycentric[1].z, barycentric[2].z})});
    }
    return true;
}

// Bits of the frustum planes that p lies outside of; with depth clamp the near and far planes do not count.
std::uint32_t outside_frustum(const SetupState& state, const vec4& p) {
    std::uint32_t bits = 0;
    if (p.x < -p.w) bits |= 1;
    if (p.x > p.w) bits |= 2;
    if (p.y < -p.w) bits |= 4;
    if (p.y > p.w) bits |= 8;
    if (!state.depth_clamp) {
        if (p.z < (state.clip_depth == ClipDepth::ZeroToOne ? 0.0f : -p.w)) bits |= 16;
        if (p.z > p.w) bits |= 32;
    }
    return bits;
}

// The same sums in double as the clipper's: whether a vertex is cut away must not depend on which triangle asks.
bool inside_guard_band(const SetupState& state, const dvec4& q) {
    const double gx = 2.0 * guard_band_pixels / state.viewport.width;
    const double gy = 2.0 * guard_band_pixels / state.viewport.height;
    return q.w > 0 && q.x + gx * q.w >= 0 && gx * q.w - q.x >= 0 && q.y + gy * q.w >= 0 && gy * q.w - q.y >= 0;
}

WindowVertex snap(const SetupState& state, const vec4& p, std::uint32_t flags) {
    const float half_width = 0.5f * static_cast<float>(state.viewport.width);
    const float half_height = 0.5f * static_cast<float>(state.viewport.height);
    const float oow = 1.0f / p.w;
    const float x = p.x * oow * half_width + (static_cast<float>(state.viewport.x) + half_width);
    const float y = p.y * oow * half_height + (static_cast<float>(state.viewport.y) + half_height);
    const float z = state.clip_depth == ClipDepth::ZeroToOne ? p.z * oow : p.z * oow * 0.5f + 0.5f;
    // The conversion instruction rounds to nearest even in the mode that every pass sets.
    return {_mm_cvtss_si32(_mm_set_ss(x * 256.0f)), _mm_cvtss_si32(_mm_set_ss(y * 256.0f)), z, flags};
}

} // namespace

std::span<const glm::ivec2> sample_positions(int samples) {
    static constexpr std::array<glm::ivec2, 1> one = {{{128, 128}}};
    static constexpr std::array<glm::ivec2, 4> four = {{{96, 32}, {224, 96}, {32, 160}, {160, 224}}};
    static constexpr std::array<glm::ivec2, 8> eight = {
        {{144, 80}, {112, 176}, {208, 144}, {80, 48}, {48, 208}, {16, 112}, {176, 240}, {240, 16}}};
    switch (samples) {
    case 1:
        return one;
    case 4:
        return four;
    case 8:
        return eight;
    default:
        throw UsageError(fmt::format("{} samples per pixel are not possible; 1, 4 and 8 are", samples));
    }
}

SetupTriangle seen_by_sample(SetupTriangle t, glm::ivec2 position) {
    const glm::ivec2 offset = position - 128;
    for (int e = 0; e < 3; ++e) t.c[e] += t.a[e] * offset.x + t.b[e] * offset.y;
    t.anchor_x -= offset.x * (1.0 / subpixels); // exact: multiples of 1/256
    t.anchor_y -= offset.y * (1.0 / subpixels);
    return t;
}

WindowVertex to_window(const SetupState& state, const vec4& p) {
    const std::uint32_t outside = outside_frustum(state, p);
    if ((outside & 48u) || !inside_guard_band(state, dvec4(p))) return {0, 0, 0, outside | needs_clip};
    return snap(state, p, outside);
}

void set_up_triangle(const SetupState& state, const vec4* positions, const WindowVertex* window, const uvec3& index,
                     std::uint32_t primitive, std::vector<SetupTriangle>& triangles,
                     std::vector<AttributePlanes>& attributes, SetupCounts& counts) {
    const Corners v = {window[index.x], window[index.y], window[index.z]};
    if (v[0].flags & v[1].flags & v[2].flags & outside_mask) {
        ++counts.culled;
        return;
    }
    if (!((v[0].flags | v[1].flags | v[2].flags) & needs_clip)) {
        const std::array<float, 3> w = {positions[index.x].w, positions[index.y].w, positions[index.z].w};
        static constexpr std::array<dvec3, 3> whole = {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)};
        if (!emit(state, v, whole, w, false, primitive, triangles, attributes)) ++counts.culled;
        return;
    }

    // Clip the corners in canonical order, so that the fan does not depend on winding or first vertex.
    const vec4* p[3] = {&positions[index.x], &positions[index.y], &positions[index.z]};
    std::array<int, 3> order = {0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int i, int j) { return precedes(*p[i], *p[j]); });
    const bool mirrored = (order[1] - order[0] + 3) % 3 != 1;
    Polygon polygon;
    for (size_t i = 0; i < 3; ++i) {
        dvec3 barycentric(0.0);
        barycentric[order[i]] = 1.0;
        polygon[i] = {*p[order[i]], barycentric};
    }
    const int count = clip(polygon, clip_planes(state));
    ++counts.clipped;
    bool any = false;
    for (size_t i = 1; static_cast<int>(i) + 1 < count; ++i) {
        const ClipVertex &c0 = polygon[0], &c1 = polygon[i], &c2 = polygon[i + 1];
        if (c0.position.w <= 0 || c1.position.w <= 0 || c2.position.w <= 0) continue;
        any |= emit(state, {snap(state, c0.position, 0), snap(state, c1.position, 0), snap(state, c2.position, 0)},
                    {c0.barycentric, c1.barycentric, c2.barycentric}, {c0.position.w, c1.position.w, c2.position.w},
                    mirrored, primitive, triangles, attributes);
    }
    if (!any) ++counts.culled;
}

} // namespace gnomon
