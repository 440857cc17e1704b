#include "raster/setup.h"

#include <algorithm>
#include <array>
#include <cmath>

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

struct WindowVertex {
    std::int64_t x, y; // 1/256 pixels
    float z;
    double inverse_w;
};

WindowVertex to_window(const SetupState& state, const vec4& p) {
    const float half_width = 0.5f * static_cast<float>(state.viewport.width);
    const float half_height = 0.5f * static_cast<float>(state.viewport.height);
    const float oow = 1.0f / p.w;
    const float x = p.x * oow * half_width + (static_cast<float>(state.viewport.x) + half_width);
    const float y = p.y * oow * half_height + (static_cast<float>(state.viewport.y) + half_height);
    const float z = state.clip_depth == ClipDepth::ZeroToOne ? p.z * oow : p.z * oow * 0.5f + 0.5f;
    return {std::llrintf(x * 256.0f), std::llrintf(y * 256.0f), z, 1.0 / static_cast<double>(p.w)};
}

int first_center(std::int64_t fixed) { return static_cast<int>((fixed + 127) >> 8); } // ⌈(fixed − 128)/256⌉
int last_center(std::int64_t fixed) { return static_cast<int>((fixed - 128) >> 8); }  // ⌊(fixed − 128)/256⌋

// A plane through three values, gradients per pixel. `area` is the signed doubled area in pixels², exact.
Plane plane_through(double f0, double f1, double f2, dvec2 e1, dvec2 e2, double area) {
    const double d1 = f1 - f0, d2 = f2 - f0;
    return {f0, (d1 * e2.y - d2 * e1.y) / area, (d2 * e1.x - d1 * e2.x) / area};
}

// Snapped triangle to set-up; false where it is culled.
bool emit(const SetupState& state, std::array<WindowVertex, 3> v, std::array<dvec3, 3> barycentric, bool mirrored,
          std::uint32_t primitive, std::vector<SetupTriangle>& triangles, std::vector<AttributePlanes>& attributes) {
    const std::int64_t area = (v[1].x - v[0].x) * (v[2].y - v[0].y) - (v[2].x - v[0].x) * (v[1].y - v[0].y);
    if (area == 0) return false;
    const bool counter_clockwise = (area > 0) != mirrored;
    const bool front = counter_clockwise == (state.front_face == FrontFace::CounterClockwise);
    if (state.cull == (front ? Cull::Front : Cull::Back)) return false;

    const auto [min_x, max_x] = std::minmax({v[0].x, v[1].x, v[2].x});
    const auto [min_y, max_y] = std::minmax({v[0].y, v[1].y, v[2].y});
    const Rectangle& d = state.drawable;
    const int x0 = std::max(first_center(min_x), d.x), x1 = std::min(last_center(max_x), d.x + d.width - 1);
    const int y0 = std::max(first_center(min_y), d.y), y1 = std::min(last_center(max_y), d.y + d.height - 1);
    if (x0 > x1 || y0 > y1) return false;

    // Anchor and gradients from the vertices in the order of their positions: independent of winding and submission.
    std::array<size_t, 3> order = {0, 1, 2};
    std::sort(order.begin(), order.end(),
              [&](size_t i, size_t j) { return v[i].x != v[j].x ? v[i].x < v[j].x : v[i].y < v[j].y; });
    const WindowVertex &s0 = v[order[0]], &s1 = v[order[1]], &s2 = v[order[2]];
    const dvec2 e1 = dvec2(static_cast<double>(s1.x - s0.x), static_cast<double>(s1.y - s0.y)) / subpixels;
    const dvec2 e2 = dvec2(static_cast<double>(s2.x - s0.x), static_cast<double>(s2.y - s0.y)) / subpixels;
    const double sorted_area = e1.x * e2.y - e2.x * e1.y;

    SetupTriangle& t = triangles.emplace_back();
    t.x0 = x0, t.x1 = x1, t.y0 = y0, t.y1 = y1;
    t.primitive = primitive;
    t.front = front;
    t.anchor_x = static_cast<double>(s0.x) / subpixels;
    t.anchor_y = static_cast<double>(s0.y) / subpixels;
    t.depth = plane_through(s0.z, s1.z, s2.z, e1, e2, sorted_area);
    t.depth_minimum = std::min({v[0].z, v[1].z, v[2].z});
    t.depth_maximum = std::max({v[0].z, v[1].z, v[2].z});
    t.depth_offset = 0;
    const PolygonOffset& offset = state.polygon_offset;
    if (offset.factor != 0 || offset.units != 0) {
        const double slope = std::max(std::abs(t.depth.dx), std::abs(t.depth.dy));
        t.depth_offset = static_cast<double>(offset.factor) * slope +
                         static_cast<double>(offset.units) * depth_resolution(state.depth_format, t.depth_maximum);
        if (offset.clamp > 0) t.depth_offset = std::min(t.depth_offset, static_cast<double>(offset.clamp));
        if (offset.clamp < 0) t.depth_offset = std::max(t.depth_offset, static_cast<double>(offset.clamp));
    }

    if (area < 0) std::swap(v[1], v[2]), std::swap(barycentric[1], barycentric[2]);
    for (size_t i = 0; i < 3; ++i) {
        const WindowVertex &p = v[i], &q = v[(i + 1) % 3];
        const std::int64_t dx = q.x - p.x, dy = q.y - p.y;
        t.a[i] = -dy;
        t.b[i] = dx;
        t.c[i] = dy * p.x - dx * p.y;
        const bool inclusive = dy < 0 || (dy == 0 && dx > 0); // a left edge, or a bottom edge
        if (!inclusive) --t.c[i];
    }

    if (state.attributes) {
        // The swap above moved vertices of `v`; the sorted order is redone on what each sorted vertex was.
        if (area < 0)
            for (size_t& i : order) i = i == 0 ? 0 : 3 - i;
        const auto plane = [&](auto value) {
            return plane_through(value(order[0]), value(order[1]), value(order[2]), e1, e2, sorted_area);
        };
        attributes.push_back({plane([&](size_t i) { return v[i].inverse_w; }),
                              plane([&](size_t i) { return barycentric[i].y * v[i].inverse_w; }),
                              plane([&](size_t i) { return barycentric[i].z * v[i].inverse_w; })});
    }
    return true;
}

// Bits of the frustum planes that p lies outside of; with depth clamp the near and far planes do not count.
unsigned outside_frustum(const SetupState& state, const vec4& p) {
    unsigned bits = 0;
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

} // namespace

void set_up_triangle(const SetupState& state, const vec4& p0, const vec4& p1, const vec4& p2, std::uint32_t primitive,
                     std::vector<SetupTriangle>& triangles, std::vector<AttributePlanes>& attributes,
                     SetupCounts& counts) {
    const vec4* p[3] = {&p0, &p1, &p2};
    const unsigned o0 = outside_frustum(state, p0), o1 = outside_frustum(state, p1), o2 = outside_frustum(state, p2);
    if (o0 & o1 & o2) {
        ++counts.culled;
        return;
    }
    // The same sums in double as the clipper's: whether a vertex is cut away must not depend on which triangle asks.
    const double gx = 2.0 * guard_band_pixels / state.viewport.width;
    const double gy = 2.0 * guard_band_pixels / state.viewport.height;
    const auto inside_guard_band = [&](const dvec4& q) {
        return q.w > 0 && q.x + gx * q.w >= 0 && gx * q.w - q.x >= 0 && q.y + gy * q.w >= 0 && gy * q.w - q.y >= 0;
    };
    const bool unclipped = !((o0 | o1 | o2) & 48u) && inside_guard_band(dvec4(p0)) && inside_guard_band(dvec4(p1)) &&
                           inside_guard_band(dvec4(p2));
    if (unclipped) {
        const std::array<WindowVertex, 3> v = {to_window(state, p0), to_window(state, p1), to_window(state, p2)};
        const std::array<dvec3, 3> barycentric = {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)};
        if (!emit(state, v, barycentric, false, primitive, triangles, attributes)) ++counts.culled;
        return;
    }

    // Clip the corners in canonical order, so that the fan does not depend on winding or first vertex.
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
    for (int i = 1; i + 1 < count; ++i) {
        const ClipVertex* corner[3] = {&polygon[0], &polygon[static_cast<size_t>(i)],
                                       &polygon[static_cast<size_t>(i + 1)]};
        if (corner[0]->position.w <= 0 || corner[1]->position.w <= 0 || corner[2]->position.w <= 0) continue;
        any |= emit(state,
                    {to_window(state, corner[0]->position), to_window(state, corner[1]->position),
                     to_window(state, corner[2]->position)},
                    {corner[0]->barycentric, corner[1]->barycentric, corner[2]->barycentric}, mirrored, primitive,
                    triangles, attributes);
    }
    if (!any) ++counts.culled;
}

} // namespace gnomon
