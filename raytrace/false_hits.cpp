#include "raytrace/false_hits.h"

#include <algorithm>
#include <limits>

namespace gnomon {

HitTriangle hit_triangle(const std::array<vec3, 3>& corners) {
    const auto& [a, b, c] = corners;
    const vec3 low = glm::min(glm::min(a, b), c), high = glm::max(glm::max(a, b), c);
    const dvec3 corner(a);
    return {0.5f * low + 0.5f * high, 0.5f * high - 0.5f * low, larger(largest_component(low), largest_component(high)),
            corner, glm::cross(dvec3(b) - corner, dvec3(c) - corner)};
}

// No axis and no product of an axis and the way separates them.
bool meets_box(const HitTriangle& hit, vec3 start, vec3 way) {
    const vec3 middle = 0.5f * way, between = start + middle - hit.center, size = glm::abs(middle);
    const float magnitude = larger(larger(hit.magnitude, largest_component(start)), largest_component(start + way));
    const vec3 half = hit.half + box_growth * magnitude;
    const vec3 distance = glm::abs(between);
    const bool axes =
        (distance.x <= half.x + size.x) & (distance.y <= half.y + size.y) & (distance.z <= half.z + size.z);
    return axes & (std::abs(middle.y * between.z - middle.z * between.y) <= half.y * size.z + half.z * size.y) &
           (std::abs(middle.z * between.x - middle.x * between.z) <= half.z * size.x + half.x * size.z) &
           (std::abs(middle.x * between.y - middle.y * between.x) <= half.x * size.y + half.y * size.x);
}

RelativeSides sides_of(const HitTriangle& hit, const std::array<vec3, 3>& own_corners) {
    RelativeSides sides{true, true};
    const double length = glm::length(hit.normal);
    for (const vec3& own : own_corners) {
        // Of corners that both triangles share, the distance is 0 but for the rounding of doubles.
        constexpr double shared = 1e-12;
        const dvec3 from = dvec3(own) - hit.corner;
        const double distance = glm::dot(hit.normal, from), rounding = shared * length * glm::length(from);
        sides.in_front &= distance >= -rounding;
        sides.behind &= distance <= rounding;
    }
    return sides;
}

bool is_left_behind(const HitTriangle& hit, const RelativeSides& own, vec3 start, vec3 way, bool ends) {
    const dvec3 end = dvec3(start) + dvec3(way);
    const double at_end = glm::dot(hit.normal, ends ? end - hit.corner : dvec3(way));
    if (!(at_end > 0 ? own.in_front : own.behind)) return false;
    const double magnitude = ends ? static_cast<double>(largest_component(vec3(end))) : 1.0;
    return std::abs(at_end) > magnitude * static_cast<double>(relative_step) * glm::length(hit.normal);
}

float steep_hit(const std::array<vec3, 3>& corners, float magnitude) {
    const auto& [a, b, c] = corners;
    const float edge = larger(larger(largest_component(b - a), largest_component(c - b)), largest_component(a - c));
    return edge > 0x1p-16f * magnitude ? 0.25f * edge * edge : std::numeric_limits<float>::infinity();
}

} // namespace gnomon
