#pragma once
// Which triangles of a surface share an edge, by where they are and not by how they are indexed: corners are the same
// where their coordinates are, so that a seam with its vertices twice is closed and a mesh's numbering does not matter.

#include <array>
#include <cstdint>
#include <vector>

#include "raytrace/triangle_clusters.h"

namespace gnomon {

// The neighbours of the triangles in the clusters, place by place; unused places have none. An edge joins two triangles
// where they and no others have it, in opposite directions: the surface then goes on there with the same side up. Every
// other edge is open. Throws std::bad_alloc where memory does not suffice: 16 bytes an edge are needed on the way.
std::vector<ClusterNeighbours> find_neighbours(const std::vector<TriangleCluster>& clusters);

} // namespace gnomon
