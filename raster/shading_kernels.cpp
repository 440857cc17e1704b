#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/shading_kernels.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "raster/kernels-inl.h"
#include "raster/shading_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A mask over a block's places in the tile as one over its pixels row by row: nibble by nibble, those of the left and
// of the right patch take turns.
HWY_INLINE std::uint64_t row_by_row(std::uint64_t places) {
    const auto swap = [](std::uint64_t v, std::uint64_t low, int shift) {
        return (v & ~(low | low << shift)) | (v & low) << shift | (v >> shift & low);
    };
    return swap(swap(places, 0x0000ff000000ff00ull, 8), 0x00f000f000f000f0ull, 4);
}

std::size_t find_runs(const std::uint32_t* ids, std::uint32_t none, std::uint32_t* found, std::uint64_t* masks,
                      std::uint8_t* run) {
    const hn::CappedTag<std::uint32_t, 16> u;
    const hn::CappedTag<std::uint8_t, block_pixels> b;
    constexpr std::size_t lanes = hn::MaxLanes(u), bytes = hn::MaxLanes(b);
    hn::Vec<decltype(u)> id[block_pixels / lanes];
    for (std::size_t p = 0; p < block_pixels / lanes; ++p) id[p] = hn::Load(u, ids + p * lanes);
    for (std::size_t at = 0; at < block_pixels; at += bytes) hn::StoreU(hn::Zero(b), b, run + at);
    const auto places_of = [&](std::uint32_t wanted) {
        std::uint64_t places = 0;
        for (std::size_t p = 0; p < block_pixels / lanes; ++p)
            places |= bits_of(u, hn::Eq(id[p], hn::Set(u, wanted))) << (p * lanes);
        return places;
    };
    std::size_t count = 0;
    const auto add = [&](std::uint32_t wanted, std::uint64_t places) {
        found[count] = wanted;
        masks[count] = row_by_row(places);
        for (std::size_t at = 0; at < block_pixels; at += bytes) {
            std::uint8_t bits[8];
            for (std::size_t k = 0; k < 8; ++k) bits[k] = static_cast<std::uint8_t>((masks[count] >> at) >> (8 * k));
            hn::BlendedStore(hn::Set(b, static_cast<std::uint8_t>(count)), hn::LoadMaskBits(b, bits), b, run + at);
        }
        ++count;
    };
    for (std::uint64_t rest = ~places_of(none); rest;) { // from both ends, which do not wait for each other
        const std::uint32_t low = ids[hwy::Num0BitsBelowLS1Bit_Nonzero64(rest)],
                            high = ids[63 - hwy::Num0BitsAboveMS1Bit_Nonzero64(rest)];
        const std::uint64_t low_places = places_of(low), high_places = places_of(high);
        rest &= ~(low_places | high_places);
        add(low, low_places);
        if (high != low) add(high, high_places);
    }
    return count;
}

void planes(const PlaneInputs& in, std::size_t count, AttributePlanes* out) {
    const hn::CappedTag<double, 8> d;
    const hn::Rebind<std::int32_t, decltype(d)> i;
    const hn::Rebind<float, decltype(d)> f;
    using V = hn::Vec<decltype(d)>;
    constexpr std::size_t lanes = hn::MaxLanes(d);
    for (std::size_t at = 0; at < count; at += lanes) {
        const auto edge = [&](const std::int32_t* from) {
            return hn::Mul(hn::PromoteTo(d, hn::Load(i, from + at)), hn::Set(d, 1.0 / subpixels));
        };
        const V e1x = edge(in.e1x), e1y = edge(in.e1y), e2x = edge(in.e2x), e2y = edge(in.e2y);
        const V area = hn::Sub(hn::Mul(e1x, e2y), hn::Mul(e2x, e1y));
        const V second = hn::PromoteTo(d, hn::Load(i, in.second + at)),
                third = hn::PromoteTo(d, hn::Load(i, in.third + at));
        V value[3][3]; // of each plane at each corner
        for (std::size_t c = 0; c < 3; ++c) {
            const V corner = hn::Set(d, static_cast<double>(c));
            value[0][c] = hn::Div(hn::Set(d, 1.0), hn::PromoteTo(d, hn::Load(f, in.w[c] + at)));
            value[1][c] = hn::IfThenElseZero(hn::Eq(second, corner), value[0][c]);
            value[2][c] = hn::IfThenElseZero(hn::Eq(third, corner), value[0][c]);
        }
        V dx[3], dy[3];
        for (std::size_t p = 0; p < 3; ++p) {
            const V d1 = hn::Sub(value[p][1], value[p][0]), d2 = hn::Sub(value[p][2], value[p][0]);
            dx[p] = hn::Div(hn::Sub(hn::Mul(d1, e2y), hn::Mul(d2, e1y)), area);
            dy[p] = hn::Div(hn::Sub(hn::Mul(d2, e1x), hn::Mul(d1, e2x)), area);
        }
        alignas(64) double made[3][4 * lanes];
        const V zero = hn::Zero(d);
        hn::StoreInterleaved4(value[0][0], value[1][0], value[2][0], zero, d, made[0]);
        hn::StoreInterleaved4(dx[0], dx[1], dx[2], zero, d, made[1]);
        hn::StoreInterleaved4(dy[0], dy[1], dy[2], zero, d, made[2]);
        const hn::CappedTag<double, 4> q;
        for (std::size_t k = 0; k < lanes; ++k)
            for (std::size_t c = 0; c < 4; c += hn::Lanes(q)) {
                hn::Store(hn::Load(q, made[0] + 4 * k + c), q, out[at + k].value + c);
                hn::Store(hn::Load(q, made[1] + 4 * k + c), q, out[at + k].dx + c);
                hn::Store(hn::Load(q, made[2] + 4 * k + c), q, out[at + k].dy + c);
            }
    }
}

// 1/w, and the second and third coordinate over w, as floats without the w.
template <class D, class V>
HWY_INLINE void store_perspective(D d, V over_w, V second, V third, FragmentBlock& block, std::size_t at) {
    const hn::Rebind<float, D> f;
    const auto w = hn::Div(hn::Set(d, 1.0), over_w);
    hn::StoreU(hn::DemoteTo(f, over_w), f, block.inverse_w.data() + at);
    hn::StoreU(hn::DemoteTo(f, hn::Mul(second, w)), f, block.second.data() + at);
    hn::StoreU(hn::DemoteTo(f, hn::Mul(third, w)), f, block.third.data() + at);
}

void barycentrics(FragmentBlock& block, std::size_t runs) {
    const hn::CappedTag<double, block_side> d;
    constexpr std::size_t lanes = hn::MaxLanes(d);
    for (std::size_t at = 0; at < block_pixels; at += lanes) { // a row, or a part of it
        const ivec2 pixel = block.pixel(at);
        hn::Vec<decltype(d)> value[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        for (std::size_t k = 0; k < runs; ++k) {
            const FragmentRun& run = block.runs[k];
            const std::uint64_t pixels = run.mask >> at & ((std::uint64_t{1} << lanes) - 1);
            if (!pixels) continue;
            const AttributePlanes& planes = *run.planes;
            const auto in = mask_of(d, pixels);
            const auto right = counted_from(d, (pixel.x + 0.5) - planes.anchor_x); // exact, as in DepthRows
            const double up = (pixel.y + 0.5) - planes.anchor_y;
            for (std::size_t p = 0; p < 3; ++p) {
                const auto row = hn::Set(d, planes.value[p] + planes.dy[p] * up);
                value[p] = hn::IfThenElse(in, hn::Add(row, hn::Mul(hn::Set(d, planes.dx[p]), right)), value[p]);
            }
        }
        store_perspective(d, value[0], value[1], value[2], block, at);
    }
}

// Sixty-four times eight values as eight times sixty-four, the first `count` of them.
HWY_INLINE void transpose(const float* from, std::size_t count, float* to) {
#if HWY_TARGET == HWY_SCALAR
    for (std::size_t k = 0; k < count; ++k)
        for (std::size_t at = 0; at < block_pixels; ++at) to[block_pixels * k + at] = from[8 * at + k];
#else
    const hn::CappedTag<float, 16> f;
    constexpr std::size_t lanes = hn::MaxLanes(f);
    for (std::size_t at = 0; at < block_pixels; at += lanes) { // each load takes half as many pixels as it has lanes
        hn::Vec<decltype(f)> low[4], high[4];
        hn::LoadInterleaved4(f, from + 8 * at, low[0], low[1], low[2], low[3]);
        hn::LoadInterleaved4(f, from + 8 * at + 4 * lanes, high[0], high[1], high[2], high[3]);
        for (std::size_t k = 0; k < 4; ++k) {
            if (k < count) hn::StoreU(hn::ConcatEven(f, high[k], low[k]), f, to + block_pixels * k + at);
            if (k + 4 < count) hn::StoreU(hn::ConcatOdd(f, high[k], low[k]), f, to + block_pixels * (k + 4) + at);
        }
    }
#endif
}

void interpolate(FragmentBlock& block, std::size_t count) {
    const hn::CappedTag<double, 4> q;
    alignas(64) double linear[4 * block_pixels];
    for (std::size_t at = 0; at < block_pixels; ++at) {
        const AttributePlanes& planes = *block.run_of(at).planes;
        const ivec2 pixel = block.pixel(at);
        const auto right = hn::Set(q, (pixel.x + 0.5) - planes.anchor_x), // exact, as in DepthRows
            up = hn::Set(q, (pixel.y + 0.5) - planes.anchor_y);
        for (std::size_t p = 0; p < 4; p += hn::Lanes(q)) {
            const auto row = hn::Add(hn::Load(q, planes.value + p), hn::Mul(hn::Load(q, planes.dy + p), up));
            hn::Store(hn::Add(row, hn::Mul(hn::Load(q, planes.dx + p), right)), q, linear + 4 * at + p);
        }
    }
    const hn::CappedTag<double, 8> d;
    for (std::size_t at = 0; at < block_pixels; at += hn::Lanes(d)) {
        hn::Vec<decltype(d)> over_w, second, third, none;
        hn::LoadInterleaved4(d, linear + 4 * at, over_w, second, third, none);
        store_perspective(d, over_w, second, third, block, at);
    }
    const hn::CappedTag<float, 8> e;
    alignas(64) float values[8 * block_pixels];
    for (std::size_t first = 0; first < count; first += 8) {
        for (std::size_t at = 0; at < block_pixels; ++at) {
            const CornerVaryings& corners = block.run_of(at).corners;
            const auto b1 = hn::Set(e, block.second[at]), b2 = hn::Set(e, block.third[at]);
            for (std::size_t k = 0; k < 8; k += hn::Lanes(e)) {
                const auto v0 = hn::LoadU(e, corners[0] + first + k), v1 = hn::LoadU(e, corners[1] + first + k),
                           v2 = hn::LoadU(e, corners[2] + first + k);
                const auto value = hn::Add(hn::Add(v0, hn::Mul(b1, hn::Sub(v1, v0))), hn::Mul(b2, hn::Sub(v2, v0)));
                hn::Store(value, e, values + 8 * at + k);
            }
        }
        transpose(values, count - first, block.varyings[first].data());
    }
}

void interleave(const std::array<float, 64>* channels, vec4* texels, std::size_t stride) {
    const hn::CappedTag<float, block_side> f;
    for (std::size_t j = 0; j < block_side; ++j)
        for (std::size_t i = 0; i < block_side; i += hn::Lanes(f)) {
            const auto channel = [&](std::size_t c) { return hn::LoadU(f, channels[c].data() + block_side * j + i); };
            hn::StoreInterleaved4(channel(0), channel(1), channel(2), channel(3), f, &texels[stride * j + i].x);
        }
}

void stream(const void* from, void* to, std::size_t bytes) {
    const hn::CappedTag<std::uint32_t, 16> u;
    const auto* words = static_cast<const std::uint32_t*>(from);
    auto* out = static_cast<std::uint32_t*>(to);
    for (std::size_t k = 0; k < bytes / 4; k += hn::Lanes(u)) hn::Stream(hn::LoadU(u, words + k), u, out + k);
}

const ShadingKernels* shading_table() {
    static constexpr ShadingKernels kernels = {find_runs, planes, barycentrics, interpolate, interleave, stream};
    return &kernels;
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "raster/isa.h"

namespace gnomon::detail {
HWY_EXPORT(shading_table);

const ShadingKernels& shading_kernels() {
    static const ShadingKernels* chosen = for_chosen_isa([] { return HWY_DYNAMIC_DISPATCH(shading_table)(); });
    return *chosen;
}
} // namespace gnomon::detail
#endif
