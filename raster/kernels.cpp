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

void barycentrics(const SetupTriangle& t, const AttributePlanes& planes, int x, int y, std::uint64_t mask,
                  float* inverse_w, float* second, float* third) {
    const hn::CappedTag<double, block_side> d;
    const hn::Rebind<float, decltype(d)> f;
    constexpr std::size_t lanes = hn::MaxLanes(hn::CappedTag<double, block_side>());
    const double first = (x + 0.5) - t.x[0] * (1.0 / subpixels), anchor_y = t.y[0] * (1.0 / subpixels);
    hn::Vec<decltype(d)> columns[block_side / lanes];
    for (std::size_t p = 0; p < block_side / lanes; ++p)
        columns[p] = counted_from(d, first + static_cast<double>(p * lanes));
    for (int j = 0; mask; ++j, mask >>= 8) {
        if (!(mask & 0xff)) continue;
        const double up = (y + j + 0.5) - anchor_y;
        for (std::size_t p = 0; p < block_side / lanes; ++p) {
            const auto value = [&](const Plane& plane) {
                return hn::Add(hn::Set(d, plane.value + plane.dy * up), hn::Mul(hn::Set(d, plane.dx), columns[p]));
            };
            const std::size_t at = 8 * static_cast<std::size_t>(j) + p * lanes;
            const auto over_w = value(planes.inverse_w());
            const auto w = hn::Div(hn::Set(d, 1.0), over_w);
            const auto lanes_in = mask_of(f, (mask & 0xff) >> (p * lanes));
            hn::BlendedStore(hn::DemoteTo(f, over_w), lanes_in, f, inverse_w + at);
            hn::BlendedStore(hn::DemoteTo(f, hn::Mul(value(planes.second()), w)), lanes_in, f, second + at);
            hn::BlendedStore(hn::DemoteTo(f, hn::Mul(value(planes.third()), w)), lanes_in, f, third + at);
        }
    }
}

void varyings(const float* v0, const float* v1, const float* v2, std::size_t count, std::uint64_t mask,
              const float* second, const float* third, float* out) {
    const hn::CappedTag<float, 16> f;
    constexpr std::size_t lanes = hn::MaxLanes(hn::CappedTag<float, 16>());
    constexpr std::uint64_t all_lanes = (std::uint64_t{1} << lanes) - 1;
    for (std::size_t at = 0; mask; at += lanes, mask >>= lanes) {
        if (!(mask & all_lanes)) continue;
        const auto in = mask_of(f, mask & all_lanes);
        const auto b1 = hn::LoadU(f, second + at), b2 = hn::LoadU(f, third + at);
        for (std::size_t i = 0; i < count; ++i) {
            const auto d1 = hn::Set(f, v1[i] - v0[i]), d2 = hn::Set(f, v2[i] - v0[i]);
            const auto value = hn::Add(hn::Add(hn::Set(f, v0[i]), hn::Mul(b1, d1)), hn::Mul(b2, d2));
            hn::BlendedStore(value, in, f, out + 64 * i + at);
        }
    }
}

void fill_tile(std::int32_t* tile, std::int32_t word) {
    const hn::CappedTag<std::int32_t, patch_pixels> d;
    const auto words = hn::Set(d, word);
    for (std::size_t at = 0; at < tile_pixels; at += hn::Lanes(d)) hn::Store(words, d, tile + at);
}

// The words of one row in `lanes / 4` patches side by side, the first of which is at `patch`.
template <class D> HWY_INLINE hn::Vec<D> across_patches(D d, const std::int32_t* patch) {
#if HWY_TARGET != HWY_SCALAR
    constexpr std::size_t lanes = hn::MaxLanes(D());
    if constexpr (lanes > patch_side) {
        const hn::Half<D> half;
        // From an even number of patches to as many more is to the next block, but from one to the next in a block.
        constexpr std::size_t next = lanes == 2 * patch_side ? patch_pixels : block_pixels;
        return hn::Combine(d, across_patches(half, patch + next), across_patches(half, patch));
    } else
#endif
        return hn::LoadU(d, patch);
}

// Stores rows; words(x, y) gives a vector of them.
template <class Words>
HWY_INLINE void write_rows(int first, int last, std::byte* rows, std::size_t stride, bool stream, const Words& words) {
    const hn::CappedTag<std::int32_t, patch_pixels> d;
    constexpr auto lanes = static_cast<int>(hn::MaxLanes(hn::CappedTag<std::int32_t, patch_pixels>()));
    for (int y = first; y < last; ++y) {
        auto* to = reinterpret_cast<std::int32_t*>(rows + static_cast<std::size_t>(y) * stride);
        for (int x = 0; x < tile_side; x += lanes) {
            if (stream)
                hn::Stream(words(x, y), d, to + x);
            else
                hn::StoreU(words(x, y), d, to + x);
        }
    }
}

void store_rows(const std::int32_t* tile, int first, int last, std::byte* to, std::size_t stride, bool stream) {
    const hn::CappedTag<std::int32_t, patch_pixels> d;
    write_rows(first, last, to, stride, stream, [&](int x, int y) HWY_ATTR {
        return across_patches(d, tile + place_in_tile(x & -patch_side, y) + (x & (patch_side - 1)));
    });
}

void fill_rows(std::int32_t word, int first, int last, std::byte* to, std::size_t stride, bool stream) {
    const auto words = hn::Set(hn::CappedTag<std::int32_t, patch_pixels>(), word);
    write_rows(first, last, to, stride, stream, [&](int, int) HWY_ATTR { return words; });
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
    static constexpr Kernels kernels = {"avx512",  coverage,  depth,      barycentrics, varyings,
                                        test_d32f, fill_tile, store_rows, fill_rows};
#elif HWY_TARGET == HWY_AVX2
    static constexpr Kernels kernels = {"avx2",    coverage,  depth,      barycentrics, varyings,
                                        test_d32f, fill_tile, store_rows, fill_rows};
#else
    static constexpr Kernels kernels = {"plain",   coverage,  depth,      barycentrics, varyings,
                                        test_d32f, fill_tile, store_rows, fill_rows};
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
