#pragma once
// Edges of a triangle soup, after welding vertices by position: what shadow volumes and silhouettes are made of. Any
// number of triangles may share an edge.

#include <cstdint>
#include <vector>

#include "core/scene.h"

namespace gnomon {

struct Adjacency {
    std::vector<vec3> positions;          // welded: no two are equal (−0 and +0 are the same)
    std::vector<uvec3> triangles;         // over welded positions; as many as the scene's, in its order
    std::vector<std::uint8_t> degenerate; // per triangle: 1 where two corners coincide or the area is exactly zero
    // An undirected edge, start < end as welded indices, with the triangles around it (degenerate ones left out) in
    // edge_triangles[first_triangle, first_triangle + triangle_count).
    struct Edge {
        std::uint32_t start, end;
        std::uint32_t first_triangle, triangle_count;
    };
    std::vector<Edge> edges; // sorted by (start, end)
    std::vector<std::uint32_t> edge_triangles;

    std::uint32_t boundary_edges = 0;    // one triangle
    std::uint32_t nonmanifold_edges = 0; // more than two
    std::uint32_t misoriented_edges = 0; // two, traversed in the same direction
    bool closed_manifold() const { return boundary_edges + nonmanifold_edges + misoriented_edges == 0; }
};

// O(n log n), deterministic.
Adjacency build_adjacency(const Scene& scene);

// True where two corners are equal or the cross product, evaluated in double, is zero.
bool zero_area(vec3 a, vec3 b, vec3 c);

} // namespace gnomon
