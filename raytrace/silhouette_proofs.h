#pragma once
// What silhouettes prove about which points of a light the receivers of a block see: one ray tells for a point of the
// light, the others follow by counting crossings (crossings.h).

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "raytrace/crossings.h"
#include "raytrace/embree_scene.h"
#include "raytrace/occluder_set.h"

namespace gnomon {

class SilhouetteProofs {
public:
    // `outline` is that of the block.
    SilhouetteProofs(const EmbreeScene& scene, const Light& light, Outline outline);

    // The next receiver. False where nothing can be told about it.
    bool aim(const Receiver& receiver, const Pyramid& pyramid);
    // What that has cost, in points tested against the triangles of a cluster.
    std::size_t effort() const;

    // Whether all points of the light are seen, or none, where that is certain; asks one ray.
    std::optional<bool> all_alike(const Receiver& receiver, const Pyramid& pyramid) const;

    // Which points of the packets of a block are seen, of those that face the receiver; nothing where that is not
    // certain. `trace` tells it by rays.
    using Trace = std::function<unsigned(std::size_t packet)>;
    using Seen = std::array<std::optional<unsigned>, PointBlock::packets>;
    void settle(const Receiver& receiver, const Pyramid& pyramid, const PointBlock& block,
                std::span<const std::uint16_t> facing, const Trace& trace, Seen& seen);

private:
    void ask_states(const Receiver& receiver, const Pyramid& pyramid, const BlockView& view);
    bool meets_flat(const Receiver& receiver, const Pyramid& pyramid, const PointBlock& block, std::size_t packet,
                    unsigned points);

    const EmbreeScene& scene_;
    const Light& light_;
    Outline outline_;
    OccluderSet flat_; // the outline's triangles that Embree may find beside their images
    // Of the receiver.
    bool flat_touched_ = false;
    std::vector<std::int32_t> states_;
    EdgeImages images_;
    std::vector<TriangleCluster> unclear_; // those of the outline that are not clear, and what they may hide
    std::vector<OccluderGroup> unclear_groups_;
};

} // namespace gnomon
