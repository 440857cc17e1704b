#pragma once
// Which triangles may hide which part of a light, decided without rays, sixteen triangles or boxes at a time. Every
// decision is about Embree's answer: its ray-triangle test is a sign test of three edge functions and a depth
// test, all linear in the ray's direction, so that bounds of their rounding tell hits and misses that are certain.

#include <cstdint>
#include <vector>

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
    // Rays that may hit it pass inside where all edge functions are positive, or where all are negative; both bits
    // where the apex is too near to its plane to tell.
    unsigned positive = 0, negative = 0;
    unsigned nearer = 0; // it is certainly nearer than the light, from wherever its ray comes
    bool hides_all = false;
};

// Boxes as arrays, padded to whole sixteens with boxes that nothing touches.
struct BoxArrays {
    const float* minimum[3];
    const float* maximum[3];
    std::size_t count;
};

// Boxes that the pyramid may touch: their numbers, and ranges of s and t of the points that rays through them can
// reach. Padded to whole sixteens with boxes that nothing can reach.
struct TouchedBoxes {
    std::vector<std::uint32_t> box;
    std::vector<float> a_low, a_high, b_low, b_high;
    std::size_t count = 0;
    void resize(std::size_t room) {
        box.resize(room + 16);
        for (std::vector<float>* range : {&a_low, &a_high, &b_low, &b_high}) range->resize(room + 16);
    }
};

struct OccluderKernels {
    // The boxes that the pyramid may touch, into `touched`, which has room for all.
    void (*touch)(const Pyramid& pyramid, const BoxArrays& boxes, TouchedBoxes& touched);

    // What the triangles of a cluster may hide; triangle `own` hides nothing.
    void (*project)(const Pyramid& pyramid, const TriangleCluster& cluster, std::uint32_t own, OccluderGroup& group);
};
const OccluderKernels& occluder_kernels();

} // namespace gnomon
