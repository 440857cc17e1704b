#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raytrace/crossings.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "raytrace/crossings.h"
#include "raytrace/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::HWY_NAMESPACE {

using Integers = hn::RebindToSigned<Tag>;
using Integer = hn::Vec<Integers>;
constexpr Integers whole;

constexpr float u = 0x1p-24f;
// Where the light's surroundings end, in s and t: the points lie within 1 / light_growth.
constexpr float border = 1.0f;

struct Image {
    Float height, s, t;
};
HWY_INLINE Image image_of(const Pyramid& pyramid, const Vector& v) {
    const Float height = dot(v, set(pyramid.height)), inverse = hn::Div(hn::Set(d, 1.0f), height);
    return {height, hn::Sub(hn::Mul(dot(v, set(pyramid.to_a)), inverse), hn::Set(d, pyramid.center_a)),
            hn::Sub(hn::Mul(dot(v, set(pyramid.to_b)), inverse), hn::Set(d, pyramid.center_b))};
}

// Images are points in coordinates that the float functionals to_a, to_b and height define. With A the length of to_a
// and H that of height, that of a corner in a distance R at a height h is off by less than u (R A / h) (6 + 3 H R / h):
// products and sums 3 u, the height 3 u R H / h of itself, its inverse, product and difference 3 u. The light's points
// are such images in a distance of at most L, at a height of 1. Coordinates that center and axes define differ by the
// rounding of all of them, u L A (4 + H L); both together are `of_points`.
struct ImageError {
    float along, height, of_points;
};
HWY_INLINE ImageError error_of(const Pyramid& pyramid) {
    const float along = std::max(glm::length(pyramid.to_a), glm::length(pyramid.to_b)),
                height = glm::length(pyramid.height), reach = pyramid.longest;
    return {u * along, 3 * height, u * along * reach * (11 + 5 * height * reach)};
}
HWY_INLINE Float wrong_of(const ImageError& error, Float farthest, Float lowest) {
    const Float far = hn::Div(farthest, lowest);
    return hn::Mul(hn::Mul(far, hn::MulAdd(far, hn::Set(d, error.height), hn::Set(d, 6.0f))), hn::Set(d, error.along));
}

// The edge function is that of occluders.cpp, twice det(v₁, v₀, d): by the way d = center + s·axis_a + t·axis_b an
// affine one of s and t. With e and m the edge and the corners' sum, each component of their cross product is off by
// 4 u of the sum of the magnitudes of its terms, which make a vector no longer than √2 |e| |m|, and the product with d
// by 3 u: below 9 u |e| |m| |d| for Embree, and for us with 6 u more for the coefficients. Distances along s and t add
// what images are off.
//
// Points in an edge's range of t are told apart by the sign of the edge function, which has to be that of the line
// through the images as computed, the images' corners off by w = `wrong`. Both functions differ by at most
// 2 w |p|₁ + w |e|₁ + 2 w², with e the edge and p the way from its corner to the point, which is asked for only within
// 4 w of the edge's box; with |e|₁ ≥ 8 w that is below 5 w |e|₁. Shorter edges tell nothing about such points.
bool project(const Pyramid& pyramid, const Outline& outline, const std::int32_t* states, EdgeImages& images) {
    std::size_t count = 0;
    bool all = true;
    const Vector origin = set(pyramid.origin), axis_a = set(pyramid.axis_a), axis_b = set(pyramid.axis_b);
    const Vector center = set(pyramid.center);
    const Float weight = hn::Set(d, 24 * u * pyramid.longest);
    const ImageError error = error_of(pyramid);
    const bool mirrored = glm::dot(glm::cross(pyramid.axis_a, pyramid.axis_b), pyramid.center) < 0.0f;
    for (std::size_t first = 0; first < outline.edges; first += hn::Lanes(d)) {
        const Integer along = hn::GatherIndex(whole, states, hn::LoadU(whole, &outline.along[first])),
                      against = hn::GatherIndex(whole, states, hn::LoadU(whole, &outline.against[first]));
        const Integer weights = hn::Sub(along, against);
        Mask wanted = hn::RebindMask(d, hn::Ne(weights, hn::Zero(whole)));
        if (hn::AllFalse(d, wanted)) continue;
        const auto corner = [&](const std::vector<float>* at) HWY_ATTR {
            return Vector{hn::LoadU(d, &at[0][first]), hn::LoadU(d, &at[1][first]), hn::LoadU(d, &at[2][first])} -
                   origin;
        };
        const Vector from = corner(outline.from), to = corner(outline.to);
        Image low = image_of(pyramid, from), high = image_of(pyramid, to);
        const Float lowest = hn::Min(low.height, high.height);
        all &= hn::AllFalse(d, hn::And(wanted, hn::Not(hn::Gt(lowest, hn::Set(d, 0x1p-13f)))));
        const Vector difference = to - from, sum = to + from;
        const Float wrong = wrong_of(error, hn::Max(length(from), length(to)), lowest);
        const Float edge_of_light = hn::Add(hn::Set(d, border), wrong), of_points = hn::Set(d, error.of_points);
        const auto apart = [&](Float x, Float y) HWY_ATTR {
            return hn::Or(hn::Gt(hn::Min(x, y), edge_of_light), hn::Lt(hn::Max(x, y), hn::Neg(edge_of_light)));
        };
        wanted = hn::AndNot(hn::Or(apart(low.s, high.s), apart(low.t, high.t)), wanted);
        if (hn::AllFalse(d, wanted)) continue;
        // Seen with s to the right and t upward a triangle that is crossed along its normal lies left of its edges,
        // and right of them where the axes are mirrored.
        const Mask downward = hn::Lt(high.t, low.t);
        const Vector n = cross(difference, sum);
        const Mask turned = mirrored ? hn::Not(downward) : downward;
        const auto signed_dot = [&](const Vector& axis) HWY_ATTR {
            const Float value = dot(n, axis);
            return hn::IfThenElse(turned, hn::Neg(value), value);
        };
        const Float a = signed_dot(axis_a), b = signed_dot(axis_b), c = signed_dot(center);
        const Float size = hn::Add(hn::Abs(a), hn::Abs(b));
        const Float terms = hn::Mul(hn::Mul(length(difference), length(sum)), weight);
        const auto put = [&](Float value, std::vector<float>& list)
                             HWY_ATTR { hn::CompressStore(value, wanted, d, &list[count]); };
        put(hn::IfThenElse(downward, high.s, low.s), images.s_from);
        put(hn::IfThenElse(downward, high.t, low.t), images.t_from);
        put(hn::IfThenElse(downward, low.s, high.s), images.s_to);
        put(hn::IfThenElse(downward, low.t, high.t), images.t_to);
        put(a, images.a), put(b, images.b), put(c, images.c);
        put(hn::MulAdd(hn::MulAdd(wrong, hn::Set(d, 5.0f), of_points), size, terms), images.margin);
        put(hn::Add(wrong, of_points), images.wrong);
        const Integer step = hn::IfThenElse(hn::RebindMask(whole, turned), weights, hn::Neg(weights));
        count += hn::CompressStore(step, hn::RebindMask(whole, wanted), whole, &images.step[count]);
    }
    images.count = count;
    return all;
}

void place_points(const Pyramid& pyramid, const PointBlock& block, std::size_t packets, PointCounts& counts) {
    for (std::size_t k = 0; k < packets; ++k) {
        Float s_low = hn::Set(d, infinity), t_low = s_low, s_high = hn::Neg(s_low), t_high = s_high;
        for (std::size_t i = 16 * k; i < 16 * k + 16; i += hn::Lanes(d)) {
            const Image at = image_of(
                pyramid, {hn::Load(d, block.way[0] + i), hn::Load(d, block.way[1] + i), hn::Load(d, block.way[2] + i)});
            hn::Store(at.s, d, counts.s + i);
            hn::Store(at.t, d, counts.t + i);
            s_low = hn::Min(s_low, at.s), s_high = hn::Max(s_high, at.s);
            t_low = hn::Min(t_low, at.t), t_high = hn::Max(t_high, at.t);
        }
        counts.s_low[k] = hn::GetLane(hn::MinOfLanes(d, s_low)),
        counts.s_high[k] = hn::GetLane(hn::MaxOfLanes(d, s_high));
        counts.t_low[k] = hn::GetLane(hn::MinOfLanes(d, t_low)),
        counts.t_high[k] = hn::GetLane(hn::MaxOfLanes(d, t_high));
    }
    // Nothing meets what is not there.
    for (std::size_t k = packets; k < PointBlock::packets; ++k)
        counts.s_low[k] = counts.t_low[k] = infinity, counts.s_high[k] = counts.t_high[k] = -infinity;
}

// Packets with points in a range, a bit for each.
HWY_INLINE std::uint64_t meeting(const PointCounts& points, float s_low, float s_high, float t_low, float t_high) {
    std::uint64_t met = 0;
    for (std::size_t k = 0; k < PointBlock::packets; k += hn::Lanes(d)) {
        const Mask in_s = hn::And(hn::Le(hn::Load(d, points.s_low + k), hn::Set(d, s_high)),
                                  hn::Ge(hn::Load(d, points.s_high + k), hn::Set(d, s_low)));
        const Mask in_t = hn::And(hn::Le(hn::Load(d, points.t_low + k), hn::Set(d, t_high)),
                                  hn::Ge(hn::Load(d, points.t_high + k), hn::Set(d, t_low)));
        met |= std::uint64_t{bits_of(hn::And(in_s, in_t))} << k;
    }
    return met;
}

HWY_INLINE void add(Mask where, std::int32_t step, std::int32_t* counts) {
    const Integer old = hn::Load(whole, counts);
    hn::Store(hn::Add(old, hn::IfThenElseZero(hn::RebindMask(whole, where), hn::Set(whole, step))), whole, counts);
}

// All points of packets in a range of t.
HWY_INLINE void add_in_range(std::uint64_t some, float from, float to, std::int32_t step, PointCounts& counts) {
    const Float low = hn::Set(d, from), high = hn::Set(d, to);
    for (; some; some &= some - 1) {
        const std::size_t first = 16 * static_cast<std::size_t>(__builtin_ctzll(some));
        for (std::size_t i = first; i < first + 16; i += hn::Lanes(d)) {
            const Float t = hn::Load(d, counts.t + i);
            add(hn::And(hn::Ge(t, low), hn::Lt(t, high)), step, counts.crossings + i);
        }
    }
}

struct PlacedEdge {
    float s_low, s_high, t_from, t_to, a, b, c;
    float margin, close, near; // of a·s + b·t + c
    float wrong;
    bool tells; // on which side points in its box lie
    std::int32_t step;
};

HWY_INLINE PlacedEdge place_edge(const EdgeImages& images, std::size_t i) {
    PlacedEdge edge;
    edge.s_low = std::min(images.s_from[i], images.s_to[i]), edge.s_high = std::max(images.s_from[i], images.s_to[i]);
    edge.t_from = images.t_from[i], edge.t_to = images.t_to[i];
    edge.a = images.a[i], edge.b = images.b[i], edge.c = images.c[i];
    const float per_distance = std::abs(edge.a) + std::abs(edge.b);
    edge.margin = images.margin[i];
    edge.close = edge.margin + silhouette_close * per_distance;
    edge.near = edge.margin + silhouette_near * per_distance;
    edge.wrong = images.wrong[i];
    edge.tells = edge.s_high - edge.s_low + edge.t_to - edge.t_from >= 8 * edge.wrong;
    edge.step = images.step[i];
    return edge;
}

// The packets of an edge's surroundings.
HWY_INLINE void add_beside(std::uint64_t some, const PlacedEdge& edge, PointCounts& counts) {
    const Float zero = hn::Zero(d), a = hn::Set(d, edge.a), b = hn::Set(d, edge.b), c = hn::Set(d, edge.c);
    const auto within = [&](Float value, float low, float high, float around) HWY_ATTR {
        return hn::And(hn::Ge(value, hn::Set(d, low - around)), hn::Le(value, hn::Set(d, high + around)));
    };
    const float beside = 4 * edge.wrong;
    for (; some; some &= some - 1) {
        const auto k = static_cast<std::size_t>(__builtin_ctzll(some));
        for (std::size_t j = 0; j < 16; j += hn::Lanes(d)) {
            const std::size_t i = 16 * k + j;
            const Float s = hn::Load(d, counts.s + i), t = hn::Load(d, counts.t + i);
            const Float side = hn::MulAdd(a, s, hn::MulAdd(b, t, c)), off = hn::Abs(side);
            const Mask in_range = hn::And(hn::Ge(t, hn::Set(d, edge.t_from)), hn::Lt(t, hn::Set(d, edge.t_to)));
            const Mask right = hn::Or(hn::Gt(s, hn::Set(d, edge.s_high + beside)),
                                      hn::And(hn::Gt(side, zero), hn::Ge(s, hn::Set(d, edge.s_low - beside))));
            add(hn::And(in_range, right), edge.step, counts.crossings + i);
            const Mask near = hn::And(hn::Le(off, hn::Set(d, edge.near)),
                                      hn::And(within(s, edge.s_low, edge.s_high, silhouette_near),
                                              within(t, edge.t_from, edge.t_to, silhouette_near)));
            if (hn::AllFalse(d, near)) continue;
            const Mask undecided = edge.tells ? hn::Le(off, hn::Set(d, edge.margin)) : near;
            const Mask unsure = hn::And(undecided, hn::And(within(s, edge.s_low, edge.s_high, beside),
                                                           within(t, edge.t_from, edge.t_to, beside)));
            const auto put = [&](std::uint16_t* bits, Mask mask)
                                 HWY_ATTR { bits[k] = static_cast<std::uint16_t>(bits[k] | bits_of(mask) << j); };
            put(counts.near, near);
            put(counts.close, hn::And(near, hn::Le(off, hn::Set(d, edge.close))));
            put(counts.unsure, unsure);
        }
    }
}

// Where an edge comes in from beyond the left side of the light, which it crosses at some t, points above are reached
// over it; what lies beyond is cut off.
HWY_INLINE void cut_at_border(const EdgeImages& images, std::size_t i, PlacedEdge& edge, PointCounts& counts) {
    const bool enters = images.s_from[i] < -border, leaves = images.s_to[i] < -border;
    if (enters == leaves) {
        if (enters) edge.t_to = edge.t_from; // all of it is beyond
        return;
    }
    const float at = (edge.a * border - edge.c) / edge.b;
    const float cut = at > edge.t_from ? std::min(at, edge.t_to) : edge.t_from;
    const std::uint64_t above = meeting(counts, -infinity, infinity, cut, infinity);
    add_in_range(above, cut, infinity, enters ? -edge.step : edge.step, counts);
    (enters ? edge.t_from : edge.t_to) = cut;
}

void count_crossings(const Pyramid& pyramid, const EdgeImages& images, const PointBlock& block, std::size_t packets,
                     PointCounts& counts) {
    place_points(pyramid, block, packets, counts);
    std::fill_n(counts.crossings, 16 * packets, 0);
    for (std::uint16_t* bits : {counts.near, counts.close, counts.unsure}) std::fill_n(bits, packets, std::uint16_t{0});
    for (std::size_t i = 0; i < images.count; ++i) {
        PlacedEdge edge = place_edge(images, i);
        if (edge.s_low < -border) cut_at_border(images, i, edge, counts);
        const float around = silhouette_near + 4 * edge.wrong;
        std::uint64_t beside = 0, right = 0;
        for (std::size_t k = 0; k < PointBlock::packets; k += hn::Lanes(d)) {
            const Mask level = hn::And(hn::Le(hn::Load(d, counts.t_low + k), hn::Set(d, edge.t_to + around)),
                                       hn::Ge(hn::Load(d, counts.t_high + k), hn::Set(d, edge.t_from - around)));
            const Mask reached =
                hn::And(level, hn::Ge(hn::Load(d, counts.s_high + k), hn::Set(d, edge.s_low - around)));
            const Mask beyond = hn::Gt(hn::Load(d, counts.s_low + k), hn::Set(d, edge.s_high + around));
            right |= std::uint64_t{bits_of(hn::And(reached, beyond))} << k;
            beside |= std::uint64_t{bits_of(hn::AndNot(beyond, reached))} << k;
        }
        add_in_range(right, edge.t_from, edge.t_to, edge.step, counts);
        add_beside(beside, edge, counts);
    }
}

void shade(const std::vector<OccluderGroup>& groups, const PointBlock& block, const PointCounts& counts,
           std::uint64_t packets, PacketVerdict* verdicts) {
    for (const OccluderGroup& group : groups)
        for (unsigned left = group.present; left; left &= left - 1) {
            const auto i = static_cast<unsigned>(__builtin_ctz(left));
            const std::uint64_t met = meeting(counts, group.a_low[i], group.a_high[i], group.b_low[i], group.b_high[i]);
            point_kernels().shade_packets(group, i, block, met & packets, verdicts);
        }
}

std::int32_t least(const PointCounts& counts, const std::uint16_t* eligible, std::size_t packets) {
    Integer low = hn::Set(whole, std::numeric_limits<std::int32_t>::max());
    for (std::size_t k = 0; k < packets; ++k)
        for (std::size_t j = 0; j < 16; j += hn::Lanes(d)) {
            const auto some = hn::RebindMask(whole, mask_of(static_cast<unsigned>(eligible[k]) >> j));
            low = hn::IfThenElse(some, hn::Min(low, hn::Load(whole, counts.crossings + 16 * k + j)), low);
        }
    return hn::GetLane(hn::MinOfLanes(whole, low));
}

unsigned above(const PointCounts& counts, std::size_t packet, std::int32_t value, unsigned& equal) {
    unsigned higher = 0;
    equal = 0;
    for (std::size_t j = 0; j < 16; j += hn::Lanes(d)) {
        const Integer count = hn::Load(whole, counts.crossings + 16 * packet + j), other = hn::Set(whole, value);
        higher |= bits_of(hn::RebindMask(d, hn::Gt(count, other))) << j;
        equal |= bits_of(hn::RebindMask(d, hn::Eq(count, other))) << j;
    }
    return higher;
}

const CrossingKernels* crossing_table() {
    static constexpr CrossingKernels functions{project, count_crossings, shade, least, above};
    return &functions;
}

} // namespace gnomon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon {

HWY_EXPORT(crossing_table);

const CrossingKernels& crossing_kernels() {
    static const CrossingKernels* const chosen = HWY_DYNAMIC_DISPATCH(crossing_table)();
    return *chosen;
}

void EdgeImages::resize(std::size_t room) {
    for (std::vector<float>* list : {&s_from, &t_from, &s_to, &t_to, &a, &b, &c, &margin, &wrong})
        list->resize(room + 16);
    step.resize(room + 16);
}

} // namespace gnomon
#endif
