#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raytrace/point_block.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include "raytrace/point_block.h"
#include "raytrace/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::HWY_NAMESPACE {

constexpr float beyond_all = 1e30f;

void aim_points(const Pyramid& pyramid, const float* x, const float* y, const float* z, std::size_t packets,
                PointBlock& block) {
    const Vector origin = set(pyramid.origin), along_a = set(pyramid.to_a), along_b = set(pyramid.to_b);
    const Float center_a = hn::Set(d, pyramid.center_a), center_b = hn::Set(d, pyramid.center_b);
    for (std::size_t k = 0; k < 16 * packets; k += hn::Lanes(d)) {
        const Vector way = Vector{hn::LoadU(d, x + k), hn::LoadU(d, y + k), hn::LoadU(d, z + k)} - origin;
        hn::Store(way.x, d, block.way[0] + k);
        hn::Store(way.y, d, block.way[1] + k);
        hn::Store(way.z, d, block.way[2] + k);
        hn::Store(hn::Sub(dot(way, along_a), center_a), d, block.a + k);
        hn::Store(hn::Sub(dot(way, along_b), center_b), d, block.b + k);
    }
}

PointRange range_of(const PointBlock& block, std::size_t packet, unsigned open) {
    Float a_low = hn::Set(d, beyond_all), b_low = a_low, a_high = hn::Neg(a_low), b_high = a_high;
    for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
        const Mask lanes = mask_of(open >> i);
        const Float a = hn::Load(d, block.a + 16 * packet + i), b = hn::Load(d, block.b + 16 * packet + i);
        a_low = hn::IfThenElse(lanes, hn::Min(a_low, a), a_low),
        a_high = hn::IfThenElse(lanes, hn::Max(a_high, a), a_high);
        b_low = hn::IfThenElse(lanes, hn::Min(b_low, b), b_low),
        b_high = hn::IfThenElse(lanes, hn::Max(b_high, b), b_high);
    }
    return {hn::GetLane(hn::MinOfLanes(d, a_low)), hn::GetLane(hn::MaxOfLanes(d, a_high)),
            hn::GetLane(hn::MinOfLanes(d, b_low)), hn::GetLane(hn::MaxOfLanes(d, b_high))};
}

// Which of the ranges from `first` on meet another one.
HWY_INLINE unsigned meeting(const float* a_low, const float* a_high, const float* b_low, const float* b_high,
                            const PointRange& range) {
    const Mask in_a = hn::And(hn::Le(hn::LoadU(d, a_low), hn::Set(d, range.a_high)),
                              hn::Ge(hn::LoadU(d, a_high), hn::Set(d, range.a_low)));
    const Mask in_b = hn::And(hn::Le(hn::LoadU(d, b_low), hn::Set(d, range.b_high)),
                              hn::Ge(hn::LoadU(d, b_high), hn::Set(d, range.b_low)));
    return bits_of(hn::And(in_a, in_b));
}

std::size_t reach(const TouchedBoxes& boxes, const PointRange& range, std::size_t most, std::uint32_t* reached) {
    std::size_t count = 0;
    for (std::size_t first = 0; first < boxes.count; first += hn::Lanes(d)) {
        unsigned met =
            meeting(&boxes.a_low[first], &boxes.a_high[first], &boxes.b_low[first], &boxes.b_high[first], range);
        for (; met; met &= met - 1) {
            if (count == most) return most + 1;
            reached[count++] = boxes.box[first + static_cast<unsigned>(__builtin_ctz(met))];
        }
    }
    return count;
}

// One triangle beside all points of a packet.
HWY_INLINE void shade_triangle(const OccluderGroup& group, unsigned i, const PointBlock& block, std::size_t packet,
                               PacketVerdict& verdict) {
    Vector edge[3];
    for (int k = 0; k < 3; ++k) edge[k] = set({group.edge[k][0][i], group.edge[k][1][i], group.edge[k][2][i]});
    const Float margin = hn::Set(d, group.margin[i]), minus_margin = hn::Neg(margin);
    unsigned hidden = 0, inside = 0, outside = 0;
    for (std::size_t j = 0; j < 16; j += hn::Lanes(d)) {
        const std::size_t k = 16 * packet + j;
        const Vector way{hn::Load(d, block.way[0] + k), hn::Load(d, block.way[1] + k), hn::Load(d, block.way[2] + k)};
        const Float v0 = dot(edge[0], way), v1 = dot(edge[1], way), v2 = dot(edge[2], way);
        const Float low = hn::Min(hn::Min(v0, v1), v2), high = hn::Max(hn::Max(v0, v1), v2);
        hidden |= bits_of(hn::Or(hn::Gt(low, margin), hn::Lt(high, minus_margin))) << j;
        inside |= bits_of(hn::Ge(low, minus_margin)) << j;
        outside |= bits_of(hn::Le(high, margin)) << j;
    }
    if (group.nearer >> i & 1u) verdict.hidden |= hidden;
    verdict.possible |= (group.positive >> i & 1u ? inside : 0u) | (group.negative >> i & 1u ? outside : 0u);
}

void shade_packets(const OccluderGroup& group, unsigned triangle, const PointBlock& block, std::uint64_t packets,
                   PacketVerdict* verdicts) {
    for (; packets; packets &= packets - 1) {
        const auto k = static_cast<std::size_t>(__builtin_ctzll(packets));
        shade_triangle(group, triangle, block, k, verdicts[k]);
    }
}

// One point of the light beside the triangles `some` of a group.
HWY_INLINE void shade_point(const OccluderGroup& group, unsigned some, const PointBlock& block, std::size_t packet,
                            unsigned point, PacketVerdict& verdict) {
    const std::size_t k = 16 * packet + point;
    const Vector way = set({block.way[0][k], block.way[1][k], block.way[2][k]});
    unsigned hit = 0, inside = 0, outside = 0;
    for (std::size_t t = 0; t < cluster_size; t += hn::Lanes(d)) {
        const Float margin = hn::Load(d, group.margin + t), minus_margin = hn::Neg(margin);
        Float value[3];
        for (int e = 0; e < 3; ++e)
            value[e] = dot({hn::Load(d, group.edge[e][0] + t), hn::Load(d, group.edge[e][1] + t),
                            hn::Load(d, group.edge[e][2] + t)},
                           way);
        const Float low = hn::Min(hn::Min(value[0], value[1]), value[2]);
        const Float high = hn::Max(hn::Max(value[0], value[1]), value[2]);
        hit |= bits_of(hn::Or(hn::Gt(low, margin), hn::Lt(high, minus_margin))) << t;
        inside |= bits_of(hn::Ge(low, minus_margin)) << t;
        outside |= bits_of(hn::Le(high, margin)) << t;
    }
    verdict.hidden |= ((hit & some & group.nearer) != 0 ? 1u : 0u) << point;
    const unsigned maybe = (inside & group.positive) | (outside & group.negative);
    verdict.possible |= ((maybe & some) != 0 ? 1u : 0u) << point;
}

void shade(const OccluderGroup& group, const PointBlock& block, std::size_t packet, const PointRange& range,
           unsigned open, PacketVerdict& verdict) {
    unsigned met = 0;
    for (std::size_t t = 0; t < cluster_size; t += hn::Lanes(d))
        met |= meeting(group.a_low + t, group.a_high + t, group.b_low + t, group.b_high + t, range) << t;
    met &= group.present;
    if (__builtin_popcount(met) <= __builtin_popcount(open)) {
        for (; met; met &= met - 1)
            shade_triangle(group, static_cast<unsigned>(__builtin_ctz(met)), block, packet, verdict);
    } else {
        for (; open; open &= open - 1)
            shade_point(group, met, block, packet, static_cast<unsigned>(__builtin_ctz(open)), verdict);
    }
}

const PointKernels* point_table() {
    static constexpr PointKernels functions{aim_points, range_of, reach, shade_packets, shade};
    return &functions;
}

} // namespace gnomon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace gnomon {

HWY_EXPORT(point_table);

const PointKernels& point_kernels() {
    static const PointKernels* const chosen = HWY_DYNAMIC_DISPATCH(point_table)();
    return *chosen;
}

} // namespace gnomon
#endif
