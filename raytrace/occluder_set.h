#pragma once
// Clusters of triangles around a block's rays, and what they may hide from one receiver at a time; worked out where it
// is asked for.

#include <cstdint>
#include <vector>

#include "raytrace/occluders.h"
#include "raytrace/shaft.h"

namespace gnomon {

class OccluderSet {
public:
    // `list` names some of the clusters, which must outlive this.
    OccluderSet() = default;
    OccluderSet(const std::vector<TriangleCluster>& clusters, ClusterList list);

    std::size_t size() const { return list_.clusters.size(); }
    // Numbers of clusters; places in it are the boxes of the rest.
    const std::vector<std::uint32_t>& clusters() const { return list_.clusters; }

    // The next receiver; nothing is known about it until touch(). Its own triangle hides nothing.
    void forget() { touched_.count = 0, groups_used_ = 0; }
    const TouchedBoxes& touch(const Pyramid& pyramid);
    const TouchedBoxes& touched() const { return touched_; }

    // What the triangles in a box may hide; `made` tells whether that had to be worked out.
    const OccluderGroup& group(const Pyramid& pyramid, std::uint32_t own, std::uint32_t box, bool& made);

private:
    const std::vector<TriangleCluster>* all_ = nullptr;
    ClusterList list_;
    TouchedBoxes touched_;
    std::vector<OccluderGroup> groups_; // worked out so far
    std::size_t groups_used_ = 0;
    std::vector<std::uint32_t> group_of_; // per box: its place in groups_, if that is this box's
    std::vector<std::uint32_t> box_of_;   // per place
};

} // namespace gnomon
