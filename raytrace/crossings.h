#pragma once
// How often rays from one point to the points of a light cross the surface of the shadow casters, but for a constant
// that is the same for all of them: the depth complexity that silhouette edges integrate to [Laine, Aila, Assarsson,
// Lehtinen, Akenine-Möller 2005, "Soft Shadow Volumes for Ray Tracing", section 4]. Where that is least, one ray tells
// whether it is 0.
//
// Exactly: clear triangles (silhouettes.h) count 1, by the side that they show, all others 0. The images of the former,
// all turned the same way round, are bounded by the edges beside which states differ, each as often as they do: the
// count changes there and nowhere else. From the lower left corner of the light's surroundings a path leads up their
// left side and from there to the right to every point; what it crosses is summed up. Images of the same corner are the
// same numbers in all edges, and ranges are half-open, so that paths that come near a corner cross the edges there as
// they do the lines through the numbers. These lines are off the true ones by rounding: the count of points that lie as
// near to an edge is *unsure*. Elsewhere it is certain that rays meet what is counted; where the count is 0 they meet
// nothing that is clear but near edges: see silhouette_near and silhouette_close.

#include <cstdint>
#include <vector>

#include "raytrace/point_block.h"
#include "raytrace/silhouettes.h"

namespace gnomon {

// Images of the edges beside which states differ, those that come near the light; upward: t_from ≤ t_to. Of points
// right of the edge a·s + b·t + c is positive, further than `margin` from 0 where that is certain. Corners are off by
// less than `wrong`.
struct EdgeImages {
    std::vector<float> s_from, t_from, s_to, t_to, a, b, c, margin, wrong;
    std::vector<std::int32_t> step; // what the count changes by from left to right
    std::size_t count = 0;
    void resize(std::size_t room);
};

// The points of a block where they are images like those of corners, and what edges tell about them.
struct PointCounts {
    alignas(64) float s[PointBlock::points], t[PointBlock::points];
    alignas(64) std::int32_t crossings[PointBlock::points];
    // Per packet: ranges of s and t, and bits of points.
    alignas(64) float s_low[PointBlock::packets], s_high[PointBlock::packets];
    alignas(64) float t_low[PointBlock::packets], t_high[PointBlock::packets];
    std::uint16_t near[PointBlock::packets], close[PointBlock::packets], unsure[PointBlock::packets];
};

struct CrossingKernels {
    // `states` by the outline's numbers of triangles. False where an edge has no image.
    bool (*project)(const Pyramid& pyramid, const Outline& outline, const std::int32_t* states, EdgeImages& images);

    void (*count)(const Pyramid& pyramid, const EdgeImages& images, const PointBlock& block, std::size_t packets,
                  PointCounts& counts);

    // What groups hide of packets, a bit for each, is added to their verdicts.
    void (*shade)(const std::vector<OccluderGroup>& groups, const PointBlock& block, const PointCounts& counts,
                  std::uint64_t packets, PacketVerdict* verdicts);

    // The least count of the points `eligible`, a word for each packet, of which there must be some.
    std::int32_t (*least)(const PointCounts& counts, const std::uint16_t* eligible, std::size_t packets);

    // Which points of a packet have a count above the value, and which have that.
    unsigned (*above)(const PointCounts& counts, std::size_t packet, std::int32_t value, unsigned& equal);
};
const CrossingKernels& crossing_kernels();

} // namespace gnomon
