#pragma once
// Cube maps: which face and where on it a direction hits, and which texel lies across an edge. Faces are layers in
// OpenGL's order +X −X +Y −Y +Z −Z, with the face coordinates of its table of sc, tc and ma. [OpenGL 4.6, table 8.19]
// Where two components of a direction are equally large, x goes before y and y before z.

#include <array>

#include "core/math.h"

namespace gnomon {

// A direction in the coordinates of the face that it hits: uv = ½((sc, tc)/major + 1), which lies in [0, 1]².
struct CubePoint {
    int face;
    float sc, tc;
    float major; // |ma| ≥ |sc|, |tc|; 0 only for the zero direction, which hits the middle of face 1
    vec2 uv() const { return major > 0 ? vec2(sc / major + 1.0f, tc / major + 1.0f) * 0.5f : vec2(0.5f); }
};
CubePoint cube_point(vec3 direction);

// (sc, tc, ±ma) of a vector on a given face: linear, so that it also maps derivatives. The third is ≥ 0 on the face's
// own directions.
vec3 cube_face_coordinates(int face, vec3 v);

// The direction of length √(sc² + tc² + 1) through the point uv of a face.
vec3 cube_direction(int face, vec2 uv);

struct CubeTexel {
    int face, x, y;
};

// The texel that (x, y) of a face of n×n texels stands for, where at most one of x and y is −1 or n: one beyond the
// edge is the edge texel of the neighbouring face, found by projecting its centre on that face. Exact, in integers.
CubeTexel cube_texel(int face, int x, int y, int n);

} // namespace gnomon
