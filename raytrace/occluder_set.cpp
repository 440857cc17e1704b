#include "raytrace/occluder_set.h"

#include <utility>

namespace gnomon {

OccluderSet::OccluderSet(const std::vector<TriangleCluster>& clusters, ClusterList list)
    : all_(&clusters), list_(std::move(list)) {
    touched_.resize(size());
    group_of_.resize(size());
}

const TouchedBoxes& OccluderSet::touch(const Pyramid& pyramid) {
    occluder_kernels().touch(pyramid, list_.boxes(), touched_);
    return touched_;
}

const OccluderGroup& OccluderSet::group(const Pyramid& pyramid, std::uint32_t own, std::uint32_t box, bool& made) {
    std::uint32_t& place = group_of_[box];
    made = place >= groups_used_ || box_of_[place] != box;
    if (!made) return groups_[place];
    place = static_cast<std::uint32_t>(groups_used_++);
    if (groups_.size() < groups_used_) groups_.resize(groups_used_ + 15), box_of_.resize(groups_used_ + 15);
    box_of_[place] = box;
    occluder_kernels().project(pyramid, (*all_)[list_.clusters[box]], own, groups_[place]);
    return groups_[place];
}

} // namespace gnomon
