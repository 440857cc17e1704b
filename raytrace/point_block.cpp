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
    block.open = 0;
    for (std::size_t packet = 0; packet < packets; ++packet) {
        Float a_low = hn::Set(d, beyond_all), b_low = a_low, a_high = hn::Neg(a_low), b_high = a_high;
        for (std::size_t k = 16 * packet; k < 16 * packet + 16; k += hn::Lanes(d)) {
            const Vector way = Vector{hn::LoadU(d, x + k), hn::LoadU(d, y + k), hn::LoadU(d, z + k)} - origin;
            hn::Store(way.x, d, block.way[0] + k);
            hn::Store(way.y, d, block.way[1] + k);
            hn::Store(way.z, d, block.way[2] + k);
            const Float a = hn::Sub(dot(way, along_a), center_a), b = hn::Sub(dot(way, along_b), center_b);
            hn::Store(a, d, block.a + k);
            hn::Store(b, d, block.b + k);
            a_low = hn::Min(a_low, a), a_high = hn::Max(a_high, a);
            b_low = hn::Min(b_low, b), b_high = hn::Max(b_high, b);
        }
        block.a_low[packet] = hn::GetLane(hn::MinOfLanes(d, a_low));
        block.a_high[packet] = hn::GetLane(hn::MaxOfLanes(d, a_high));
        block.b_low[packet] = hn::GetLane(hn::MinOfLanes(d, b_low));
        block.b_high[packet] = hn::GetLane(hn::MaxOfLanes(d, b_high));
        block.hidden[packet] = block.possible[packet] = 0;
        block.open |= std::uint64_t{block.facing[packet] != 0} << packet;
    }
}

// Bit k: the ranges meet those of packet k.
HWY_INLINE std::uint64_t meeting(float a_low, float a_high, float b_low, float b_high, const PointBlock& block) {
    std::uint64_t met = 0;
    for (std::size_t k = 0; k < PointBlock::packets; k += hn::Lanes(d)) {
        const Mask in_a = hn::And(hn::Le(hn::Load(d, block.a_low + k), hn::Set(d, a_high)),
                                  hn::Ge(hn::Load(d, block.a_high + k), hn::Set(d, a_low)));
        const Mask in_b = hn::And(hn::Le(hn::Load(d, block.b_low + k), hn::Set(d, b_high)),
                                  hn::Ge(hn::Load(d, block.b_high + k), hn::Set(d, b_low)));
        met |= std::uint64_t{bits_of(hn::And(in_a, in_b))} << k;
    }
    return met;
}

std::size_t reach(const TouchedBox& box, const PointBlock& block, ReachedPoints& reached) {
    const std::uint64_t met = meeting(box.a_low, box.a_high, box.b_low, box.b_high, block) & block.open;
    const Float a_low = hn::Set(d, box.a_low), a_high = hn::Set(d, box.a_high), b_low = hn::Set(d, box.b_low),
                b_high = hn::Set(d, box.b_high);
    std::size_t count = 0;
    reached.packets = 0;
    for (std::uint64_t rest = met; rest; rest &= rest - 1) {
        const auto packet = static_cast<std::size_t>(__builtin_ctzll(rest));
        unsigned within = 0;
        for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
            const Float a = hn::Load(d, block.a + 16 * packet + i), b = hn::Load(d, block.b + 16 * packet + i);
            const Mask in_a = hn::And(hn::Ge(a, a_low), hn::Le(a, a_high));
            const Mask in_b = hn::And(hn::Ge(b, b_low), hn::Le(b, b_high));
            within |= bits_of(hn::And(in_a, in_b)) << i;
        }
        within &= block.facing[packet] & ~static_cast<unsigned>(block.hidden[packet]);
        if (!within) continue;
        reached.packets |= std::uint64_t{1} << packet;
        reached.points[packet] = static_cast<std::uint16_t>(within);
        count += static_cast<std::size_t>(__builtin_popcount(within));
    }
    return count;
}

struct Verdict {
    unsigned hidden, possible;
};
HWY_INLINE Verdict shade_packet(const Vector* edge, Float margin, std::size_t packet, const PointBlock& block) {
    Verdict verdict{0, 0};
    const Float minus_margin = hn::Neg(margin);
    for (std::size_t i = 0; i < 16; i += hn::Lanes(d)) {
        const std::size_t k = 16 * packet + i;
        const Vector way{hn::Load(d, block.way[0] + k), hn::Load(d, block.way[1] + k), hn::Load(d, block.way[2] + k)};
        const Float v0 = dot(edge[0], way), v1 = dot(edge[1], way), v2 = dot(edge[2], way);
        const Float low = hn::Min(hn::Min(v0, v1), v2), high = hn::Max(hn::Max(v0, v1), v2);
        const Mask hit = hn::Or(hn::Gt(low, margin), hn::Lt(high, minus_margin));
        const Mask maybe = hn::Or(hn::Ge(low, minus_margin), hn::Le(high, margin));
        verdict.hidden |= bits_of(hit) << i;
        verdict.possible |= bits_of(maybe) << i;
    }
    return verdict;
}

void shade_triangles(const OccluderGroup& group, const ReachedPoints& reached, PointBlock& block) {
    for (unsigned rest = group.present; rest; rest &= rest - 1) {
        const auto i = static_cast<unsigned>(__builtin_ctz(rest));
        std::uint64_t met = meeting(group.a_low[i], group.a_high[i], group.b_low[i], group.b_high[i], block);
        met &= reached.packets & block.open;
        if (!met) continue;
        Vector edge[3];
        for (int k = 0; k < 3; ++k) edge[k] = set({group.edge[k][0][i], group.edge[k][1][i], group.edge[k][2][i]});
        const Float margin = hn::Set(d, group.margin[i]);
        const bool nearer = group.nearer >> i & 1u;
        for (; met; met &= met - 1) {
            const auto k = static_cast<std::size_t>(__builtin_ctzll(met));
            const Verdict verdict = shade_packet(edge, margin, k, block);
            block.possible[k] = static_cast<std::uint16_t>(block.possible[k] | verdict.possible);
            if (nearer) block.hidden[k] = static_cast<std::uint16_t>(block.hidden[k] | verdict.hidden);
            if (!(block.facing[k] & ~block.hidden[k])) block.open &= ~(std::uint64_t{1} << k);
        }
    }
}

void shade_points(const OccluderGroup& group, const ReachedPoints& reached, PointBlock& block) {
    for (std::uint64_t packets = reached.packets; packets; packets &= packets - 1) {
        const auto packet = static_cast<std::size_t>(__builtin_ctzll(packets));
        unsigned hidden = 0, possible = 0;
        for (unsigned rest = reached.points[packet]; rest; rest &= rest - 1) {
            const auto i = static_cast<std::size_t>(__builtin_ctz(rest));
            const std::size_t k = 16 * packet + i;
            const Vector way = set({block.way[0][k], block.way[1][k], block.way[2][k]});
            unsigned hit = 0, maybe = 0;
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
                maybe |= bits_of(hn::Or(hn::Ge(low, minus_margin), hn::Le(high, margin))) << t;
            }
            hidden |= ((hit & group.present & group.nearer) != 0 ? 1u : 0u) << i;
            possible |= ((maybe & group.present) != 0 ? 1u : 0u) << i;
        }
        block.possible[packet] = static_cast<std::uint16_t>(block.possible[packet] | possible);
        block.hidden[packet] = static_cast<std::uint16_t>(block.hidden[packet] | hidden);
        if (!(block.facing[packet] & ~block.hidden[packet])) block.open &= ~(std::uint64_t{1} << packet);
    }
}

const PointKernels* point_table() {
    static constexpr PointKernels functions{aim_points, reach, shade_triangles, shade_points};
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
