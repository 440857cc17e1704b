// What passes and what fails, added to a tile's stencil counters; included once for each instruction set.

#if defined(GNOMON_STENCIL_COUNTS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_STENCIL_COUNTS_INL
#undef GNOMON_STENCIL_COUNTS_INL
#else
#define GNOMON_STENCIL_COUNTS_INL
#endif

#include "raster/depth_keys-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE int bit_count(std::uint64_t bits) { return static_cast<int>(hwy::PopCount(bits)); }

// Adds `step` to `count` counters, those with a bit in `pixels`, modulo their range.
template <std::size_t count, class T>
HWY_INLINE void count_pixels(T* counters, std::uint64_t pixels, std::int8_t step) {
    const hn::CappedTag<T, count> d;
    constexpr std::size_t lanes = hn::MaxLanes(d);
    const auto steps = hn::Set(d, static_cast<T>(step));
    for (std::size_t at = 0; at < count; at += lanes) {
        const auto old = hn::LoadU(d, counters + at);
        std::uint8_t bits[8];
        const std::uint64_t part = pixels >> at;
        for (std::size_t k = 0; k < 8; ++k) bits[k] = static_cast<std::uint8_t>(part >> (8 * k));
        hn::StoreU(hn::Add(old, hn::IfThenElseZero(hn::LoadMaskBits(d, bits), steps)), d, counters + at);
    }
}

// Adds what passed and what failed to the `count` counters from place `at` of the tile.
template <ListMode mode, std::size_t count>
HWY_INLINE void count_fragments(const ListState& state, DepthTile& tile, bool front, std::size_t at,
                                std::uint64_t covered, std::uint64_t passed, TileCounts& counts) {
    const auto update = [&](std::uint64_t pixels, std::int8_t step) {
        if (!step || !pixels) return;
        counts.counted += bit_count(pixels);
        if constexpr (mode == ListMode::Count8)
            count_pixels<count>(tile.count8 + at, pixels, step);
        else
            count_pixels<count>(tile.count32 + at, pixels, step);
    };
    update(passed, state.counts[front][1]);
    update(covered & ~passed, state.counts[front][0]);
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
