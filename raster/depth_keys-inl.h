// Depth of a tile's patches as integer keys, and their test; included once for each instruction set.

#if defined(GNOMON_DEPTH_KEYS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef GNOMON_DEPTH_KEYS_INL
#undef GNOMON_DEPTH_KEYS_INL
#else
#define GNOMON_DEPTH_KEYS_INL
#endif

#include <bit>

#include "raster/depth_tile.h"
#include "raster/kernels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace gnomon::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Ints = hn::CappedTag<std::int32_t, patch_pixels>; // a patch, in one part or more
using Doubles = hn::CappedTag<double, patch_pixels>;
constexpr std::size_t int_lanes = hn::MaxLanes(Ints()), int_parts = patch_pixels / int_lanes;
constexpr std::size_t double_lanes = hn::MaxLanes(Doubles()), double_parts = patch_pixels / double_lanes;
using Int = hn::Vec<Ints>;
using Double = hn::Vec<Doubles>;
using Lanes = hn::Mask<Ints>;

// Column and row of a patch's pixels.
template <class T> struct PatchPlaces {
    alignas(64) T x[patch_pixels] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
    alignas(64) T y[patch_pixels] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
};
template <class T> constexpr PatchPlaces<T> patch_places;

constexpr std::size_t tile_patches = tile_side / patch_side; // along one side

// Pixel centres of each column and row of a tile's patches, from the tile's corner.
struct PatchCentres {
    alignas(64) double x[tile_patches][patch_pixels / 2] = {}, y[tile_patches][patch_pixels] = {};
    constexpr PatchCentres() {
        for (std::size_t n = 0; n < tile_patches; ++n)
            for (std::size_t k = 0; k < patch_pixels; ++k) {
                const std::size_t column = patch_side * n + k % patch_side, row = patch_side * n + k / patch_side;
                y[n][k] = static_cast<double>(row) + 0.5;
                if (k < patch_pixels / 2) x[n][k] = static_cast<double>(column) + 0.5;
            }
    }
};
constexpr PatchCentres patch_centres;

// How depths become keys: float bits with or without a polygon offset, or unorm rounded to nearest.
enum class KeyKind { Float, OffsetFloat, Unorm };

template <KeyKind kind, class V> HWY_INLINE auto to_key(V z, double offset, double scale) {
    const hn::DFromV<V> d;
    const hn::Rebind<std::int32_t, hn::DFromV<V>> i;
    const hn::Rebind<float, hn::DFromV<V>> f;
    if constexpr (kind != KeyKind::Float) z = hn::Add(z, hn::Set(d, offset));
    if constexpr (kind == KeyKind::Unorm)
        return hn::DemoteTo(i, hn::Add(hn::Mul(z, hn::Set(d, scale)), hn::Set(d, 0.5)));
    else
        return hn::BitCast(i, hn::DemoteTo(f, z));
}

#if HWY_TARGET != HWY_SCALAR
// Two halves of a vector, but not by hn::Combine(), which clears the upper one before it is written.
template <class V> HWY_INLINE Int joined(V low, V high) {
#if HWY_TARGET == HWY_AVX3
    return Int{_mm512_inserti32x8(_mm512_castsi256_si512(low.raw), high.raw, 1)};
#else
    return hn::Combine(Ints(), high, low);
#endif
}
#endif

// The triangle's depth plane as keys: (value + dy·(y − y0)) + dx·(x − x0), clamped to the corners' range, moved by the
// offset, clamped to [0, 1], quantized. All of this is monotonic, so the two clamps may come last, as integers: no key
// of a depth in [0, 1] is negative, and whatever is beyond stays beyond.
template <KeyKind kind> struct DepthKeys {
    static constexpr std::size_t column_parts = double_lanes < patch_side ? patch_side / double_lanes : 1;
    struct Columns {
        Double part[column_parts];
    }; // dx·(x − x0) of a patch
    struct Rows {
        Double part[double_parts];
    };                                                       // value + dy·(y − y0)
    double value, dx, dy, anchor_x, anchor_y, offset, scale; // the anchor is relative to the tile
    std::int32_t low, high;

    HWY_INLINE DepthKeys(const SetupTriangle& t, const DepthTile& tile, double key_scale)
        : value(static_cast<double>(t.depth)), dx(t.depth_dx), dy(t.depth_dy),
          anchor_x((t.x[0] - 256 * tile.x) * (1.0 / subpixels)), anchor_y((t.y[0] - 256 * tile.y) * (1.0 / subpixels)),
          offset(t.depth_offset), scale(key_scale), low(limit(t.depth_minimum)), high(limit(t.depth_maximum)) {}

    // Of the n-th column or row of patches of the tile. Distances to the anchor are exact: multiples of 1/512 far below
    // 2⁵³.
    HWY_INLINE Columns columns(std::size_t n) const {
        const Doubles d;
        Columns columns;
        for (std::size_t k = 0; k < column_parts; ++k) {
            const auto right = hn::Sub(hn::Load(d, patch_centres.x[n] + k * double_lanes), hn::Set(d, anchor_x));
            columns.part[k] = hn::Mul(hn::Set(d, dx), right);
        }
        return columns;
    }
    HWY_INLINE Rows rows(std::size_t n) const {
        const Doubles d;
        Rows rows;
        for (std::size_t k = 0; k < double_parts; ++k) {
            const auto up = hn::Sub(hn::Load(d, patch_centres.y[n] + k * double_lanes), hn::Set(d, anchor_y));
            rows.part[k] = hn::Add(hn::Set(d, value), hn::Mul(hn::Set(d, dy), up));
        }
        return rows;
    }
    // One part of the patch.
    HWY_INLINE Int at(const Columns& columns, const Rows& rows, std::size_t part) const {
        const Ints i;
        return hn::Min(hn::Max(unclamped(columns, rows, part), hn::Set(i, low)), hn::Set(i, high));
    }
    // The same where the clamps are known to change nothing.
    HWY_INLINE Int unclamped(const Columns& columns, const Rows& rows, std::size_t part) const {
        return keys_of(part, [&](std::size_t k) { return hn::Add(rows.part[k], columns.part[k % column_parts]); });
    }
    // One part of sixteen keys, not clamped, from as many doubles as it takes; `depth(k)` gives the k-th vector of
    // them.
    template <class Depth> HWY_INLINE Int keys_of(std::size_t part, const Depth& depth) const {
        const auto key = [&](std::size_t k) { return to_key<kind>(depth(k), offset, scale); };
#if HWY_TARGET == HWY_SCALAR
        return key(part);
#else
        return joined(key(2 * part), key(2 * part + 1));
#endif
    }

private:
    HWY_INLINE std::int32_t limit(float depth) const {
        if constexpr (kind == KeyKind::Float) {
            depth = depth < 1.0f ? depth : 1.0f;
            return std::bit_cast<std::int32_t>(depth > 0.0f ? depth : 0.0f);
        }
        const hn::CappedTag<double, 1> d;
        const double z = static_cast<double>(depth) + offset;
        const auto inside = hn::Min(hn::Max(hn::Set(d, z), hn::Zero(d)), hn::Set(d, 1.0));
        return hn::GetLane(to_key<kind>(inside, 0.0, scale));
    }
};

// Which of the fresh depths pass.
HWY_INLINE Lanes passes(Compare test, Int fresh, Int stored) {
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

// Tests a patch, of which `in` are the pixels that count, or with `whole` all, and with `write` stores what passes,
// depth and id; `passed` are the pixels that pass. The usual test, known when compiling, is Less. What is not `clamped`
// must not need it, see SetupTriangle::steady.
template <bool with_ids, bool usual, bool whole, bool clamped, KeyKind kind>
HWY_INLINE void test_patch(const ListState& state, DepthTile& tile, const DepthKeys<kind>& depth,
                           const typename DepthKeys<kind>::Columns& columns, const typename DepthKeys<kind>::Rows& rows,
                           std::size_t at, const Lanes* in, bool all, bool write, std::uint32_t id, Lanes* passed) {
    const Ints i;
    for (std::size_t p = 0; p < int_parts; ++p, at += int_lanes) {
        const Int fresh = clamped ? depth.at(columns, rows, p) : depth.unclamped(columns, rows, p);
        const Int stored = hn::Load(i, tile.depth + at);
        Lanes pass;
        Int kept;
        if constexpr (usual) {
            kept = hn::Min(stored, fresh);
            if constexpr (!whole) kept = hn::IfThenElse(in[p], kept, stored);
            pass = hn::Lt(kept, stored);
        } else {
            pass = whole ? passes(state.test, fresh, stored)
                   : all ? in[p]
                         : hn::And(passes(state.test, fresh, stored), in[p]);
            kept = hn::IfThenElse(pass, fresh, stored);
        }
        // Whole vectors, so that the next load need not wait for a part of one.
        if (write) hn::Store(kept, i, tile.depth + at);
        if constexpr (with_ids) {
            auto* ids = reinterpret_cast<std::int32_t*>(tile.id) + at;
            hn::Store(hn::IfThenElse(pass, hn::Set(i, static_cast<std::int32_t>(id)), hn::Load(i, ids)), i, ids);
        }
        passed[p] = pass;
    }
}

// All lanes of a patch as bits.
HWY_INLINE std::uint64_t patch_bits(const Lanes* lanes) {
    std::uint64_t bits = 0;
    for (std::size_t p = 0; p < int_parts; ++p) bits |= bits_of(Ints(), lanes[p]) << (p * int_lanes);
    return bits;
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
