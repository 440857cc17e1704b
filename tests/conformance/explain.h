#pragma once
// Why two rasterizers may rightly differ at a pixel: a window coordinate that lies within its own rounding error of the
// tie between two sub-pixel steps is snapped either way, and the pixel's coverage depends on which.

#include <optional>
#include <span>

#include "tests/conformance/duel.h"

namespace gnomon_conformance {

// A vertex as exact arithmetic has it, with a bound on the error that float32 arithmetic may make.
struct ExactVertex {
    dvec4 clip;
    double clip_error = 0; // absolute, of each clip coordinate
};
// Vertices given in clip space are exact; those under a matrix are transformed in double.
std::vector<ExactVertex> exact_vertices(std::span<const vec4> clip);
std::vector<ExactVertex> exact_vertices(std::span<const vec3> positions, const mat4& to_clip);

// Whether some triangle covers the pixel under one rounding of its vertices' window coordinates and not under another.
bool hangs_on_rounding(std::span<const ExactVertex> vertices, std::span<const uvec3> triangles,
                       const Rectangle& viewport, ivec2 pixel);

// The triangle at a point of the window (pixels) in homogeneous terms, without clipping or snapping: z/w there, where
// the point is inside the triangle and in front of the eye.
std::optional<double> homogeneous_depth(const dvec4& a, const dvec4& b, const dvec4& c, const Rectangle& viewport,
                                        dvec2 point);

} // namespace gnomon_conformance
