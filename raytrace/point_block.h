#pragma once
// Which of a light's points certain triangles hide, decided without rays, sixteen points or triangles at a time.

#include <cstdint>

#include "raytrace/occluders.h"

namespace gnomon {

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

struct PointKernels {
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
const PointKernels& point_kernels();

} // namespace gnomon
