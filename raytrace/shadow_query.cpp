#include "raytrace/shadow_query.h"

#include <cmath>

namespace gnomon {
namespace {

constexpr float u = 0x1p-24f;

// The normal is rounded to float, and so is its product with a way: by less than 8 u of their terms.
void set_plane(LookedAt& hit, const ShadowQuery& query) {
    const dvec3 normal = hit.triangle.normal;
    const double at_start = glm::dot(normal, dvec3(query.start) - hit.triangle.corner);
    const dvec3 size = glm::abs(normal);
    const double all = size.x + size.y + size.z;
    hit.away = vec3(at_start > 0 ? -normal : normal);
    hit.off_plane = static_cast<float>(all) * (8 * u);
    const bool starts_off_plane = std::abs(at_start) > static_cast<double>(query.nearest) * all;
    hit.from_plane = !starts_off_plane ? infinity
                     : query.ends      ? static_cast<float>(std::abs(at_start)) * (1 + 4 * u)
                                       : 0;
}

} // namespace

LookedAt& look_at(ShadowQuery& query, std::uint32_t primitive) {
    LookedAt& hit = query.looked_at[primitive % query.looked_at.size()];
    if (hit.primitive == primitive) return hit;
    hit.primitive = primitive;
    hit.triangle = hit_triangle(query.casters->corners(primitive));
    hit.own.reset();
    const float growth = 0.5f * box_growth * larger(hit.triangle.magnitude, largest_component(query.start));
    hit.half = query.ends ? hit.triangle.half + growth : vec3(infinity);
    set_plane(hit, query);
    return hit;
}

bool is_false_hit(ShadowQuery& query, std::uint32_t primitive, vec3 way) {
    LookedAt& hit = look_at(query, primitive);
    if (query.ends && !meets_box(hit.triangle, query.start, way)) return true;
    if (!hit.own) hit.own = sides_of(hit.triangle, query.own_corners);
    return is_left_behind(hit.triangle, *hit.own, query.start, way, query.ends);
}

} // namespace gnomon
