#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/kernels.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#include "raster/kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

std::uint64_t coverage(const TileEdges& edges, int x, int y, int first, int last) {
    return covered_pixels(edges, x, y, first, last);
}

void depth(const SetupTriangle& t, int x, int y, std::uint64_t mask, double* out) {
    const hn::CappedTag<double, block_side> d;
    const DepthRows<decltype(d)> rows(d, t, x);
    for (int j = 0; mask; ++j, mask >>= 8) {
        if (!(mask & 0xff)) continue;
        const double row = rows.row(y + j);
        for (std::size_t p = 0; p < rows.parts; ++p) hn::StoreU(rows.at(row, p), d, out + 8 * j + p * hn::Lanes(d));
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
        const double row = rows.row(y + j);
        for (std::size_t i = 0; i < block_side; i += hn::Lanes(d)) {
            const std::uint8_t lanes[8] = {static_cast<std::uint8_t>((mask & 0xff) >> i)};
            const auto fresh = hn::DemoteTo(f, rows.at(row, i / hn::Lanes(d)));
            const auto old = hn::LoadU(f, stored + i);
            const auto pass = hn::And(passes<test>(f, fresh, old), hn::LoadMaskBits(f, lanes));
            if (write) hn::BlendedStore(fresh, pass, f, stored + i);
            passed |= bits_of(f, pass) << (8 * static_cast<std::size_t>(j) + i);
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
#include "raster/isa.h"

namespace gnomon::detail {
HWY_EXPORT(table);

const Kernels& kernels() {
    static const Kernels* chosen = for_chosen_isa([] { return HWY_DYNAMIC_DISPATCH(table)(); });
    return *chosen;
}
} // namespace gnomon::detail
#endif
