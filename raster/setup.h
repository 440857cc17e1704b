#pragma once
// From clip-space triangles to set-up triangles: clipping, viewport, snapping, culling, edge functions and planes. One
// documented order of evaluation each, so that the same triangle gives the same bits in any submission order, winding,
// tile or thread.
//
//  1. Clip in homogeneous space, in double, against near and far (unless depth clamp) and a guard band of 16384 pixels
//     around the viewport's centre (clip.h). The polygon is split into a fan from its smallest original vertex.
//  2. oow = 1/w; window x = x·oow·(width/2) + (left + width/2), y alike, z = z·oow·½ + ½ (or z·oow), in float32.
//  3. x and y are snapped to 1/256 pixel, round to nearest even. Facing, zero area, "off the target" and "no pixel
//     centre inside the box" are decided on the snapped coordinates.
//  4. Edge functions are exact integers; a pixel centre is inside where all three are ≥ 0 after the fill rule's −1 on
//     exclusive edges (left and bottom edges include their points).
//  5. Every plane f(x, y) is anchored at the vertex that is smallest by (x, y) and evaluated in double as
//     (f0 + fy·(y − y0)) + fx·(x − x0). The depth of a triangle that is clipped is the plane through its own corners,
//     snapped where they need no clipping and exact where they do, and not through the cuts.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/math.h"
#include "raster/format.h"
#include "raster/state.h"

namespace gnomon {

inline constexpr double subpixels = 256.0;

struct Plane {
    double value, dx, dy; // at the triangle's anchor, and per pixel
};

// Small: at most 64 pixels wide and high before any box cut it, so that edge functions around it fit 32 bits, and
// floats. SmallCut: small, but its edges alone do not tell what is inside: the target's or scissor's edge cuts it, or
// it is drawn conservatively.
enum class Extent : std::uint8_t { Large, SmallCut, Small };

struct SetupTriangle {
    std::int32_t x[4], y[4]; // snapped corners in 1/256 pixel, counter-clockwise from the anchor; [3] is [0] again
    float depth;             // window depth at the anchor
    float depth_minimum, depth_maximum; // of the corners: depth is clamped to them
    std::uint32_t primitive;            // index in the draw
    double depth_dx, depth_dy;          // per pixel
    double depth_offset;
    std::uint16_t x0, y0, x1, y1; // pixels whose centres may be covered, inclusive, inside viewport, scissor and target
    std::uint32_t piece;          // which piece of clipped triangles, or whole
    std::uint8_t first;           // which submitted corner is the anchor; of a piece: of its own corners
    bool reversed : 1;            // the corners run against the order of submission
    bool front : 1;
    bool steady : 1; // float32 depths at the pixel centres inside it need no clamp to those of the corners
    Extent extent;

    static constexpr std::uint32_t whole = 0xffffffffu;

    // Which submitted corner stands at place k.
    size_t corner(size_t k) const {
        const size_t place = first + (reversed ? 3 - k : k); // at most 5
        return place < 3 ? place : place - 3;
    }
    double anchor_x() const { return x[0] * (1.0 / subpixels); } // pixels
    double anchor_y() const { return y[0] * (1.0 / subpixels); }
    double evaluate(const Plane& plane, int px, int py) const {
        return (plane.value + plane.dy * ((py + 0.5) - anchor_y())) + plane.dx * ((px + 0.5) - anchor_x());
    }
};

inline constexpr int tile_shift = 6;
inline constexpr int tile_side = 1 << tile_shift; // pixels: every edge function that crosses a tile fits 32 bits

// The three edge functions rebased to a tile: ⌊E/256⌋ at its lower left pixel, stepping by a and b per pixel. Pixel
// centres are 256 apart, so the remainder is the same everywhere and the sign of the floor is the sign of E. An edge
// with the whole tile inside is replaced by zeros (always ≥ 0); the values of all others fit 32 bits within the tile.
struct TileEdges {
    std::int32_t base[3], a[3], b[3];
    bool empty = false, crossed = false; // the tile lies outside of an edge; on both sides of one
};
TileEdges tile_edges(const SetupTriangle& triangle, bool conservative, int tile_x, int tile_y);

// What interpolation needs, as planes: 1/w, the second and third barycentric coordinate over w (perspective), and the
// two as they are (linear in the window).
struct AttributePlanes {
    alignas(32) double value[4], dx[4], dy[4]; // the first three, as they fit a vector; the fourth is none
    double anchor_x, anchor_y;                 // the triangle's
    Plane second_linear, third_linear;

    void set(size_t i, const Plane& p) { value[i] = p.value, dx[i] = p.dx, dy[i] = p.dy; }
    Plane inverse_w() const { return {value[0], dx[0], dy[0]}; }
    Plane second() const { return {value[1], dx[1], dy[1]}; }
    Plane third() const { return {value[2], dx[2], dy[2]}; }
};

// A triangle cut from a clipped one: its corners' barycentric coordinates in the submitted triangle, and their w.
struct ClippedPiece {
    dvec3 barycentric[3];
    float w[3];
};

// Of a whole triangle, from the w of its corners in the order of submission; of a piece, from what it carries. The
// linear planes are made where `linear` asks for them.
AttributePlanes attribute_planes(const SetupTriangle& triangle, const vec3& w, bool linear);
AttributePlanes attribute_planes(const SetupTriangle& triangle, const ClippedPiece& piece, bool linear);

// Sample positions in 1/256 pixel from the pixel's lower left corner, in the targets' memory order. [Vulkan 1.3, 25.3
// "Standard sample locations"; D3D11.3 19.2.4.1]
std::span<const glm::ivec2> sample_positions(int samples);

// The triangle as one sample sees it: moved so that pixel centres stand for the sample.
SetupTriangle seen_by_sample(SetupTriangle triangle, glm::ivec2 position);

struct SetupCounts {
    std::int64_t clipped = 0, culled = 0;
};

inline constexpr std::size_t most_clipped_pieces = 7; // of one triangle

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
    bool attributes;     // pieces are kept
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

// Set-up triangles in order of submission. Memory is kept from one use to the next.
struct SetupTriangles {
    std::unique_ptr<SetupTriangle[]> data;
    size_t count = 0, capacity = 0;
    std::vector<ClippedPiece> pieces;
    SetupCounts counts;

    SetupTriangle* grow(size_t more); // room for them, uninitialized
    void clear() {
        count = 0;
        pieces.clear();
        counts = {};
    }
};

// Appends the set-up triangles of `triangles`, the first of which is primitive `first` of the draw: for each none, one,
// or a fan where it is clipped.
void set_up_triangles(const SetupState& state, const vec4* positions, const WindowVertex* window,
                      std::span<const uvec3> triangles, std::uint32_t first, SetupTriangles& out);

} // namespace gnomon
