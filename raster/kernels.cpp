#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/kernels.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include "raster/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::uint64_t every_pixel = ~std::uint64_t{0};

inline std::int32_t least(std::int32_t a, std::int32_t b) { return a < b ? a : b; }
inline std::int32_t most(std::int32_t a, std::int32_t b) { return a > b ? a : b; }

// The lanes of a mask as bits.
template <class D, class M> HWY_INLINE std::uint32_t bits_of(D d, M mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    return bytes[0];
}

std::uint64_t coverage(const TileEdges& edges, int x, int y, int first, int last) {
    const hn::CappedTag<std::int32_t, block_side> d;
    constexpr std::int32_t span = block_side - 1;
    std::uint64_t covered = every_pixel;
    for (int e = 0; e < 3; ++e) {
        const std::int32_t a = edges.a[e], b = edges.b[e];
        const std::int32_t corner = edges.base[e] + a * x + b * y;
        if (corner + span * (least(a, 0) + least(b, 0)) >= 0) continue;
        if (corner + span * (most(a, 0) + most(b, 0)) < 0) return 0;
        const auto ramp = hn::Mul(hn::Iota(d, 0), hn::Set(d, a));
        std::uint64_t outside = 0;
        std::int32_t row = corner + first * b;
        for (int j = first; j <= last; ++j, row += b)
            for (std::size_t i = 0; i < block_side; i += hn::Lanes(d)) {
                const auto value = hn::Add(ramp, hn::Set(d, row + a * static_cast<std::int32_t>(i)));
                const std::uint64_t negative = bits_of(d, hn::Lt(value, hn::Zero(d)));
                outside |= negative << (8 * static_cast<std::size_t>(j) + i);
            }
        covered &= ~outside;
    }
    return covered;
}

// The triangle's depth plane along rows of a block.
template <class D> struct DepthRows {
    D d;
    hn::Vec<D> dx, nearest, farthest, offset;
    double value, dy, anchor_y, first;

    HWY_INLINE DepthRows(D tag, const SetupTriangle& t, int x)
        : d(tag), dx(hn::Set(d, t.depth.dx)), nearest(hn::Set(d, t.depth_minimum)),
          farthest(hn::Set(d, t.depth_maximum)), offset(hn::Set(d, t.depth_offset)), value(t.depth.value),
          dy(t.depth.dy), anchor_y(t.anchor_y), first((x + 0.5) - t.anchor_x) {
    } // exact: multiples of 1/512 far below 2⁵³

    // Depths of pixels [i, i + lanes) of row y: (value + dy·(y − y0)) + dx·(x − x0).
    HWY_INLINE hn::Vec<D> at(int y, std::size_t i) const {
        const auto row = hn::Set(d, value + dy * ((y + 0.5) - anchor_y));
        const auto steps = hn::Iota(d, first + static_cast<double>(i));
        auto z = hn::Add(row, hn::Mul(dx, steps));
        z = hn::IfThenElse(hn::Gt(z, nearest), z, nearest);
        z = hn::Add(hn::IfThenElse(hn::Lt(z, farthest), z, farthest), offset);
        z = hn::IfThenElse(hn::Gt(z, hn::Zero(d)), z, hn::Zero(d));
        const auto one = hn::Set(d, 1.0);
        return hn::IfThenElse(hn::Lt(z, one), z, one);
    }
};

void depth(const SetupTriangle& t, int x, int y, std::uint64_t mask, double* out) {
    const hn::CappedTag<double, block_side> d;
    const DepthRows<decltype(d)> rows(d, t, x);
    for (int j = 0; mask; ++j, mask >>= 8) {
        if (!(mask & 0xff)) continue;
        for (std::size_t i = 0; i < block_side; i += hn::Lanes(d)) hn::StoreU(rows.at(y + j, i), d, out + 8 * j + i);
    }
}

template <Compare test, class D, class V> HWY_INLINE hn::Mask<D> passes(D d, V fresh, V stored) {
    if constexpr (test == Compare::Less)
        return hn::Lt(fresh, stored);
    else if constexpr (test == Compare::LessEqual)
        return hn::Le(fresh, stored);
    else if constexpr (test == Compare::Greater)
        return hn::Gt(fresh, stored);
    else if constexpr (test == Compare::GreaterEqual)
        return hn::Ge(fresh, stored);
    else if constexpr (test == Compare::Equal)
        return hn::Eq(fresh, stored);
    else if constexpr (test == Compare::NotEqual)
        return hn::Ne(fresh, stored);
    else if constexpr (test == Compare::Always)
        return hn::Eq(fresh, fresh);
    else
        return hn::FirstN(d, 0);
}

template <Compare test>
std::uint64_t test_rows(const SetupTriangle& t, int x, int y, std::uint64_t mask, float* stored, std::size_t stride,
                        bool write) {
    const hn::CappedTag<double, block_side> d;
    const hn::Rebind<float, decltype(d)> f;
    const DepthRows<decltype(d)> rows(d, t, x);
    std::uint64_t passed = 0;
    for (int j = 0; mask; ++j, mask >>= 8, stored += stride) {
        if (!(mask & 0xff)) continue;
        for (std::size_t i = 0; i < block_side; i += hn::Lanes(d)) {
            const std::uint8_t lanes[8] = {static_cast<std::uint8_t>((mask & 0xff) >> i)};
            const auto fresh = hn::DemoteTo(f, rows.at(y + j, i));
            const auto old = hn::LoadU(f, stored + i);
            const auto pass = hn::And(passes<test>(f, fresh, old), hn::LoadMaskBits(f, lanes));
            if (write) hn::BlendedStore(fresh, pass, f, stored + i);
            passed |= static_cast<std::uint64_t>(bits_of(f, pass)) << (8 * static_cast<std::size_t>(j) + i);
        }
    }
    return passed;
}

std::uint64_t test_d32f(const SetupTriangle& t, int x, int y, std::uint64_t mask, float* stored, std::size_t stride,
                        Compare test, bool write) {
    switch (test) {
    case Compare::Never:
        return 0;
    case Compare::Less:
        return test_rows<Compare::Less>(t, x, y, mask, stored, stride, write);
    case Compare::Equal:
        return test_rows<Compare::Equal>(t, x, y, mask, stored, stride, write);
    case Compare::LessEqual:
        return test_rows<Compare::LessEqual>(t, x, y, mask, stored, stride, write);
    case Compare::Greater:
        return test_rows<Compare::Greater>(t, x, y, mask, stored, stride, write);
    case Compare::NotEqual:
        return test_rows<Compare::NotEqual>(t, x, y, mask, stored, stride, write);
    case Compare::GreaterEqual:
        return test_rows<Compare::GreaterEqual>(t, x, y, mask, stored, stride, write);
    case Compare::Always:
        return test_rows<Compare::Always>(t, x, y, mask, stored, stride, write);
    }
    return 0;
}

const Kernels* table() {
#if HWY_TARGET == HWY_AVX3
    static constexpr Kernels kernels = {"avx512", coverage, depth, test_d32f};
#elif HWY_TARGET == HWY_AVX2
    static constexpr Kernels kernels = {"avx2", coverage, depth, test_d32f};
#else
    static constexpr Kernels kernels = {"plain", coverage, depth, test_d32f};
#endif
    return &kernels;
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>

#include "core/error.h"

namespace gnomon::detail {
namespace {

HWY_EXPORT(table);

const Kernels* choose() {
    const char* wanted = std::getenv("GNOMON_ISA");
    if (!wanted || !*wanted) return HWY_DYNAMIC_DISPATCH(table)();
    const std::string_view name = wanted;
    const std::int64_t baseline = HWY_STATIC_TARGET;
    const std::int64_t target = name == "avx512"  ? HWY_AVX3
                                : name == "avx2"  ? HWY_AVX2
                                : name == "plain" ? baseline
                                                  : 0;
    if (!target) throw UsageError(fmt::format("GNOMON_ISA is '{}', but must be avx512, avx2 or plain", name));
    if (!(hwy::SupportedTargets() & target) && target != baseline)
        throw UsageError(fmt::format("GNOMON_ISA is '{}', which this machine does not have", name));
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    const Kernels* chosen = HWY_DYNAMIC_DISPATCH(table)();
    hwy::SetSupportedTargetsForTest(0);
    return chosen;
}

} // namespace

const Kernels& kernels() {
    static const Kernels* chosen = choose();
    return *chosen;
}

} // namespace gnomon::detail
#endif
