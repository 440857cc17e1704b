#pragma once
// Random triangles in window coordinates, unclipped: Mesa clips whatever leaves the viewport, so the viewport is four
// times as wide and high as the target and around it, and every vertex lies inside, strictly between near and far.

#include "tests/conformance/check.h"
#include "tests/conformance/duel.h"

namespace gnomon_conformance {

enum class Shape { Small, Tiny, Sliver, OnGrid, Fan, Border, Degenerate, Large, Huge };
inline constexpr int shape_count = 9;

struct TriangleOptions {
    int width, height;    // of the target
    bool snapped = false; // vertices at multiples of 1/256 pixel
    bool divided = false; // w is not 1
    bool constant_depth = false;
};

// Where the triangles for a target of this size expect the viewport.
inline Rectangle wide_viewport(int width, int height) {
    return {-3 * width / 2, -3 * height / 2, 4 * width, 4 * height};
}

// Appends one triangle of the shape, or several that share edges (a Fan is 8), and returns how many.
int add_random(Batch& batch, Shape shape, const TriangleOptions& options, Random& random);

// A mix in which large shapes are rare and come first, so that ids of small ones stay visible.
Batch random_batch(int count, const TriangleOptions& options, Random& random);

} // namespace gnomon_conformance
