#pragma once
// The space between a box of shadow ray origins and the box of an area light [Haines and Wallace 1994, "Shaft Culling
// for Efficient Ray-Traced Radiosity", section 3]: what lies outside is in nobody's way.

#include <array>
#include <optional>
#include <vector>

#include "raytrace/occluders.h"

namespace gnomon {

struct Shaft {
    Bounds hull; // of both boxes
    // A point p inside has normal·p ≤ offset for each.
    struct Plane {
        dvec3 normal;
        double offset;
    };
    std::vector<Plane> planes; // at most twelve
};

// Keeps proof_growth away from both boxes.
Shaft shaft_between(const Bounds& origins, const Bounds& light);

// Clusters of triangles that a shaft touches, with their boxes, grown and padded for OccluderKernels::touch.
struct ClusterList {
    std::vector<std::uint32_t> clusters;
    std::array<std::vector<float>, 3> minimum, maximum;
    void add(std::uint32_t cluster, const Bounds& grown);
    void pad(); // after the last one
    BoxArrays boxes() const;
};

// The box, proof_growth of its largest coordinate larger on each side.
Bounds grown_box(const Bounds& box);

// The clusters that a shaft touches, found by and by.
class ClusterSearch {
public:
    ClusterSearch(Shaft shaft, const TriangleClusters& all);
    // Goes on until there are `most`, and tells whether these are all.
    bool find(std::size_t most);
    const std::vector<std::uint32_t>& found() const { return list_.clusters; }
    ClusterList take(); // padded; of no more use then

private:
    Shaft shaft_;
    const TriangleClusters& all_;
    ClusterList list_;
    std::vector<std::uint32_t> open_; // nodes
};

// Nothing where the shaft touches more than `most` clusters.
std::optional<ClusterList> clusters_in(const Shaft& shaft, const TriangleClusters& all, std::size_t most);

} // namespace gnomon
