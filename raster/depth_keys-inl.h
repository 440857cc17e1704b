// Depth of a tile's rows as integer keys, and their test; included once for each instruction set.

#if defined(GNOMON_DEPTH_KEYS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_DEPTH_KEYS_INL
#undef GNOMON_DEPTH_KEYS_INL
#else
#define GNOMON_DEPTH_KEYS_INL
#endif

#include "raster/depth_tile.h"
#include "raster/kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Ints = hn::CappedTag<std::int32_t, block_side>; // a row of a block, in one part or two
using Doubles = hn::CappedTag<double, block_side>;
constexpr std::size_t int_lanes = hn::MaxLanes(Ints()), int_parts = block_side / int_lanes;
using Int = hn::Vec<Ints>;
using Double = hn::Vec<Doubles>;
using Lanes = hn::Mask<Ints>;

// Depths as keys: float bits, or unorm rounded to nearest.
template <bool floats, class V> HWY_INLINE auto to_key(V z, double scale) {
    const hn::DFromV<V> d;
    const hn::Rebind<std::int32_t, hn::DFromV<V>> i;
    const hn::Rebind<float, hn::DFromV<V>> f;
    if constexpr (floats)
        return hn::BitCast(i, hn::DemoteTo(f, z));
    else
        return hn::DemoteTo(i, hn::Add(hn::Mul(z, hn::Set(d, scale)), hn::Set(d, 0.5)));
}

// The triangle's depth plane as keys, along rows of eight pixels: (value + dy·(y − y0)) + dx·(x − x0), clamped to the
// corners' range, moved by the offset, clamped to [0, 1], quantized. All of this is monotonic, so the two clamps may
// come last, as integers: no key of a depth in [0, 1] is negative, and whatever is beyond stays beyond.
struct DepthKeys {
    Double columns[block_side / hn::MaxLanes(Doubles())];
    alignas(64) double rows[4 * block_side];
    double value, dx, dy, anchor_x, anchor_y, offset, scale;
    std::int32_t low, high;

    HWY_INLINE DepthKeys(const SetupTriangle& t, double key_scale)
        : value(static_cast<double>(t.depth)), dx(t.depth_dx), dy(t.depth_dy), anchor_x(t.x[0] * (1.0 / subpixels)),
          anchor_y(t.y[0] * (1.0 / subpixels)), offset(t.depth_offset), scale(key_scale),
          low(limit(static_cast<double>(t.depth_minimum))), high(limit(static_cast<double>(t.depth_maximum))) {}

    HWY_INLINE void set_columns(int x) { // x to x + 7
        const Doubles d;
        const double first = (x + 0.5) - anchor_x; // exact: multiples of 1/512 far below 2⁵³
        for (std::size_t p = 0; p < block_side / hn::MaxLanes(d); ++p)
            columns[p] = hn::Mul(hn::Set(d, dx), hn::Iota(d, first + static_cast<double>(p * hn::MaxLanes(d))));
    }
    HWY_INLINE void set_rows(int y, std::size_t count) { // y to y + count − 1
        const Doubles d;
        const double first = (y + 0.5) - anchor_y;
        for (std::size_t j = 0; j < count; j += hn::MaxLanes(d))
            hn::Store(hn::Add(hn::Set(d, value), hn::Mul(hn::Set(d, dy), hn::Iota(d, first + static_cast<double>(j)))),
                      d, rows + j);
    }
    // One part of row j.
    template <bool floats> HWY_INLINE Int at(int j, std::size_t part) const {
        const Ints i;
        return hn::Min(hn::Max(unclamped<floats>(j, part), hn::Set(i, low)), hn::Set(i, high));
    }
    // The same where the clamps are known to change nothing.
    template <bool floats> HWY_INLINE Int unclamped(int j, std::size_t part) const {
        const Doubles d;
        return keys_of<floats>(part, [&](std::size_t k) { return hn::Add(hn::Set(d, rows[j]), columns[k]); });
    }
    // One part of a row of keys, not clamped, from as many doubles as it takes; `depth(k)` gives the k-th vector of
    // them.
    template <bool floats, class Depth> HWY_INLINE Int keys_of(std::size_t part, const Depth& depth) const {
        const auto key = [&](std::size_t k) {
            return to_key<floats>(hn::Add(depth(k), hn::Set(Doubles(), offset)), scale);
        };
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_AVX3 // as many doubles in a vector as integers in a part
        return key(part);
#else
        return hn::Combine(Ints(), key(2 * part + 1), key(2 * part));
#endif
    }

private:
    HWY_INLINE std::int32_t limit(double z) const {
        const hn::CappedTag<double, 1> d;
        const auto inside = hn::Min(hn::Max(hn::Set(d, z + offset), hn::Zero(d)), hn::Set(d, 1.0));
        return scale == 0 ? hn::GetLane(to_key<true>(inside, scale)) : hn::GetLane(to_key<false>(inside, scale));
    }
};

// Which of the fresh depths pass; the commonest test is known when compiling.
template <bool less> HWY_INLINE Lanes passes(Compare test, Int fresh, Int stored) {
    if constexpr (less) return hn::Lt(fresh, stored);
    switch (test) {
    case Compare::Less:
        return hn::Lt(fresh, stored);
    case Compare::LessEqual:
        return hn::Not(hn::Gt(fresh, stored));
    case Compare::Greater:
        return hn::Gt(fresh, stored);
    case Compare::GreaterEqual:
        return hn::Not(hn::Lt(fresh, stored));
    case Compare::Equal:
        return hn::Eq(fresh, stored);
    case Compare::NotEqual:
        return hn::Ne(fresh, stored);
    case Compare::Always:
        return hn::Eq(fresh, fresh);
    case Compare::Never:
        break;
    }
    return hn::Ne(fresh, fresh);
}

// The part of a triangle's box inside the tile, relative to it.
struct LocalBox {
    int x0, y0, x1, y1;
};

HWY_INLINE LocalBox local_box(const SetupTriangle& t, const DepthTile& tile) {
    constexpr int last = tile_side - 1;
    return {most(t.x0 - tile.x, 0), most(t.y0 - tile.y, 0), least(t.x1 - tile.x, last), least(t.y1 - tile.y, last)};
}

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
