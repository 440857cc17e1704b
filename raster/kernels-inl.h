// Pieces of the kernels, included once for each instruction set.

#if defined(GNOMON_KERNELS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_KERNELS_INL
#undef GNOMON_KERNELS_INL
#else
#define GNOMON_KERNELS_INL
#endif

#include <hwy/highway.h>

#include "raster/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::uint64_t every_pixel = ~std::uint64_t{0};

HWY_INLINE std::int32_t least(std::int32_t a, std::int32_t b) { return a < b ? a : b; }
HWY_INLINE std::int32_t most(std::int32_t a, std::int32_t b) { return a > b ? a : b; }

// The lanes of a mask as bits, and back.
template <class D, class M> HWY_INLINE std::uint64_t bits_of(D d, M mask) {
#if HWY_TARGET == HWY_AVX3
    (void)d;
    return mask.raw;
#else
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(d, mask, bytes);
    return bytes[0] | static_cast<std::uint64_t>(bytes[1]) << 8;
#endif
}
template <class D> HWY_INLINE hn::Mask<D> mask_of(D d, std::uint64_t bits) {
    const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8)};
    return hn::LoadMaskBits(d, bytes);
}

// `first` and the numbers after it, for a first that is not known when compiling: hn::Iota() takes the way over memory.
template <class D> HWY_INLINE hn::Vec<D> counted_from(D d, double first) {
    alignas(64) static constexpr double numbers[block_side] = {0, 1, 2, 3, 4, 5, 6, 7};
    return hn::Add(hn::Set(d, first), hn::Load(d, numbers));
}

// Pixels of the block at (x, y), relative to the tile, inside all three edges; rows outside [first, last] are not
// looked at.
HWY_INLINE std::uint64_t covered_pixels(const TileEdges& edges, int x, int y, int first, int last) {
    const hn::CappedTag<std::int32_t, block_side> d;
    constexpr std::int32_t span = block_side - 1;
    std::uint64_t outside = 0;
    for (int e = 0; e < 3; ++e) {
        const std::int32_t a = edges.a[e], b = edges.b[e];
        const std::int32_t corner = edges.base[e] + a * x + b * y;
        if (corner + span * (least(a, 0) + least(b, 0)) >= 0) continue;
        if (corner + span * (most(a, 0) + most(b, 0)) < 0) return 0;
        const auto ramp = hn::Mul(hn::Iota(d, 0), hn::Set(d, a));
        std::int32_t row = corner + first * b;
        for (int j = first; j <= last; ++j, row += b)
            for (std::size_t i = 0; i < block_side; i += hn::Lanes(d)) {
                const auto value = hn::Add(ramp, hn::Set(d, row + a * static_cast<std::int32_t>(i)));
                outside |= bits_of(d, hn::Lt(value, hn::Zero(d))) << (8 * static_cast<std::size_t>(j) + i);
            }
    }
    return ~outside;
}

// The triangle's depth plane along rows of eight pixels from x.
template <class D> struct DepthRows {
    static constexpr std::size_t parts = block_side / hn::MaxLanes(D());
    D d;
    hn::Vec<D> columns[parts], nearest, farthest, offset;
    double value, dy, anchor_y;
    bool plain; // within the range of the corners every depth is one: no offset, nothing outside [0, 1]

    HWY_INLINE DepthRows(D tag, const SetupTriangle& t, int x)
        : d(tag), nearest(hn::Set(d, static_cast<double>(t.depth_minimum))),
          farthest(hn::Set(d, static_cast<double>(t.depth_maximum))), offset(hn::Set(d, t.depth_offset)),
          value(static_cast<double>(t.depth)), dy(t.depth_dy), anchor_y(t.y[0] * (1.0 / subpixels)),
          plain(t.depth_offset == 0 && t.depth_minimum > 0 && t.depth_maximum <= 1) {
        move(t, x);
    }
    HWY_INLINE void move(const SetupTriangle& t, int x) {
        const double first = (x + 0.5) - t.x[0] * (1.0 / subpixels); // exact: multiples of 1/512 far below 2⁵³
        for (std::size_t p = 0; p < parts; ++p)
            columns[p] =
                hn::Mul(hn::Set(d, t.depth_dx), counted_from(d, first + static_cast<double>(p * hn::MaxLanes(D()))));
    }
    HWY_INLINE double row(int y) const { return value + dy * ((y + 0.5) - anchor_y); }

    // Depths of one part of a row: (value + dy·(y − y0)) + dx·(x − x0), clamped to the corners' range, moved by the
    // offset, clamped to [0, 1].
    HWY_INLINE hn::Vec<D> at(double row, std::size_t part) const {
        return finish(hn::Add(hn::Set(d, row), columns[part]));
    }
    HWY_INLINE hn::Vec<D> finish(hn::Vec<D> z) const {
        z = hn::Min(hn::Max(z, nearest), farthest);
        if (plain) return z;
        return hn::Min(hn::Max(hn::Add(z, offset), hn::Zero(d)), hn::Set(d, 1.0));
    }
};

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
