#include "raster/setup.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "core/error.h"
#include "raster/clip.h"
#include "raster/setup_kernels.h"

namespace gnomon {
namespace {

using detail::Survivors;

// What the planes of one triangle share: its edges from the anchor in pixels, and which submitted corner stands where.
struct PlaneFrame {
    dvec2 e1, e2;
    double area;
    std::array<size_t, 3> corner;

    explicit PlaneFrame(const SetupTriangle& t)
        : e1(dvec2(t.x[1] - t.x[0], t.y[1] - t.y[0]) * (1.0 / subpixels)),
          e2(dvec2(t.x[2] - t.x[0], t.y[2] - t.y[0]) * (1.0 / subpixels)),
          area(e1.x * e2.y - e2.x * e1.y), corner{t.corner(0), t.corner(1), t.corner(2)} {}

    // Through three values at the submitted corners: the gradients per pixel.
    Plane through(const std::array<double, 3>& value) const {
        const double f = value[corner[0]], d1 = value[corner[1]] - f, d2 = value[corner[2]] - f;
        return {f, (d1 * e2.y - d2 * e1.y) / area, (d2 * e1.x - d1 * e2.x) / area};
    }
};

AttributePlanes planes_of(const SetupTriangle& t, const std::array<dvec3, 3>& barycentric, const vec3& w, bool linear) {
    const PlaneFrame frame(t);
    const std::array<double, 3> inverse_w = {1.0 / static_cast<double>(w.x), 1.0 / static_cast<double>(w.y),
                                             1.0 / static_cast<double>(w.z)};
    const auto plane = [&](const auto& value) { return frame.through({value(0), value(1), value(2)}); };
    AttributePlanes planes;
    planes.set(0, frame.through(inverse_w));
    planes.set(1, plane([&](size_t i) { return barycentric[i].y * inverse_w[i]; }));
    planes.set(2, plane([&](size_t i) { return barycentric[i].z * inverse_w[i]; }));
    planes.set(3, {0, 0, 0});
    planes.anchor_x = t.anchor_x(), planes.anchor_y = t.anchor_y();
    if (linear) {
        planes.second_linear = plane([&](size_t i) { return barycentric[i].y; });
        planes.third_linear = plane([&](size_t i) { return barycentric[i].z; });
    }
    return planes;
}

// Where a survivor gets its depth from if it is a piece: over the window, from the origin.
struct PieceDepth {
    size_t survivor;
    Plane depth;
};

// A triangle that is clipped, as submitted.
struct ClippedTriangle {
    std::array<vec4, 3> clip;
    std::array<WindowVertex, 3> window;
};

// Its depth over the window. In homogeneous pixels (x·w, y·w, w) a corner that needs no clipping is where it was
// snapped, so that neighbours meet there, and one that does is exact, wherever it may lie: what the cuts round does not
// matter. [Olano and Greer 1997, "Triangle Scan Conversion using 2D Homogeneous Coordinates", 3] Nothing where the
// triangle is seen from its edge. `order` of the corners makes the sums those of any submission order.
std::optional<Plane> clipped_depth(const SetupState& state, const ClippedTriangle& triangle,
                                   const std::array<size_t, 3>& order) {
    const Rectangle& v = state.viewport;
    const dvec2 half(0.5 * v.width, 0.5 * v.height);
    std::array<dvec3, 3> at;
    std::array<double, 3> depth;
    for (size_t i = 0; i < 3; ++i) {
        const dvec4 p(triangle.clip[order[i]]);
        const WindowVertex& window = triangle.window[order[i]];
        if (window.flags & needs_clip) {
            at[i] = dvec3((dvec2(v.x, v.y) + half) * p.w + dvec2(p) * half, p.w);
            depth[i] = state.clip_depth == ClipDepth::ZeroToOne ? p.z : 0.5 * (p.z + p.w);
        } else {
            at[i] = dvec3(window.x / subpixels, window.y / subpixels, 1.0) * p.w;
            depth[i] = static_cast<double>(window.z) * p.w;
        }
    }
    const dvec3 n0 = glm::cross(at[1], at[2]), n1 = glm::cross(at[2], at[0]), n2 = glm::cross(at[0], at[1]);
    const dvec3 plane = (depth[0] * n0 + depth[1] * n1 + depth[2] * n2) / glm::dot(at[0], n0);
    if (!std::isfinite(plane.x) || !std::isfinite(plane.y) || !std::isfinite(plane.z)) return std::nullopt;
    return Plane{plane.z, plane.x, plane.y};
}

void set_depth(SetupTriangle& t, const Plane& depth) {
    t.depth = static_cast<float>((depth.value + depth.dy * t.anchor_y()) + depth.dx * t.anchor_x());
    t.depth_dx = depth.dx, t.depth_dy = depth.dy;
    t.steady = false;
}

// Clips one triangle and appends the pieces that are not culled, at most one for each corner of the polygon.
void clip_triangle(const SetupState& state, const ClippedTriangle& triangle, std::uint32_t primitive,
                   Survivors& survivors, std::vector<PieceDepth>& depths, SetupTriangles& out) {
    ++out.counts.clipped;
    const ClippedPolygon polygon = clip(state, triangle.clip);
    const auto corner = [&](size_t i) -> const ClipVertex& { return polygon.corners[i]; };
    std::array<vec4, 9> positions;
    std::array<WindowVertex, 9> window;
    std::array<uvec3, most_clipped_pieces> fan;
    size_t pieces = 0;
    for (size_t i = 0; i < static_cast<size_t>(polygon.count); ++i) positions[i] = corner(i).position;
    detail::setup_kernels().to_window(state, positions.data(), static_cast<size_t>(polygon.count), window.data());
    for (WindowVertex& v : window) v.flags = 0; // they lie on the planes, give or take a rounding
    for (std::uint32_t i = 1; static_cast<int>(i) + 1 < polygon.count; ++i)
        if (corner(0).position.w > 0 && corner(i).position.w > 0 && corner(i + 1).position.w > 0)
            fan[pieces++] = {0, i, i + 1};
    const size_t before = survivors.count, empty_before = survivors.empty;
    detail::setup_kernels().cull(state, window.data(), fan.data(), pieces, 0, polygon.mirrored, survivors);
    if (survivors.count == before && survivors.empty == empty_before) ++out.counts.culled;
    if (survivors.count == before) return;
    const std::optional<Plane> depth = clipped_depth(state, triangle, polygon.order);
    for (size_t k = before; k < survivors.count; ++k) {
        if (depth) depths.push_back({k, *depth});
        const uvec3 piece = fan[survivors.primitive[k]];
        survivors.primitive[k] = primitive;
        survivors.piece[k] = static_cast<std::uint32_t>(out.pieces.size());
        if (!state.attributes) continue;
        ClippedPiece& kept = out.pieces.emplace_back();
        for (glm::length_t i = 0; i < 3; ++i) {
            kept.barycentric[i] = corner(piece[i]).barycentric;
            kept.w[i] = corner(piece[i]).position.w;
        }
    }
}

// o = factor·m + units·r. [OpenGL 4.6, 14.6.5]
double offset_of(const SetupState& state, const SetupTriangle& t) {
    const PolygonOffset& offset = state.polygon_offset;
    const double slope = std::max(std::abs(t.depth_dx), std::abs(t.depth_dy));
    const double unit = depth_resolution(state.depth_format, static_cast<double>(t.depth_maximum));
    double o = static_cast<double>(offset.factor) * slope + static_cast<double>(offset.units) * unit;
    if (offset.clamp > 0) o = std::min(o, static_cast<double>(offset.clamp));
    if (offset.clamp < 0) o = std::max(o, static_cast<double>(offset.clamp));
    return o;
}

} // namespace

TileEdges tile_edges(const SetupTriangle& t, bool conservative, int tile_x, int tile_y) {
    TileEdges edges;
    constexpr std::int64_t span = tile_side - 1;
    const std::int64_t x = std::int64_t{tile_x} * 256 + 128, y = std::int64_t{tile_y} * 256 + 128;
    for (size_t e = 0; e < 3; ++e) {
        const std::int64_t a = t.y[e] - t.y[e + 1], b = t.x[e + 1] - t.x[e];
        const bool inclusive = a > 0 || (a == 0 && b > 0); // a left edge, or a bottom edge
        std::int64_t corner = a * (x - t.x[e]) + b * (y - t.y[e]) - (inclusive ? 0 : 1);
        if (conservative) corner += 128 * (std::abs(a) + std::abs(b)); // the pixel's corner that is most inside
        const std::int64_t base = corner >> 8;
        const std::int64_t least = base + span * (std::min<std::int64_t>(a, 0) + std::min<std::int64_t>(b, 0));
        const std::int64_t most = base + span * (std::max<std::int64_t>(a, 0) + std::max<std::int64_t>(b, 0));
        const bool inside = least >= 0;
        edges.empty |= most < 0;
        edges.crossed |= !inside;
        edges.base[e] = inside || most < 0 ? 0 : static_cast<std::int32_t>(base);
        edges.a[e] = inside ? 0 : static_cast<std::int32_t>(a);
        edges.b[e] = inside ? 0 : static_cast<std::int32_t>(b);
    }
    return edges;
}

AttributePlanes attribute_planes(const SetupTriangle& triangle, const vec3& w, bool linear) {
    return planes_of(triangle, {dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)}, w, linear);
}

AttributePlanes attribute_planes(const SetupTriangle& triangle, const ClippedPiece& piece, bool linear) {
    return planes_of(triangle, {piece.barycentric[0], piece.barycentric[1], piece.barycentric[2]},
                     {piece.w[0], piece.w[1], piece.w[2]}, linear);
}

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
    for (size_t i = 0; i < 4; ++i) t.x[i] -= offset.x, t.y[i] -= offset.y;
    return t;
}

SetupTriangle* SetupTriangles::grow(size_t more) {
    if (count + more > capacity) {
        capacity = std::max(count + more, 2 * capacity);
        auto larger = std::make_unique_for_overwrite<SetupTriangle[]>(capacity);
        std::copy_n(data.get(), count, larger.get());
        data = std::move(larger);
    }
    count += more;
    return data.get() + (count - more);
}

void set_up_triangles(const SetupState& state, const vec4* positions, const WindowVertex* window,
                      std::span<const uvec3> triangles, std::uint32_t first, SetupTriangles& out) {
    constexpr size_t step = Survivors::capacity / 2;
    const detail::SetupKernels& kernels = detail::setup_kernels();
    Survivors survivors;
    std::vector<PieceDepth> depths;
    const bool has_offset = state.polygon_offset.factor != 0 || state.polygon_offset.units != 0;
    const auto flush = [&] {
        SetupTriangle* added = out.grow(survivors.count);
        kernels.finish(state, survivors, added);
        for (const PieceDepth& piece : depths) set_depth(added[piece.survivor], piece.depth);
        depths.clear();
        for (size_t k = 0; has_offset && k < survivors.count; ++k) added[k].depth_offset = offset_of(state, added[k]);
        survivors.count = 0;
    };
    for (size_t i = 0; i < triangles.size();) {
        if (survivors.count + step + most_clipped_pieces > Survivors::capacity) flush();
        const size_t count = std::min(step, triangles.size() - i), before = survivors.count + survivors.empty;
        const size_t seen =
            kernels.cull(state, window, &triangles[i], count, first + static_cast<std::uint32_t>(i), false, survivors);
        out.counts.culled += static_cast<std::int64_t>(seen - (survivors.count + survivors.empty - before));
        i += seen;
        if (seen == count) continue;
        const uvec3 t = triangles[i];
        clip_triangle(state,
                      {{positions[t.x], positions[t.y], positions[t.z]}, {window[t.x], window[t.y], window[t.z]}},
                      first + static_cast<std::uint32_t>(i), survivors, depths, out);
        ++i;
    }
    flush();
}

} // namespace gnomon
