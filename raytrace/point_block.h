#pragma once
// Which of a light's points certain triangles hide, decided without rays, sixteen points or triangles at a time.

#include <cstdint>

#include "raytrace/occluders.h"

namespace gnomon {

// Up to 64 packets of sixteen points of the light. Bit k of a word is point k of its packet.
struct PointBlock {
    static constexpr std::size_t packets = 64, points = 16 * packets;
    alignas(64) float way[3][points];       // the rays' directions
    alignas(64) float a[points], b[points]; // their s and t
};

struct PointRange {
    float a_low, a_high, b_low, b_high; // of s and t
};

// What is certain about some points of one packet.
struct PacketVerdict {
    unsigned hidden = 0;
    unsigned possible = 0; // hidden, or perhaps hidden by some triangle
};

struct PointKernels {
    // Takes up to 64 whole packets of points: ways, s and t.
    void (*aim)(const Pyramid& pyramid, const float* x, const float* y, const float* z, std::size_t packets,
                PointBlock& block);

    // Of the points `open` of a packet; there must be some.
    PointRange (*range)(const PointBlock& block, std::size_t packet, unsigned open);

    // The numbers of the first `most` boxes that rays to a range of points can meet, into `reached`; how many there
    // are, or `most` + 1 where they are more.
    std::size_t (*reach)(const TouchedBoxes& boxes, const PointRange& range, std::size_t most, std::uint32_t* reached);

    // What one triangle of a group hides of packets, a bit for each, is added to their verdicts.
    void (*shade_packets)(const OccluderGroup& group, unsigned triangle, const PointBlock& block, std::uint64_t packets,
                          PacketVerdict* verdicts);

    // What a group hides of the points `open` of a packet, which lie in `range`, is added to the verdict.
    void (*shade)(const OccluderGroup& group, const PointBlock& block, std::size_t packet, const PointRange& range,
                  unsigned open, PacketVerdict& verdict);
};
const PointKernels& point_kernels();

} // namespace gnomon
