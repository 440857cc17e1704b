#include "raytrace/shaft.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gnomon {
namespace {

Bounds grown(const Bounds& box, float magnitude) {
    const vec3 growth(proof_growth * magnitude);
    return {box.minimum - growth, box.maximum + growth};
}

float largest_coordinate(const Bounds& box) {
    const vec3 size = glm::max(glm::abs(box.minimum), glm::abs(box.maximum));
    return std::max({size.x, size.y, size.z});
}

bool apart(const Bounds& a, const Bounds& b) {
    return glm::any(glm::lessThan(a.maximum, b.minimum)) || glm::any(glm::lessThan(b.maximum, a.minimum));
}

// In double: what this rounds is nothing beside the growth.
bool touches(const Shaft& shaft, const Bounds& box) {
    if (apart(shaft.hull, box)) return false;
    const dvec3 minimum(box.minimum), maximum(box.maximum);
    for (const Shaft::Plane& plane : shaft.planes) {
        double nearest = 0.0;
        for (int i = 0; i < 3; ++i) nearest += plane.normal[i] * (plane.normal[i] > 0.0 ? minimum[i] : maximum[i]);
        if (nearest > plane.offset) return false;
    }
    return true;
}

} // namespace

// Seen along each axis the hull of two rectangles has, beside their own sides, up to four edges that join equal
// corners: those where one box reaches farther in one coordinate and the other box in the other.
Shaft shaft_between(const Bounds& origins, const Bounds& light) {
    const float magnitude = std::max(largest_coordinate(origins), largest_coordinate(light));
    const Bounds from = grown(origins, magnitude), to = grown(light, magnitude);
    Shaft shaft;
    for (const Bounds* box : {&from, &to}) shaft.hull.extend(box->minimum), shaft.hull.extend(box->maximum);
    for (int axis = 0; axis < 3; ++axis) {
        const int i = (axis + 1) % 3, j = (axis + 2) % 3;
        for (int corner = 0; corner < 4; ++corner) {
            const bool high_i = corner & 1, high_j = corner & 2;
            const auto at = [&](const Bounds& box) {
                return dvec2((high_i ? box.maximum : box.minimum)[i], (high_j ? box.maximum : box.minimum)[j]);
            };
            const dvec2 start = at(from), way = at(to) - start;
            const dvec2 outward(high_i ? 1.0 : -1.0, high_j ? 1.0 : -1.0);
            if (!(way.x * outward.x * way.y * outward.y < 0.0)) continue;
            dvec3 normal(0.0);
            normal[i] = outward.x * std::abs(way.y), normal[j] = outward.y * std::abs(way.x);
            shaft.planes.push_back({normal, normal[i] * start.x + normal[j] * start.y});
        }
    }
    return shaft;
}

void ClusterList::add(std::uint32_t cluster, const Bounds& grown) {
    clusters.push_back(cluster);
    for (int i = 0; i < 3; ++i) {
        const auto axis = static_cast<std::size_t>(i);
        minimum[axis].push_back(grown.minimum[i]), maximum[axis].push_back(grown.maximum[i]);
    }
}

// Inside out: nothing touches such a box.
void ClusterList::pad() {
    const std::size_t padded = (clusters.size() + 15) / 16 * 16;
    for (std::vector<float>& values : minimum) values.resize(padded, 1e30f);
    for (std::vector<float>& values : maximum) values.resize(padded, -1e30f);
}

BoxArrays ClusterList::boxes() const {
    return {{minimum[0].data(), minimum[1].data(), minimum[2].data()},
            {maximum[0].data(), maximum[1].data(), maximum[2].data()},
            minimum[0].size()};
}

Bounds grown_box(const Bounds& box) { return grown(box, largest_coordinate(box)); }

ClusterSearch::ClusterSearch(Shaft shaft, const TriangleClusters& all) : shaft_(std::move(shaft)), all_(all) {
    if (!all.nodes.empty()) open_.push_back(0);
}

bool ClusterSearch::find(std::size_t most) {
    while (!open_.empty()) {
        const TriangleClusters::Node& node = all_.nodes[open_.back()];
        const Bounds box = grown_box(node.box);
        const bool touched = touches(shaft_, box);
        if (touched && node.leaf && list_.clusters.size() == most) return false;
        open_.pop_back();
        if (!touched) continue;
        if (node.leaf)
            list_.add(node.first, box);
        else
            open_.insert(open_.end(), {node.first + 1, node.first});
    }
    return true;
}

ClusterList ClusterSearch::take() {
    list_.pad();
    return std::move(list_);
}

std::optional<ClusterList> clusters_in(const Shaft& shaft, const TriangleClusters& all, std::size_t most) {
    ClusterSearch search(shaft, all);
    if (!search.find(most)) return std::nullopt;
    return search.take();
}

} // namespace gnomon
