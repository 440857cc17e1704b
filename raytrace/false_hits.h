#pragma once
// Which of the hits that Embree reports for shadow rays are errors of rounding. Both rules are exact, so that proofs
// about many rays can foresee them.

#include <array>
#include <cmath>

#include "core/math.h"

namespace gnomon {

// Embree answers a ray that is nearly in the plane of a triangle from rounding errors alone and may report a hit metres
// away from the triangle. A hit therefore counts only where the way meets the triangle's box, grown by this part of the
// largest coordinate of the way and the triangle.
inline constexpr float box_growth = 0x1p-13f;

// Of coordinates of about this size Embree tells nothing closer apart than this part of them: shadow rays start off
// their surface, and end before their target, by 2⁻¹⁹ of the largest coordinate involved.
inline constexpr float relative_step = 0x1p-19f;

// Not std::max: taking values instead of references lets loops vectorise.
inline float larger(float a, float b) { return a > b ? a : b; }
inline float largest_component(vec3 v) { return larger(larger(std::abs(v.x), std::abs(v.y)), std::abs(v.z)); }

// What the rules need to know of a triangle that was hit.
struct HitTriangle {
    vec3 center, half; // of its box
    float magnitude;   // its largest coordinate
    dvec3 corner, normal;
};
HitTriangle hit_triangle(const std::array<vec3, 3>& corners);

// Whether the segment from `start` along `way` meets the box grown by box_growth.
bool meets_box(const HitTriangle& hit, vec3 start, vec3 way);

// Where the receiver's own triangle lies, seen from another one's plane: no corner is behind it, or none in front.
struct RelativeSides {
    bool in_front, behind;
};
RelativeSides sides_of(const HitTriangle& hit, const std::array<vec3, 3>& own_corners);

// Whether the triangle cannot lie between the receiver's own one and the end of a ray, because both are on one side of
// its plane: then the ray starts in that plane but for rounding, in a crease of a surface, and leaves it. A ray's end
// within the rounding of its coordinates from the plane counts as on it. Without `ends` the ray goes on along `way`.
bool is_left_behind(const HitTriangle& hit, const RelativeSides& own, vec3 start, vec3 way, bool ends);

// With d the ray's direction and n the normal that Embree reports, a hit with |n·d| above this times the largest
// component of d lies in the triangle's grown box for sure. Infinite for triangles so small beside `magnitude`, the
// largest coordinate of the scene, that their edges are rounding errors.
//
// With u = 2⁻²⁴, e the largest coordinate difference of the edges and m that of all coordinates involved, Embree's edge
// functions are off by less than 80 u·e·4 m·|d| (see occluders.cpp, with bounds for the terms), their sum is 2 |n·d|,
// and so the plane's point is off the triangle by less than 320 u·e²·m·|d| / |n·d|; the hit is off that point by less
// than 168 u·e²·m·|d| / |n·d| along the ray. Both together stay below the growth of 2048 u·m where |n·d| > e²·|d| / 4.
float steep_hit(const std::array<vec3, 3>& corners, float magnitude);

} // namespace gnomon
