#pragma once
// The shadow casters of a scene in a shape that proofs about whole bundles of rays like: clusters of up to sixteen
// neighbouring triangles, corner by corner in arrays, under a binary tree of boxes.

#include <array>
#include <cstdint>
#include <vector>

#include "core/scene.h"

namespace gnomon {

inline constexpr std::size_t cluster_size = 16;

struct alignas(64) TriangleCluster {
    float corner[3][3][cluster_size];                 // [corner][axis][triangle]; unused places repeat the first
    std::array<std::uint32_t, cluster_size> triangle; // index into Scene::triangles
    std::uint32_t count = 0;
};

// Per edge (from corner k to the next) and place of a cluster: cluster · cluster_size + place of the triangle on the
// other side, see find_neighbours; no_neighbour where the edge is open.
inline constexpr std::uint32_t no_neighbour = 0xffffffffu;
struct ClusterNeighbours {
    std::array<std::array<std::uint32_t, cluster_size>, 3> over;
    std::uint32_t open = 0; // bit i: triangle i has an open edge
    // The other clusters that are there; a count of more than `most` stands for many.
    static constexpr std::uint32_t most = 22;
    std::uint32_t count = 0;
    std::array<std::uint32_t, most> beside;
};

struct TriangleClusters {
    vec3 shift{0.0f}; // all is in local coordinates: those of the world minus this, see local_shift
    struct Node {
        Bounds box; // of the triangles below, exactly
        // A leaf is one cluster: number `first`. Otherwise the children are nodes `first` and `first` + 1.
        std::uint32_t first = 0;
        bool leaf = false;
    };
    std::vector<Node> nodes; // the root comes first; empty where nothing casts shadows
    std::vector<TriangleCluster> clusters;
    std::vector<ClusterNeighbours> neighbours;          // per cluster
    std::size_t triangle_count = 0, open_triangles = 0; // in all, and those with an open edge
    std::vector<std::uint32_t> cluster_of; // per triangle of the scene; no meaning for those of light sources

    std::size_t memory_bytes() const {
        return nodes.size() * sizeof(Node) + clusters.size() * sizeof(TriangleCluster) +
               neighbours.size() * sizeof(ClusterNeighbours) + cluster_of.size() * sizeof(std::uint32_t);
    }
};

// Triangles of light sources are left out, as they are from EmbreeScene's casters. Throws Error where memory does not
// suffice.
TriangleClusters build_clusters(const Scene& scene);

} // namespace gnomon
