#pragma once
// Where on a light the answer can change at all. From one point, rays cross the surface of the shadow casters equally
// often in the whole of a connected part of the light, unless in that part lies the image of an edge at which the
// surface ends or turns away: an open edge or a silhouette [Laine, Aila, Assarsson, Lehtinen, Akenine-Möller 2005,
// "Soft Shadow Volumes for Ray Tracing", section 3]. This file finds these edges for a block of receivers; crossings.h
// counts for each what rays cross.
//
// P is where rays start. A triangle is *clear* where
// - P is on a certain side of its plane, so that rays cross it in one direction;
// - it is off P, and off where rays end, by more than Embree's distances are wrong, so that hits are neither lost nor
//   found before the start and beyond the end, and none is left behind (see false_hits.h);
// - it is met, according to Embree, by rays only that pass its image by less than silhouette_near in s and t. Embree's
//   three edge functions are U_k = det(v_i, v_j, d) with v the corners seen from P, each off by less than a margin μ.
//   With V = det(v_0, v_1, v_2) and h_k the height of corner k between P (0) and the light (1), the point of the light
//   is Σ w_k q_k with q_k the corners' images, w_k = U_k h_k / V and Σ w_k = 1. Where all U_k have V's sign but for μ,
//   no w_k is below −ω = −μ h / |V|, with h the largest height; at most two are negative, so that the point is off the
//   image by less than 2 ω of its size. Where all have the other sign but for μ, ω is above 1/3.
//
// So where rays truly cross clear triangles Embree meets one, unless they pass as near to an edge at which the clear
// surface ends or turns as rounding reaches. And where they cross none Embree meets no clear triangle, unless there is
// such an edge within silhouette_near, since the way from there to the triangle leads over one; within silhouette_close
// where the triangle is not *flat*, that is, not seen nearly edge-on. Triangles that are not clear are asked by what
// Embree may find (OccluderKernels::project), whatever their shape; so are flat ones near edges.
//
// The receiver's own triangle hides nothing and is never clear.
//
// One thing is taken for granted: that Embree's robust mode is watertight where it should be, so that a ray that
// crosses a surface of clear triangles hits one of them also where it passes within rounding of edges and corners. Two
// triangles that share an edge do evaluate the same function for it, up to the sign.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/light.h"
#include "raytrace/occluders.h"
#include "raytrace/point_block.h"
#include "raytrace/shaft.h"

namespace gnomon {

// How far from its image Embree may find a clear triangle, in s and t, and one that is not flat. The former is half of
// what the light's surroundings, where edges are known, reach beyond it by.
inline constexpr float silhouette_near = 0x1p-8f;
inline constexpr float silhouette_close = 0x1p-11f;
static_assert(light_growth >= 1.0f + 4 * silhouette_near);

// What is known of the rays of a block of receivers. Lengths in metres, everything relative to `center`.
struct BlockView {
    vec3 center, half;          // of the box of origins
    vec3 light, axis_a, axis_b; // the light's points are light + s·axis_a + t·axis_b, s and t in [−1, 1]
    vec3 up;                    // unit normal of the light's plane, away from the origins
    float nearest, farthest;    // from an origin to that plane
    float reach;                // above the length of any ray
    float size;                 // of the light: the shorter one of its half axes
    float end;                  // rays end there or later, as a part of the way
    float off_plane;            // an origin farther than this from a plane is off it for is_left_behind()
    bool usable = false;
};

// `rounding` bounds that of the origins. Not usable for mesh and sphere lights, and where origins come near the light's
// plane.
BlockView block_view(const Light& light, const Bounds& origins, float rounding);

// Triangles and edges that matter for a block of receivers. A triangle's *state* is how often it counts where rays
// cross it, by the side that it shows: 1 where along its normal, −1 where against, 0 where it is not clear.
struct Outline {
    // Whose states differ between the receivers, or are not known for the block; number cluster_size · cluster + place.
    std::vector<TriangleCluster> triangles;
    // After their numbers come one that stands for 1, one for −1 and one for 0.
    std::int32_t first_constant() const { return static_cast<std::int32_t>(cluster_size * triangles.size()); }
    // Edges beside which states may differ, as arrays padded to whole sixteens with edges between equals: their ends,
    // and the numbers of the triangles that have them in this direction and in the opposite one.
    std::vector<float> from[3], to[3];
    std::vector<std::int32_t> along, against;
    std::size_t edges = 0;
    // Triangles that may be flat.
    std::vector<TriangleCluster> flat;
    ClusterList flat_boxes; // whose clusters are numbers into `flat`
};

// What a block's view tells of a cluster's triangles: bit i is triangle i. A bit of `positive` or `negative`: every ray
// of the block that crosses it does so along, or against, its normal.
struct ClusterSides {
    std::uint16_t positive = 0, negative = 0;
    std::uint16_t clear = 0;
    std::uint16_t steep = 0;  // clear and not flat
    std::uint16_t absent = 0; // no ray can meet it
};

struct SilhouetteKernels {
    // Where `states` is not null it is filled with the triangles' states.
    ClusterSides (*sides)(const BlockView& view, const TriangleCluster& cluster, std::int32_t* states);
};
const SilhouetteKernels& silhouette_kernels();

// Adds the triangles `wanted` of a cluster to others, which are filled up.
void add_triangles(const TriangleCluster& from, unsigned wanted, std::vector<TriangleCluster>& to);

// Whether a sixteenth of the clusters says that the states of far more than `most` triangles have to be asked.
bool too_many_unknown(const BlockView& view, const TriangleClusters& all, std::span<const std::uint32_t> nearby,
                      std::size_t most);

// `nearby` are the clusters that a shaft around the block's rays touches. Nothing where there would be more than `most`
// triangles whose states have to be asked.
std::optional<Outline> find_outline(const BlockView& view, const TriangleClusters& all,
                                    std::span<const std::uint32_t> nearby, std::size_t most);

} // namespace gnomon
