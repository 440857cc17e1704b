#pragma once
// Clipping in homogeneous space, for the few triangles that need it.

#include <array>
#include <cstddef>

#include "core/math.h"

namespace gnomon {

struct SetupState;

// A vertex on its way: clip position, and its barycentric coordinates in the submitted triangle.
struct ClipVertex {
    vec4 position;
    dvec3 barycentric;
};

struct ClippedPolygon {
    int count = 0;                     // 0 where nothing is left
    bool mirrored = false;             // the corners run against the order of submission
    std::array<std::size_t, 3> order;  // of the submitted corners, by their positions
    std::array<ClipVertex, 9> corners; // 3, and at most one more for each of 6 planes
};

// Half the side of the guard band, in pixels around the viewport's centre.
inline constexpr double guard_band_pixels = 16384.0;

// Cuts the triangle at near and far (unless depth clamp) and at the guard band, in double. The corners are taken in an
// order of their own, and each cut runs from the lexicographically smaller end point, so that neither winding nor first
// vertex matters and two triangles cut a shared edge at the same vertex. A triangle with a coordinate that is not
// finite is dropped.
ClippedPolygon clip(const SetupState& state, const std::array<vec4, 3>& triangle);

} // namespace gnomon
