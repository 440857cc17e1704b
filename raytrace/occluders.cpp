#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raytrace/occluders.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <algorithm>

#include "raytrace/boxes-inl.h"
#include "raytrace/occluders.h"
#include "raytrace/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::HWY_NAMESPACE {

constexpr float u = 0x1p-24f;

// The same with all terms of one sign: what bounds the rounding of a cross product of `a` and `b` of magnitudes a, b.
HWY_INLINE Vector cross_magnitudes(const Vector& a, const Vector& b) {
    return {hn::MulAdd(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulAdd(a.z, b.x, hn::Mul(a.x, b.z)),
            hn::MulAdd(a.x, b.y, hn::Mul(a.y, b.x))};
}

void touch(const Pyramid& pyramid, const BoxArrays& boxes, TouchedBoxes& touched) {
    std::size_t count = 0;
    const Float origin[3] = {hn::Set(d, pyramid.origin.x), hn::Set(d, pyramid.origin.y), hn::Set(d, pyramid.origin.z)};
    const Float growth = hn::Set(d, pyramid.growth);
    for (std::size_t first = 0; first < boxes.count; first += hn::Lanes(d)) {
        Float low[3], high[3];
        for (int i = 0; i < 3; ++i) {
            low[i] = hn::Sub(hn::Sub(hn::LoadU(d, boxes.minimum[i] + first), origin[i]), growth);
            high[i] = hn::Add(hn::Sub(hn::LoadU(d, boxes.maximum[i] + first), origin[i]), growth);
        }
        Mask outside = hn::Lt(hn::Zero(d), hn::Zero(d));
        for (int k = 0; k < Pyramid::planes; ++k) {
            // The corner that lies farthest inside. Rounding: two u for the difference, three for the sum, one for the
            // plane's own normal; 16 are allowed.
            Float value = hn::Zero(d), magnitude = hn::Zero(d);
            for (int i = 0; i < 3; ++i) {
                const float n = pyramid.normal[k][i];
                const Float term = hn::Mul(hn::Set(d, n), n > 0.0f ? low[i] : high[i]);
                value = hn::Add(value, term);
                magnitude = hn::Add(magnitude, hn::Abs(term));
            }
            const Float limit = hn::MulAdd(magnitude, hn::Set(d, 16 * u), hn::Set(d, pyramid.offset[k]));
            outside = hn::Or(outside, hn::Gt(value, limit));
        }
        unsigned inside = ~bits_of(outside) & ((1u << hn::Lanes(d)) - 1u);
        if (!inside) continue;
        Float range[4];
        reach_of_boxes(pyramid, low, high, range);
        HWY_ALIGN float ranges[4][16];
        for (int i = 0; i < 4; ++i) hn::Store(range[i], d, ranges[i]);
        for (; inside; inside &= inside - 1) {
            const auto i = static_cast<unsigned>(__builtin_ctz(inside));
            touched.box[count] = static_cast<std::uint32_t>(first) + i;
            touched.a_low[count] = ranges[0][i], touched.a_high[count] = ranges[1][i];
            touched.b_low[count] = ranges[2][i], touched.b_high[count] = ranges[3][i];
            ++count;
        }
    }
    touched.count = count;
    std::fill_n(touched.a_low.begin() + static_cast<std::ptrdiff_t>(count), 16, unbounded);
    std::fill_n(touched.a_high.begin() + static_cast<std::ptrdiff_t>(count), 16, -unbounded);
}

// What project() finds for some triangles of a cluster.
struct Projection {
    Vector edge[3];
    Float margin, whole; // of edge functions of rays; and of those of the pyramid's rays as they were without rounding
    Float volume, volume_wrong;       // twice det(v₀, v₁, v₂)
    Float least;                      // below |n·d| of any ray d that passes inside all edges for certain
    Float height[3], lowest, highest; // of the corners; the latter two with their rounding
    Float a[2], b[2];
    Mask only_positive, only_negative; // see OccluderGroup
    Mask hides_nothing, hides_all, nearer;
};

// Embree's t is V / (n·d) with V = det(v₀, v₁, v₂) and n·d half of the edge functions' sum. Where all of these have the
// sign that V does not have, but for the margin, t is negative, or above V / 2.5 margins where n·d is of rounding
// errors.
HWY_INLINE void set_sides(const Vector* v, Projection& to) {
    to.volume = dot(to.edge[0], v[1]);
    to.volume_wrong = hn::Mul(hn::Set(d, 16 * u), dot(magnitudes(to.edge[0]), magnitudes(v[1])));
    const Float enough = hn::MulAdd(to.whole, hn::Set(d, 8.0f), to.volume_wrong);
    to.only_positive = hn::Gt(to.volume, enough), to.only_negative = hn::Lt(to.volume, hn::Neg(enough));
}

// Pluecker's edge functions, computed by Embree as ((v₂ − v₀) × (v₂ + v₀))·d and so on, v relative to the origin. We
// take the very same float differences e and sums m. Each component of the cross product is off by at most 4 u of the
// sum of its terms' magnitudes (u for each factor, its product and the difference), which make a vector no longer than
// √2 |e| |m|, and its product with d by another 3 u: less than 9 u |e| |m| |d|. The tolerance that Embree allows is 2 u
// of the three functions' sum, 6 u of the largest. Twice the former, for Embree and for us, and the latter make the
// margin, with the longest e and m of the three edges and the longest d: 24 u |e| |m| |d|. So an edge function beyond
// the margin is more than 15 u |e| |m| |d| in truth, and n·d, half of the three's sum, more than 22 u. Tests of the
// pyramid as a whole add the slack of its rays.
HWY_INLINE void project_edges(const Pyramid& pyramid, const Vector* v, Projection& to) {
    const Vector center = set(pyramid.center), axis_a = set(pyramid.axis_a), axis_b = set(pyramid.axis_b);
    constexpr int from[3] = {0, 1, 2}, end[3] = {2, 0, 1};
    Vector longest = set(vec3(0.0f)), farthest = longest;
    Float edge = hn::Zero(d), sum_size = edge;
    for (int k = 0; k < 3; ++k) {
        const Vector difference = v[end[k]] - v[from[k]], sum = v[end[k]] + v[from[k]];
        to.edge[k] = cross(difference, sum);
        longest = larger(longest, magnitudes(difference)), farthest = larger(farthest, magnitudes(sum));
        edge = hn::Max(edge, dot(difference, difference)), sum_size = hn::Max(sum_size, dot(sum, sum));
    }
    // Lengths that float cannot square are taken for longer.
    edge = hn::Max(edge, hn::Set(d, 1e-30f)), sum_size = hn::Max(sum_size, hn::Set(d, 1e-30f));
    const Float size = hn::Mul(hn::Mul(hn::Sqrt(edge), hn::Sqrt(sum_size)), hn::Set(d, pyramid.longest));
    to.margin = hn::Mul(hn::Set(d, 24.1f * u), size), to.least = hn::Mul(hn::Set(d, 22 * u), size);
    to.whole = hn::Add(to.margin, dot(cross_magnitudes(longest, farthest), set(pyramid.slack)));
    Mask positive[3], negative[3];
    for (int k = 0; k < 3; ++k) {
        const Float middle = dot(to.edge[k], center);
        const Float width = hn::Add(hn::Abs(dot(to.edge[k], axis_a)), hn::Abs(dot(to.edge[k], axis_b)));
        positive[k] = hn::Gt(hn::Sub(middle, width), to.whole);
        negative[k] = hn::Lt(hn::Add(middle, width), hn::Neg(to.whole));
    }
    set_sides(v, to);
    const Mask some_positive = hn::Or(hn::Or(positive[0], positive[1]), positive[2]);
    const Mask some_negative = hn::Or(hn::Or(negative[0], negative[1]), negative[2]);
    to.hides_nothing = hn::Or(hn::And(some_positive, some_negative), hn::Or(hn::And(to.only_positive, some_negative),
                                                                            hn::And(to.only_negative, some_positive)));
    to.hides_all = hn::Or(hn::And(hn::And(positive[0], positive[1]), positive[2]),
                          hn::And(hn::And(negative[0], negative[1]), negative[2]));
}

// Whether a corner of the receiver's own triangle is certainly on the apex's side of the plane: otherwise Embree's hit
// may be rejected as left behind. The normal is here compared with that of the triangle as it is, whose corners differ
// from the rounded v by u of them, so that its edges differ by 2 u of the corners' sum.
HWY_INLINE Mask separates(const Pyramid& pyramid, const Vector* v, const Vector& e0, const Vector& e1,
                          const Vector& normal, Float apex) {
    const Vector size0 = magnitudes(e0), size1 = magnitudes(e1), start = magnitudes(v[0]);
    const Vector moved = hn::Set(d, 2 * u) * (start + magnitudes(v[1]) + magnitudes(v[2]));
    const Vector wrong = cross_magnitudes(moved, size1) + cross_magnitudes(size0, moved) +
                         hn::Set(d, 16 * u) * cross_magnitudes(size0, size1) + hn::Set(d, 8 * u) * magnitudes(normal);
    Mask found = hn::Lt(hn::Zero(d), hn::Zero(d));
    for (const vec3& corner : pyramid.own) {
        const Vector own = set(corner);
        const Float side = dot(normal, v[0] - own); // of the sign of apex where it is on the apex's side
        found = hn::Or(found, hn::Gt(hn::Mul(side, hn::CopySignToAbs(hn::Set(d, 1.0f), apex)),
                                     dot(wrong, start + magnitudes(own))));
    }
    return found;
}

// How high the corners are between the apex and the light's plane.
HWY_INLINE void project_heights(const Pyramid& pyramid, const Vector* v, Projection& to) {
    const Vector height = set(pyramid.height), size = magnitudes(height);
    to.lowest = hn::Set(d, unbounded), to.highest = hn::Set(d, -unbounded);
    for (int k = 0; k < 3; ++k) {
        const Float wrong = hn::Mul(hn::Set(d, 8 * u), dot(magnitudes(v[k]), size));
        to.height[k] = dot(v[k], height);
        to.lowest = hn::Min(to.lowest, hn::Sub(to.height[k], wrong));
        to.highest = hn::Max(to.highest, hn::Add(to.height[k], wrong));
    }
}

// The depth test: with n the triangle's normal, Embree takes t = (v₀·n) / (d·n) and asks for 0 ≤ t ≤ end. Ours and
// Embree's n differ by at most `off`, that of the triangle as it is, before its corners are rounded to v, by `turned`:
// its edges differ by u of their ends and 2 u of themselves.
struct Plane {
    Vector e0, e1, normal, size, wrong, off, turned, start;
    Float apex; // v₀·n
};
HWY_INLINE Plane plane_of(const Vector* v) {
    Plane p;
    p.e0 = v[2] - v[0], p.e1 = v[0] - v[1];
    p.normal = cross(p.e0, p.e1), p.size = magnitudes(p.normal), p.start = magnitudes(v[0]);
    p.apex = dot(p.normal, v[0]);
    const Vector size0 = magnitudes(p.e0), size1 = magnitudes(p.e1);
    p.wrong = hn::Set(d, 16 * u) * cross_magnitudes(size0, size1);
    p.off = p.wrong + hn::Set(d, 16 * u) * p.size;
    const Vector moved0 = hn::Set(d, u) * (p.start + magnitudes(v[2])) + hn::Set(d, 2 * u) * size0;
    const Vector moved1 = hn::Set(d, u) * (p.start + magnitudes(v[1])) + hn::Set(d, 2 * u) * size1;
    p.turned = cross_magnitudes(moved0, size1) + cross_magnitudes(size0, moved1) + p.off;
    return p;
}

// A ray that passes inside all edges for certain meets the triangle between the heights of its corners, and its t is as
// certain as n·d is large: with τ what v₀·n may be off by and δ what d·n may be, Embree's t lies between those
// heights but for τ / (n·d) and a factor 1 ± δ / (n·d). The hit is not left behind where the ray's end is beyond the
// plane, which at the end is (1 − t)·n·d away.
HWY_INLINE Mask meets_before_end(const Pyramid& pyramid, const Plane& plane, const Projection& from) {
    const Vector reach = set(pyramid.reach);
    const Float off_start = dot(plane.off, plane.start), off_way = dot(plane.off, reach);
    const Float low = hn::Mul(from.lowest, hn::Set(d, 1.0f - pyramid.wrong_height));
    const Float high = hn::Mul(from.highest, hn::Set(d, 1.0f + 2.0f * pyramid.wrong_height));
    const Float end = hn::Set(d, pyramid.end_minimum * (1.0f - 16 * u));
    const Mask after_start = hn::Gt(hn::Mul(low, from.least), hn::Mul(hn::Set(d, 2.0f), off_start));
    const Mask before_end = hn::Lt(hn::MulAdd(high, from.least, off_start), hn::Mul(end, hn::Sub(from.least, off_way)));
    const Mask ends_beyond =
        hn::Gt(hn::Mul(hn::Sub(hn::Set(d, 1.0f), high), from.least), dot(plane.turned, reach + plane.start));
    return hn::And(hn::And(after_start, before_end), ends_beyond);
}

// Whether a point of the receiver's triangle near the apex is certainly on the apex's side of the plane, and so a
// corner is.
HWY_INLINE Mask starts_off_plane(const Pyramid& pyramid, const Plane& plane) {
    const Vector near = set(vec3(pyramid.own_distance));
    return hn::Gt(hn::Abs(plane.apex), hn::Add(dot(plane.size, near), dot(plane.turned, plane.start + near)));
}

// Both products have the same n, so what is wrong with its length does not matter and the test is the sign of
// n·(end·d − v₀), known where it is larger than: 16 u of n's terms times the vector (the difference between Embree's n
// and ours), 8 u of each product's terms (products, sums, the division), and the slack.
HWY_INLINE void cross_plane(const Pyramid& pyramid, const Vector* v, const Plane& plane, Mask& nearer, Mask& misses) {
    const Vector center = set(pyramid.center), axis_a = set(pyramid.axis_a), axis_b = set(pyramid.axis_b);
    const Vector spread = magnitudes(axis_a) + magnitudes(axis_b);
    const Float eight = hn::Set(d, 8 * u);
    const Mask apex_known =
        hn::Gt(hn::Abs(plane.apex), hn::MulAdd(eight, dot(plane.size, plane.start), dot(plane.wrong, plane.start)));
    const Float width = hn::Add(hn::Abs(dot(plane.normal, axis_a)), hn::Abs(dot(plane.normal, axis_b)));
    const Float terms = dot(plane.size, plane.start + magnitudes(center) + spread);
    const Float slack = dot(plane.size + plane.wrong, set(pyramid.slack));
    // Positive where the rays cross the plane before their end.
    const auto beyond = [&](float end, Float& margin) HWY_ATTR {
        const Vector way = hn::Set(d, end) * center - v[0];
        margin = hn::Add(hn::MulAdd(eight, terms, slack), dot(plane.wrong, magnitudes(way) + spread));
        return hn::CopySignToAbs(hn::Set(d, 1.0f), plane.apex) * way;
    };
    Float margin;
    const Float farthest = hn::Add(dot(plane.normal, beyond(pyramid.end_maximum, margin)), width);
    misses = hn::And(apex_known, hn::Lt(farthest, hn::Neg(margin)));
    const Float nearest = hn::Sub(dot(plane.normal, beyond(pyramid.end_minimum, margin)), width);
    nearer = hn::And(apex_known, hn::Gt(nearest, margin));
}

// Of the triangles `asked`. What is nearer than the light by its corners' heights need not be asked by its plane.
HWY_INLINE void project_depth(const Pyramid& pyramid, const Vector* v, unsigned asked, Projection& to) {
    const Plane plane = plane_of(v);
    to.nearer = meets_before_end(pyramid, plane, to);
    if (asked & ~bits_of(to.nearer)) {
        Mask nearer, misses;
        cross_plane(pyramid, v, plane, nearer, misses);
        to.nearer = hn::Or(to.nearer, nearer);
        to.hides_nothing = hn::Or(to.hides_nothing, misses);
    }
    Mask separated = starts_off_plane(pyramid, plane);
    if (asked & ~bits_of(separated))
        separated = hn::Or(separated, separates(pyramid, v, plane.e0, plane.e1, plane.normal, plane.apex));
    to.nearer = hn::And(to.nearer, separated);
    to.hides_all = hn::And(to.hides_all, to.nearer);
}

// The range of s and t outside which the edge functions certainly disagree. Outside the triangle's image by β, at least
// one of the point's barycentric coordinates is below −β / (2·width of the image) and one is above 1/3; an edge
// function is its coordinate times its value at the opposite corner, volume / height there. So β =
// 2·width·margin·height / volume makes sure, as long as that quotient is below 1/3.
HWY_INLINE void project_range(const Pyramid& pyramid, const Vector* v, Projection& to) {
    const Vector height = set(pyramid.height), along[2] = {set(pyramid.to_a), set(pyramid.to_b)};
    const Vector height_size = magnitudes(height), along_size[2] = {magnitudes(along[0]), magnitudes(along[1])};
    const Float center[2] = {hn::Set(d, pyramid.center_a), hn::Set(d, pyramid.center_b)};
    const float axis_wrong[2] = {pyramid.wrong_a, pyramid.wrong_b};
    Float low[2], high[2], wrong[2];
    for (int i = 0; i < 2; ++i) low[i] = hn::Set(d, unbounded), high[i] = hn::Set(d, -unbounded);
    Vector farthest = set(vec3(0.0f));
    for (int k = 0; k < 3; ++k) {
        const Float inverse = hn::Div(hn::Set(d, 1.0f), to.height[k]);
        farthest = larger(farthest, magnitudes(v[k]));
        for (int i = 0; i < 2; ++i) {
            const Float at = hn::Sub(hn::Mul(dot(v[k], along[i]), inverse), center[i]);
            low[i] = hn::Min(low[i], at), high[i] = hn::Max(high[i], at);
        }
    }
    // 4 u of the terms for the products, as much for the heights, and the quotients.
    const Float inverse = hn::Div(hn::Set(d, 1.0f), to.lowest);
    const Float relative = hn::MulAdd(dot(farthest, height_size), inverse, hn::Set(d, 1.0f));
    for (int i = 0; i < 2; ++i) {
        const Float off = hn::Mul(hn::Mul(dot(farthest, along_size[i]), inverse), relative);
        wrong[i] = hn::MulAdd(off, hn::Set(d, 16 * u), hn::Set(d, 2 * axis_wrong[i]));
    }
    const Float certain = hn::Sub(hn::Abs(to.volume), hn::Add(to.volume_wrong, to.whole));
    const Float quotient = hn::Div(hn::Mul(hn::Mul(hn::Set(d, 2.0f), to.whole), to.highest), certain);
    const Mask known = hn::And(hn::And(hn::Gt(to.lowest, hn::Set(d, 0x1p-13f)), hn::Gt(certain, hn::Zero(d))),
                               hn::Lt(quotient, hn::Set(d, 0.6f)));
    Mask overlaps = hn::Le(hn::Zero(d), hn::Zero(d));
    Float* range[2] = {to.a, to.b};
    for (int i = 0; i < 2; ++i) {
        const Float grow = hn::MulAdd(hn::Sub(high[i], low[i]), quotient, hn::Mul(wrong[i], hn::Set(d, 2.0f)));
        range[i][0] = hn::IfThenElse(known, hn::Sub(low[i], grow), hn::Set(d, -unbounded));
        range[i][1] = hn::IfThenElse(known, hn::Add(high[i], grow), hn::Set(d, unbounded));
        overlaps = hn::And(overlaps, hn::And(hn::Le(range[i][0], hn::Set(d, 1.0f + axis_wrong[i])),
                                             hn::Ge(range[i][1], hn::Set(d, -1.0f - axis_wrong[i]))));
    }
    to.hides_nothing = hn::Or(to.hides_nothing, hn::Not(overlaps));
}

// Where the edge functions tell nothing, what the triangle's box may hide is left: other hits are no hits.
HWY_INLINE void project_box(const Pyramid& pyramid, const Vector* v, Projection& to) {
    const Mask known = hn::Gt(to.a[0], hn::Set(d, -unbounded));
    if (bits_of(known) == (1u << hn::Lanes(d)) - 1u) return;
    const auto side = [&](Float x, Float y, Float z, float origin, Float& low, Float& high) HWY_ATTR {
        low = hn::Min(hn::Min(x, y), z), high = hn::Max(hn::Max(x, y), z);
        return hn::Add(hn::Max(hn::Abs(low), hn::Abs(high)), hn::Set(d, std::abs(origin)));
    };
    Float low[3], high[3];
    const vec3 origin = pyramid.origin;
    const Float magnitude = hn::Max(hn::Max(side(v[0].x, v[1].x, v[2].x, origin.x, low[0], high[0]),
                                            side(v[0].y, v[1].y, v[2].y, origin.y, low[1], high[1])),
                                    side(v[0].z, v[1].z, v[2].z, origin.z, low[2], high[2]));
    const Float growth = hn::MulAdd(hn::Set(d, proof_growth), magnitude, hn::Set(d, pyramid.growth));
    for (int i = 0; i < 3; ++i) low[i] = hn::Sub(low[i], growth), high[i] = hn::Add(high[i], growth);
    Float range[4];
    reach_of_boxes(pyramid, low, high, range);
    for (int i = 0; i < 2; ++i) {
        to.a[i] = hn::IfThenElse(known, to.a[i], range[i]);
        to.b[i] = hn::IfThenElse(known, to.b[i], range[2 + i]);
    }
}

HWY_INLINE void store(const Projection& from, std::size_t first, OccluderGroup& to) {
    for (int k = 0; k < 3; ++k) {
        hn::Store(from.edge[k].x, d, to.edge[k][0] + first);
        hn::Store(from.edge[k].y, d, to.edge[k][1] + first);
        hn::Store(from.edge[k].z, d, to.edge[k][2] + first);
    }
    hn::Store(from.margin, d, to.margin + first);
    hn::Store(from.a[0], d, to.a_low + first);
    hn::Store(from.a[1], d, to.a_high + first);
    hn::Store(from.b[0], d, to.b_low + first);
    hn::Store(from.b[1], d, to.b_high + first);
}

void project(const Pyramid& pyramid, const TriangleCluster& cluster, std::uint32_t own, OccluderGroup& group) {
    group.present = group.nearer = group.positive = group.negative = 0;
    group.hides_all = false;
    const Vector origin = set(pyramid.origin);
    unsigned others = (1u << cluster.count) - 1u;
    for (unsigned i = 0; i < cluster.count; ++i) others &= ~((cluster.triangle[i] == own ? 1u : 0u) << i);
    for (std::size_t first = 0; first < cluster.count; first += hn::Lanes(d)) {
        Vector v[3];
        for (int k = 0; k < 3; ++k)
            v[k] = Vector{hn::Load(d, cluster.corner[k][0] + first), hn::Load(d, cluster.corner[k][1] + first),
                          hn::Load(d, cluster.corner[k][2] + first)} -
                   origin;
        const unsigned here = others >> first & ((1u << hn::Lanes(d)) - 1u);
        Projection projection;
        project_edges(pyramid, v, projection);
        if (!(here & ~bits_of(projection.hides_nothing))) continue;
        project_heights(pyramid, v, projection);
        project_depth(pyramid, v, here & ~bits_of(projection.hides_nothing), projection);
        group.hides_all |= (here & bits_of(projection.hides_all)) != 0;
        if (!(here & ~bits_of(projection.hides_nothing))) continue;
        project_range(pyramid, v, projection);
        project_box(pyramid, v, projection);
        group.present |= (here & ~bits_of(projection.hides_nothing)) << first;
        group.nearer |= (here & bits_of(projection.nearer)) << first;
        group.positive |= (here & ~bits_of(projection.only_negative)) << first;
        group.negative |= (here & ~bits_of(projection.only_positive)) << first;
        store(projection, first, group);
    }
}

const OccluderKernels* occluder_table() {
    static constexpr OccluderKernels functions{touch, project};
    return &functions;
}

} // namespace gnomon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon {

HWY_EXPORT(occluder_table);

const OccluderKernels& occluder_kernels() {
    static const OccluderKernels* const chosen = HWY_DYNAMIC_DISPATCH(occluder_table)();
    return *chosen;
}

} // namespace gnomon
#endif
