#pragma once
// From clip-space triangles to set-up triangles: clipping, viewport, snapping, culling, edge functions and planes. One
// documented order of evaluation each, so that the same triangle gives the same bits in any submission order, winding,
// tile or thread.
//
//  1. Clip in homogeneous space, in double, against near and far (unless depth clamp) and a guard band of 16384 pixels
//  around
//     the viewport's centre; each cut runs from the lexicographically smaller end point, so two triangles cut a shared
//     edge at the same vertex. The polygon is split into a fan from its smallest original vertex.
//  2. oow = 1/w; window x = x·oow·(width/2) + (left + width/2), y alike, z = z·oow·½ + ½ (or z·oow), in float32.
//  3. x and y are snapped to 1/256 pixel, round to nearest even. Facing, zero area, "off the target" and "no pixel
//  centre inside the
//     box" are decided on the snapped coordinates.
//  4. Edge functions are exact integers; a pixel centre is inside where all three are ≥ 0 after the fill rule's −1 on
//     exclusive edges (left and bottom edges include their points).
//  5. Every plane f(x, y) is anchored at the vertex that is smallest by (x, y) and evaluated in double as
//     (f0 + fy·(y − y0)) + fx·(x − x0).

#include <cstdint>
#include <span>
#include <vector>

#include "core/math.h"
#include "raster/format.h"
#include "raster/state.h"

namespace gnomon {

struct Plane {
    double value, dx, dy; // at the triangle's anchor, and per pixel
};

struct SetupTriangle {
    std::int64_t a[3], b[3], c[3]; // E = a·x + b·y + c in 1/256 pixels, counter-clockwise, fill rule included in c
    double anchor_x, anchor_y;     // pixels
    Plane depth;
    double depth_minimum, depth_maximum; // of the snapped vertices: depth is clamped to them
    double depth_offset;
    std::int32_t x0, y0, x1, y1; // pixels whose centres may be covered, inclusive, inside viewport, scissor and target
    std::uint32_t primitive;     // index in the draw
    bool front;

    double evaluate(const Plane& plane, int x, int y) const {
        return (plane.value + plane.dy * ((y + 0.5) - anchor_y)) + plane.dx * ((x + 0.5) - anchor_x);
    }
};

// What interpolation needs, as planes: 1/w, the second and third barycentric coordinate over w (perspective), and the
// two as they are (linear in the window).
struct AttributePlanes {
    Plane inverse_w, second, third, second_linear, third_linear;
};

// Sample positions in 1/256 pixel from the pixel's lower left corner, in the targets' memory order. [Vulkan 1.3, 25.3
// "Standard sample locations"; D3D11.3 19.2.4.1]
std::span<const glm::ivec2> sample_positions(int samples);

// The triangle as one sample sees it: moved so that pixel centres stand for the sample.
SetupTriangle seen_by_sample(SetupTriangle triangle, glm::ivec2 position);

struct SetupCounts {
    std::int64_t clipped = 0, culled = 0;
};

// The parts of a draw that set-up depends on.
struct SetupState {
    Rectangle viewport;
    Rectangle drawable; // viewport ∩ scissor ∩ target
    Cull cull;
    FrontFace front_face;
    ClipDepth clip_depth;
    bool depth_clamp;
    PolygonOffset polygon_offset;
    Format depth_format; // decides the unit of the polygon offset
    bool attributes;
    bool conservative;
    bool multisampled; // boxes hold every pixel with a sample inside, not only centres
};

// A vertex on the target: snapped position and depth, and which planes it lies outside of. Made once a vertex, used by
// all of its triangles.
struct WindowVertex {
    std::int32_t x, y; // 1/256 pixels; meaningless where the vertex needs clipping
    float z;
    std::uint32_t flags; // outside_* and needs_clip
};
inline constexpr std::uint32_t outside_mask = 63; // one bit for each of the six frustum planes
inline constexpr std::uint32_t needs_clip = 64;   // beyond near or far (unless depth clamp), or beyond the guard band

WindowVertex to_window(const SetupState& state, const vec4& clip_position);

// Appends the set-up triangles of the triangle `index` over the vertices: none, one, or a fan where it is clipped.
// `attributes` grows in step where the state asks for it.
void set_up_triangle(const SetupState& state, const vec4* positions, const WindowVertex* window, const uvec3& index,
                     std::uint32_t primitive, std::vector<SetupTriangle>& triangles,
                     std::vector<AttributePlanes>& attributes, SetupCounts& counts);

} // namespace gnomon
