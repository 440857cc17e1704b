#pragma once
// Which of a light's points are hidden by which triangles, decided without rays, sixteen triangles or points at a time.
// Every decision is about Embree's answer: its ray-triangle test is a sign test of three edge functions and a depth
// test, all linear in the ray's direction, so that bounds of their rounding tell hits and misses that are certain.

#include <cstdint>

#include "raytrace/pyramid.h"
#include "raytrace/triangle_clusters.h"

namespace gnomon {

// The triangles of a cluster that may hide a part of the light. Arrays have one entry for each triangle of the cluster.
struct OccluderGroup {
    // A ray of direction d passes inside edge k where the sign of edge[k]·d is that of the other two; beyond ±margin
    // the sign is what Embree finds.
    alignas(64) float edge[3][3][cluster_size];
    alignas(64) float margin[cluster_size];
    // Only points of the light with s and t in these ranges can be hidden by it.
    alignas(64) float a_low[cluster_size], a_high[cluster_size], b_low[cluster_size], b_high[cluster_size];
    unsigned present = 0; // bit i: triangle i may hide something; the others' entries have no meaning
    unsigned nearer = 0;  // it is certainly nearer than the light, from wherever its ray comes
    bool hides_all = false;
};

// Boxes as arrays, padded to whole sixteens with boxes that nothing touches.
struct BoxArrays {
    const float* minimum[3];
    const float* maximum[3];
    std::size_t count;
};

// Up to 64 packets of sixteen points of the light. Bit k of a word is point k of its packet.
struct PointBlock {
    static constexpr std::size_t packets = 64, points = 16 * packets;
    alignas(64) float way[3][points];                  // the rays' directions
    alignas(64) float a[points], b[points];            // their s and t
    alignas(64) float a_low[packets], a_high[packets]; // range of s of a packet
    alignas(64) float b_low[packets], b_high[packets]; // range of t
    std::uint16_t facing[packets];                     // above the receiver's horizon: others need no answer
    std::uint16_t hidden[packets];                     // certainly
    std::uint16_t possible[packets];                   // hidden, or perhaps hidden by some triangle
    std::uint64_t open;                                // bit k: not all of packet k that faces is hidden yet
};

// Points of a block.
struct ReachedPoints {
    std::uint64_t packets = 0; // bit k: some points of packet k
    std::uint16_t points[PointBlock::packets];
};

// A box that the pyramid may touch: its number, and the points of the light that rays through it can reach.
struct TouchedBox {
    std::uint32_t box;
    float a_low, a_high, b_low, b_high;
};

struct OccluderKernels {
    // The boxes that the pyramid may touch, into `touched`, which has room for all; how many.
    std::size_t (*touch)(const Pyramid& pyramid, const BoxArrays& boxes, TouchedBox* touched);

    // What the triangles of a cluster may hide; triangle `own` hides nothing. Ranges are left out where they are not
    // asked for, and then the group may hold triangles beside the light.
    void (*project)(const Pyramid& pyramid, const TriangleCluster& cluster, std::uint32_t own, bool ranges,
                    OccluderGroup& group);

    // Takes up to 64 whole packets of points: ways and ranges. `facing` has to be set; all that faces is open.
    void (*aim)(const Pyramid& pyramid, const float* x, const float* y, const float* z, std::size_t packets,
                PointBlock& block);

    // The open points that a box's rays can reach, and how many they are.
    std::size_t (*reach)(const TouchedBox& box, const PointBlock& block, ReachedPoints& reached);

    // Adds what a group hides of the reached points: triangle by triangle, for which it needs ranges, or point by
    // point. The former suits large triangles, the latter many small ones.
    void (*shade_triangles)(const OccluderGroup& group, const ReachedPoints& reached, PointBlock& block);
    void (*shade_points)(const OccluderGroup& group, const ReachedPoints& reached, PointBlock& block);
};
const OccluderKernels& occluder_kernels();

} // namespace gnomon
