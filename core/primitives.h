#pragma once
// Meshes of simple shapes: closed ones are wound outwards and watertight once welded by position (core/adjacency.h).
// Sizes in metres, counts are those of faces around or along. Smooth shapes carry normals, flat ones do not.

#include <cstdint>
#include <span>

#include "core/scene.h"

namespace gnomon {

// A sheet in y = 0 around the origin, facing +y.
MeshData plane_mesh(vec2 size, int segments_x = 1, int segments_z = 1);
MeshData box_mesh(vec3 minimum, vec3 maximum);
MeshData sphere_mesh(float radius, int slices, int stacks);
// Stands on y = 0 around the y axis, with caps; a radius of 0 makes a cone.
MeshData cylinder_mesh(float bottom_radius, float top_radius, float height, int segments);
// Around the y axis; `radius` to the middle of the tube.
MeshData torus_mesh(float radius, float tube_radius, int segments, int sides);
// A round tube along a polyline with flat caps; one radius per point. Consecutive points must differ.
MeshData tube_mesh(std::span<const vec3> points, std::span<const float> radii, int sides);
MeshData rod_mesh(vec3 from, vec3 to, float radius, int sides);
// A sheet as plane_mesh, raised by seeded smooth noise to heights in [0, height].
MeshData grid_mesh(vec2 size, int segments, float height, float bump_size, std::uint32_t seed);

// Appends a mesh to another, transformed; normals are kept only where both have them.
void append_mesh(MeshData& mesh, const MeshData& part, const dmat4& transform = dmat4(1.0));

// Smooth noise in [0, 1]: bicubically faded values at the integer lattice.
float value_noise(vec2 p, std::uint32_t seed);

// Transforms for host code.
dmat4 translation(dvec3 offset);
dmat4 rotation(double degrees, dvec3 axis);
dmat4 scaling(dvec3 factors);

} // namespace gnomon
