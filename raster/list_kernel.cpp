// The fast path of the tile rasterizer: lists of triangles through depth, with stencil counts or triangle ids. Small
// triangles go row by row; others by 8×8 blocks, whose depth bounds decide whole blocks where they can.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raster/list_kernel.cpp" // this file is compiled once for each target
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

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

// Blocks of a row, as bits, in which depths in [low, high] all pass, or none, against stored ones in [nearest,
// farthest].
struct Verdicts {
    std::uint32_t all = 0, none = 0;
};

HWY_INLINE Verdicts judge(Compare test, const std::int32_t* low, const std::int32_t* high, const std::int32_t* nearest,
                          const std::int32_t* farthest) {
    const Ints i;
    const auto below = [&](const std::int32_t* a, const std::int32_t* b) { // a < b, per block
        std::uint32_t bits = 0;
        for (std::size_t p = 0; p < int_parts; ++p)
            bits |= static_cast<std::uint32_t>(
                bits_of(i, hn::Lt(hn::LoadU(i, a + p * int_lanes), hn::LoadU(i, b + p * int_lanes)))
                << (p * int_lanes));
        return bits;
    };
    constexpr std::uint32_t every = 0xff;
    switch (test) {
    case Compare::Less:
        return {below(high, nearest), every & ~below(low, farthest)};
    case Compare::LessEqual:
        return {every & ~below(nearest, high), below(farthest, low)};
    case Compare::Greater:
        return {below(farthest, low), every & ~below(nearest, high)};
    case Compare::GreaterEqual:
        return {every & ~below(low, farthest), below(high, nearest)};
    case Compare::Equal:
        return {0, below(high, nearest) | below(farthest, low)};
    case Compare::NotEqual:
        return {below(high, nearest) | below(farthest, low), 0};
    case Compare::Always:
        return {every, 0};
    case Compare::Never:
        break;
    }
    return {0, every};
}

// The part of a triangle's box inside the tile, relative to it.
struct LocalBox {
    int x0, y0, x1, y1;
};

HWY_INLINE LocalBox local_box(const SetupTriangle& t, const DepthTile& tile) {
    constexpr int last = tile_side - 1;
    return {most(t.x0 - tile.x, 0), most(t.y0 - tile.y, 0), least(t.x1 - tile.x, last), least(t.y1 - tile.y, last)};
}

// Edge functions of a small triangle at a pixel centre of its box, like TileEdges: 32 bits hold them there.
struct SmallEdges {
    alignas(16) std::int32_t base[4], a[4], b[4];

    HWY_INLINE SmallEdges(const SetupTriangle& t, bool conservative, int x, int y) {
#if HWY_TARGET == HWY_SCALAR
        for (int e = 0; e < 3; ++e) {
            a[e] = t.y[e] - t.y[e + 1], b[e] = t.x[e + 1] - t.x[e];
            const bool inclusive = a[e] > 0 || (a[e] == 0 && b[e] > 0);
            std::int32_t value =
                a[e] * (x * 256 + 128 - t.x[e]) + b[e] * (y * 256 + 128 - t.y[e]) - (inclusive ? 0 : 1);
            if (conservative) value += 128 * ((a[e] < 0 ? -a[e] : a[e]) + (b[e] < 0 ? -b[e] : b[e]));
            base[e] = value >> 8;
        }
#else
        const hn::FixedTag<std::int32_t, 4> q; // the same for three edges at once
        const auto px = hn::LoadU(q, t.x), py = hn::LoadU(q, t.y);
        const auto next_x = hn::Shuffle0321(px), next_y = hn::Shuffle0321(py); // [3] repeats [0]
        const auto step_x = hn::Sub(py, next_y), step_y = hn::Sub(next_x, px), zero = hn::Zero(q);
        auto e = hn::Add(hn::Mul(step_x, hn::Sub(hn::Set(q, x * 256 + 128), px)),
                         hn::Mul(step_y, hn::Sub(hn::Set(q, y * 256 + 128), py)));
        const auto inclusive = hn::Or(hn::Gt(step_x, zero), hn::And(hn::Eq(step_x, zero), hn::Gt(step_y, zero)));
        e = hn::Sub(e, hn::IfThenZeroElse(inclusive, hn::Set(q, 1)));
        if (conservative) e = hn::Add(e, hn::ShiftLeft<7>(hn::Add(hn::Abs(step_x), hn::Abs(step_y))));
        hn::Store(hn::ShiftRight<8>(e), q, base);
        hn::Store(step_x, q, a);
        hn::Store(step_y, q, b);
#endif
    }
};

// Bits of the blocks that the box touches.
HWY_INLINE std::uint64_t blocks_of(const LocalBox& box) {
    const int c0 = box.x0 >> 3, c1 = box.x1 >> 3, r0 = box.y0 >> 3, r1 = box.y1 >> 3;
    const std::uint64_t columns = (std::uint64_t{2} << c1) - (std::uint64_t{1} << c0);
    const std::uint64_t rows = (~std::uint64_t{0} >> (8 * (7 - r1))) & (~std::uint64_t{0} << (8 * r0));
    return (columns * 0x0101010101010101ull) & rows;
}

// Row by row, eight pixels at a step, without asking any bounds.
template <bool with_ids, bool floats, bool less>
HWY_NOINLINE void draw_small(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box,
                             std::uint32_t id, TileCounts& counts) {
    const Ints i;
    DepthKeys depth(t, state.key_scale);
    std::uint64_t covered = 0, passed = 0;
    Int value[3][int_parts];
    std::int32_t up[3];
    const auto start = [&](int x, int y) {
        depth.set_columns(tile.x + x);
        const SmallEdges edges(t, state.conservative, tile.x + x, tile.y + y);
        for (int e = 0; e < 3; ++e) {
            up[e] = edges.b[e];
            for (std::size_t p = 0; p < int_parts; ++p) {
                const auto lane = hn::Iota(i, static_cast<std::int32_t>(p * int_lanes));
                value[e][p] = hn::Add(hn::Set(i, edges.base[e]), hn::Mul(lane, hn::Set(i, edges.a[e])));
            }
        }
    };
    // Row j of the box from x on; `beyond` is negative where there is no such row.
    const auto draw_row = [&](int x, int j, int beyond) {
        for (std::size_t p = 0; p < int_parts; ++p) {
            const auto lane = hn::Iota(i, static_cast<std::int32_t>(p * int_lanes));
            const Int outside = hn::Or(hn::Or(value[0][p], value[1][p]), hn::Or(value[2][p], hn::Set(i, beyond)));
            const Lanes inside = hn::And(hn::Gt(outside, hn::Set(i, -1)), hn::Lt(lane, hn::Set(i, box.x1 - x + 1)));
            for (int e = 0; e < 3; ++e) value[e][p] = hn::Add(value[e][p], hn::Set(i, up[e]));
            const std::size_t at = static_cast<std::size_t>((box.y0 + j) * tile_side + x) + p * int_lanes;
            const Int fresh = depth.at<floats>(j, p);
            const Lanes pass = hn::And(passes<less>(state.test, fresh, hn::LoadU(i, tile.depth + at)), inside);
            if (state.write) hn::BlendedStore(fresh, pass, i, tile.depth + at);
            if constexpr (with_ids)
                hn::BlendedStore(hn::Set(i, static_cast<std::int32_t>(id)), pass, i,
                                 reinterpret_cast<std::int32_t*>(tile.id) + at);
            covered += hn::CountTrue(i, inside);
            passed += hn::CountTrue(i, pass);
        }
    };
    const int last = box.y1 - box.y0;
    constexpr int few = 4; // rows, drawn without asking how many there are
    if (last < few && box.x1 - box.x0 < block_side) {
        depth.set_rows(tile.y + box.y0, few);
        start(box.x0, box.y0);
        for (int j = 0; j < few; ++j) draw_row(box.x0, j, last - j);
    } else {
        depth.set_rows(tile.y + box.y0, static_cast<std::size_t>(last + 1));
        for (int x = box.x0; x <= box.x1; x += block_side) {
            start(x, box.y0);
            for (int j = 0; j <= last; ++j) draw_row(x, j, 0);
        }
    }
    counts.covered += static_cast<std::int64_t>(covered);
    counts.passed += static_cast<std::int64_t>(passed);
    if (state.write && passed) tile.unknown |= blocks_of(box);
}

// What the block path needs of a triangle's edges: per block, and per pixel of a block.
struct BlockEdges {
    static constexpr std::size_t pixel_lanes = hn::MaxLanes(hn::CappedTag<std::int32_t, 16>());
    using Pixels = hn::CappedTag<std::int32_t, 16>; // two rows of a block at once, where there are so many lanes
    TileEdges edges;
    Int most_inside[3][int_parts], least_inside[3][int_parts]; // of the edge functions in each block of the lowest row
    hn::Vec<Pixels> ramp[3];                                   // from the block's lower left pixel

    HWY_INLINE explicit BlockEdges(const TileEdges& e) : edges(e) {
        const Ints i;
        const Pixels pixels;
        constexpr std::int32_t span = block_side - 1;
        const auto lane = hn::Iota(pixels, 0);
        for (int k = 0; k < 3; ++k) {
            const std::int32_t a = e.a[k], b = e.b[k];
            for (std::size_t p = 0; p < int_parts; ++p) {
                const auto block = hn::Iota(i, static_cast<std::int32_t>(p * int_lanes));
                const auto corner = hn::Add(hn::Set(i, e.base[k]), hn::Mul(block, hn::Set(i, a * block_side)));
                most_inside[k][p] = hn::Add(corner, hn::Set(i, span * (most(a, 0) + most(b, 0))));
                least_inside[k][p] = hn::Add(corner, hn::Set(i, span * (least(a, 0) + least(b, 0))));
            }
            ramp[k] = hn::Add(hn::Mul(hn::And(lane, hn::Set(pixels, 7)), hn::Set(pixels, a)),
                              hn::Mul(hn::ShiftRight<3>(lane), hn::Set(pixels, b)));
        }
    }

    // Of the blocks of the row at y: those that the edges touch, and for each edge those that it crosses.
    struct Row {
        std::uint32_t touched = 0xff, crossed[3] = {0, 0, 0};
    };
    HWY_INLINE Row row(int y) const {
        const Ints i;
        Row row;
        for (std::size_t p = 0; p < int_parts; ++p) {
            auto outside = hn::Zero(i);
            for (int k = 0; k < 3; ++k) {
                const auto up = hn::Set(i, edges.b[k] * y);
                outside = hn::Or(outside, hn::Add(most_inside[k][p], up));
                const auto partly = hn::Lt(hn::Add(least_inside[k][p], up), hn::Zero(i));
                row.crossed[k] |= static_cast<std::uint32_t>(bits_of(i, partly) << (p * int_lanes));
            }
            row.touched &= ~static_cast<std::uint32_t>(bits_of(i, hn::Lt(outside, hn::Zero(i))) << (p * int_lanes));
        }
        return row;
    }

    // Pixels of the block at (x, y) inside those edges that cross it.
    HWY_INLINE std::uint64_t covered(const Row& row, int column, int y) const {
        const Pixels pixels;
        std::uint64_t outside = 0;
        for (int k = 0; k < 3; ++k) {
            if (!(row.crossed[k] >> column & 1)) continue;
            std::int32_t corner = edges.base[k] + edges.a[k] * column * block_side + edges.b[k] * y;
            for (std::size_t at = 0; at < 64; at += pixel_lanes) {
                const std::int32_t first = corner + edges.b[k] * static_cast<std::int32_t>(at >> 3) +
                                           edges.a[k] * static_cast<std::int32_t>(at & 7);
                const auto value = hn::Add(ramp[k], hn::Set(pixels, first));
                outside |= bits_of(pixels, hn::Lt(value, hn::Zero(pixels))) << at;
            }
        }
        return ~outside;
    }
};

// The least and the greatest key of the triangle in each block of the rows that are set. Depth is monotonic along x and
// y, rounding and all, so its extremes over a block are at corners.
template <bool floats>
HWY_NOINLINE void bound_depths(const DepthKeys& depth, int tile_x, std::int32_t* low, std::int32_t* high) {
    const Ints i;
    const Doubles d;
    constexpr int last = block_side - 1;
    const auto bound = [&](bool upper, std::int32_t* out) {
        const double first = (tile_x + ((depth.dx > 0) == upper ? last : 0) + 0.5) - depth.anchor_x;
        const auto row = hn::Set(d, depth.rows[(depth.dy > 0) == upper ? last : 0]);
        for (std::size_t p = 0; p < int_parts; ++p) {
            const Int keys = depth.keys_of<floats>(p, [&](std::size_t k) {
                const auto x = hn::Add(hn::Set(d, first),
                                       hn::Mul(hn::Iota(d, static_cast<double>(k * hn::MaxLanes(d))), hn::Set(d, 8.0)));
                return hn::Add(row, hn::Mul(hn::Set(d, depth.dx), x));
            });
            hn::StoreU(hn::Min(hn::Max(keys, hn::Set(i, depth.low)), hn::Set(i, depth.high)), i, out + p * int_lanes);
        }
    };
    bound(false, low);
    bound(true, high);
}

// Makes a block's depth bounds anew.
void refresh_bounds(DepthTile& tile, int block) {
    const Ints i;
    const std::int32_t* at = tile.depth + (block >> 3) * block_side * tile_side + (block & 7) * block_side;
    Int low = hn::LoadU(i, at), high = low;
    for (int j = 0; j < block_side; ++j)
        for (std::size_t p = 0; p < int_parts; ++p) {
            const Int stored = hn::LoadU(i, at + j * tile_side + p * int_lanes);
            low = hn::Min(low, stored);
            high = hn::Max(high, stored);
        }
    tile.nearest[block] = hn::GetLane(hn::MinOfLanes(i, low));
    tile.farthest[block] = hn::GetLane(hn::MaxOfLanes(i, high));
    tile.unknown &= ~(std::uint64_t{1} << block);
    tile.loose &= ~(std::uint64_t{1} << block);
}

// Brings the bounds of some blocks of row r to where they can decide: unknown ones always, loose ones where the
// triangle lies behind (in front, for reversed depth) all that was drawn there since they were exact.
HWY_INLINE void prepare_bounds(const ListState& state, DepthTile& tile, int r, std::uint32_t blocks,
                               const std::int32_t* low, const std::int32_t* high) {
    const auto unknown = static_cast<std::uint32_t>(tile.unknown >> (tile_blocks * r)) & blocks;
    const auto loose = static_cast<std::uint32_t>(tile.loose >> (tile_blocks * r)) & blocks & ~unknown;
    if (!(unknown | loose)) return;
    std::uint32_t stale = unknown;
    const bool less = state.test == Compare::Less || state.test == Compare::LessEqual;
    for (std::uint32_t rest = loose; rest; rest &= rest - 1) {
        const auto c = static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero32(rest));
        const std::int32_t drawn = tile.drawn[r * tile_blocks + c];
        if (less ? low[c] >= drawn : high[c] <= drawn) stale |= 1u << c;
    }
    for (; stale; stale &= stale - 1)
        refresh_bounds(tile, r * tile_blocks + static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero32(stale)));
}

// Keeps the bounds true after a write to a part of the block.
HWY_INLINE void loosen_bounds(const ListState& state, DepthTile& tile, int block, std::int32_t low, std::int32_t high) {
    const bool less = state.test == Compare::Less || state.test == Compare::LessEqual;
    const bool greater = state.test == Compare::Greater || state.test == Compare::GreaterEqual;
    const bool fresh = !(tile.loose >> block & 1);
    if (!greater) tile.nearest[block] = least(tile.nearest[block], low);
    if (!less) tile.farthest[block] = most(tile.farthest[block], high);
    const std::int32_t reached = less ? high : low;
    tile.drawn[block] = fresh ? reached : less ? most(tile.drawn[block], reached) : least(tile.drawn[block], reached);
    tile.loose |= std::uint64_t{1} << block;
}

// Depth test, or with `all` only the write, of the covered pixels of one block; returns those that pass.
template <bool with_ids, bool floats, bool less>
HWY_NOINLINE std::uint64_t test_block(const ListState& state, DepthTile& tile, DepthKeys& depth, int x, int y,
                                      std::uint64_t covered, bool all, std::uint32_t id) {
    const Ints i;
    depth.set_columns(tile.x + x);
    std::uint64_t passed = 0;
    for (int j = 0; j < block_side; ++j) {
        const std::uint64_t row_bits = covered >> (8 * j) & 0xff;
        if (row_bits == 0) continue;
        for (std::size_t p = 0; p < int_parts; ++p) {
            std::int32_t* at = tile.depth + (y + j) * tile_side + x + p * int_lanes;
            const Int fresh = depth.at<floats>(j, p);
            Lanes pass = mask_of(i, row_bits >> (p * int_lanes));
            if (!all) pass = hn::And(pass, passes<less>(state.test, fresh, hn::LoadU(i, at)));
            if (state.write) hn::BlendedStore(fresh, pass, i, at);
            if constexpr (with_ids)
                hn::BlendedStore(hn::Set(i, static_cast<std::int32_t>(id)), pass, i,
                                 reinterpret_cast<std::int32_t*>(tile.id) + (at - tile.depth));
            passed |= bits_of(i, pass) << (static_cast<std::size_t>(8 * j) + p * int_lanes);
        }
    }
    return passed;
}

// Writes a block that is covered and passes throughout; its keys lie in [low, high].
template <bool with_ids, bool floats>
HWY_NOINLINE void fill_block(DepthTile& tile, DepthKeys& depth, int x, int y, std::int32_t low, std::int32_t high,
                             std::uint32_t id) {
    const Ints i;
    const auto fill = [&](const auto& key) {
        std::int32_t* at = tile.depth + y * tile_side + x;
        for (int j = 0; j < block_side; ++j, at += tile_side)
            for (std::size_t p = 0; p < int_parts; ++p) {
                hn::StoreU(key(j, p), i, at + p * int_lanes);
                if constexpr (with_ids)
                    hn::StoreU(hn::Set(i, static_cast<std::int32_t>(id)), i,
                               reinterpret_cast<std::int32_t*>(tile.id) + (at - tile.depth) + p * int_lanes);
            }
    };
    if (low == high) {
        const auto constant = hn::Set(i, low);
        return fill([&](int, std::size_t) { return constant; });
    }
    depth.set_columns(tile.x + x);
    if (low > depth.low && high < depth.high)
        fill([&](int j, std::size_t p) { return depth.unclamped<floats>(j, p); });
    else
        fill([&](int j, std::size_t p) { return depth.at<floats>(j, p); });
}

// The innermost functions for a depth format and test.
struct BlockFunctions {
    decltype(&draw_small<false, true, true>) small;
    decltype(&test_block<false, true, true>) test;
    decltype(&fill_block<false, true>) fill;
    decltype(&bound_depths<true>) bound;
};

template <bool with_ids> BlockFunctions block_functions(const ListState& state) {
    const bool less = state.test == Compare::Less;
    if (state.key_scale == 0)
        return {less ? draw_small<with_ids, true, true> : draw_small<with_ids, true, false>,
                less ? test_block<with_ids, true, true> : test_block<with_ids, true, false>, fill_block<with_ids, true>,
                bound_depths<true>};
    return {less ? draw_small<with_ids, false, true> : draw_small<with_ids, false, false>,
            less ? test_block<with_ids, false, true> : test_block<with_ids, false, false>, fill_block<with_ids, false>,
            bound_depths<false>};
}

// Adds `step` to the counters of a block, modulo their range.
template <class T> HWY_INLINE void count_block(T* counters, std::uint64_t pixels, std::int8_t step) {
    const hn::CappedTag<T, 64> d;
    constexpr std::size_t lanes = hn::MaxLanes(d);
    const auto steps = hn::Set(d, static_cast<T>(step));
    for (std::size_t at = 0; at < 64; at += lanes) {
        const auto old = hn::LoadU(d, counters + at);
        std::uint8_t bits[8];
        const std::uint64_t part = pixels >> at;
        for (std::size_t k = 0; k < 8; ++k) bits[k] = static_cast<std::uint8_t>(part >> (8 * k));
        hn::StoreU(hn::Add(old, hn::IfThenElseZero(hn::LoadMaskBits(d, bits), steps)), d, counters + at);
    }
}

HWY_INLINE int bit_count(std::uint64_t bits) { return static_cast<int>(hwy::PopCount(bits)); }

// Pixels of the block at (x, y) that lie in the box.
HWY_INLINE std::uint64_t box_pixels(const LocalBox& box, int x, int y) {
    const int x0 = most(box.x0 - x, 0), x1 = least(box.x1 - x, 7), y0 = most(box.y0 - y, 0), y1 = least(box.y1 - y, 7);
    const std::uint64_t row = (0xffull >> (7 - x1)) & (0xffull << x0) & 0xff;
    const std::uint64_t rows = (every_pixel >> (8 * (7 - y1))) & (every_pixel << (8 * y0));
    return (row * 0x0101010101010101ull) & rows;
}

// Adds what passed and what failed to the stencil.
template <ListMode mode>
HWY_INLINE void count_fragments(const ListState& state, DepthTile& tile, bool front, int block, std::uint64_t covered,
                                std::uint64_t passed, TileCounts& counts) {
    const auto update = [&](std::uint64_t pixels, std::int8_t step) {
        if (!step || !pixels) return;
        counts.counted += bit_count(pixels);
        if constexpr (mode == ListMode::Count8)
            count_block(tile.count8 + 64 * block, pixels, step);
        else
            count_block(tile.count32 + 64 * block, pixels, step);
    };
    update(passed, state.counts[front][1]);
    update(covered & ~passed, state.counts[front][0]);
}

// One triangle, by blocks.
template <ListMode mode>
void draw_blocks(const ListState& state, const BlockFunctions& functions, DepthTile& tile, const SetupTriangle& t,
                 const LocalBox& box, std::uint32_t id, TileCounts& counts) {
    constexpr bool with_ids = mode == ListMode::Ids, counting = mode == ListMode::Count8 || mode == ListMode::Count32;
    const TileEdges tile_edge = tile_edges(t, state.conservative, tile.x, tile.y);
    if (tile_edge.empty) return;
    const BlockEdges edges(tile_edge);
    DepthKeys depth(t, state.key_scale);
    const int c0 = box.x0 >> 3, c1 = box.x1 >> 3, r0 = box.y0 >> 3, r1 = box.y1 >> 3;
    const std::uint32_t columns = (2u << c1) - (1u << c0);
    // Columns of blocks that the box holds whole.
    const int w0 = (box.x0 + 7) >> 3, w1 = (box.x1 + 1) >> 3;
    const std::uint32_t whole_columns = w1 > w0 ? (1u << w1) - (1u << w0) : 0;
    // Bounds of the whole triangle do for one that is not large.
    const bool large = c1 - c0 > 3 || r1 - r0 > 3;
    alignas(64) std::int32_t low[tile_blocks], high[tile_blocks];
    bool bounded = true;
    for (int r = r0; r <= r1; ++r) {
        const int y = r * block_side;
        const BlockEdges::Row row = edges.row(y);
        const std::uint32_t touched = row.touched & columns;
        if (!touched) continue;
        for (std::size_t k = 0; bounded && k < tile_blocks; ++k) low[k] = depth.low, high[k] = depth.high;
        bounded = false;
        const std::uint32_t in_box = y >= box.y0 && y + 7 <= box.y1 ? whole_columns : 0;
        const std::uint32_t whole = in_box & ~(row.crossed[0] | row.crossed[1] | row.crossed[2]);
        depth.set_rows(tile.y + y, block_side);
        prepare_bounds(state, tile, r, touched, low, high);
        const int first = r * tile_blocks;
        Verdicts verdicts = judge(state.test, low, high, tile.nearest + first, tile.farthest + first);
        if (large && touched & ~(verdicts.all | verdicts.none)) { // what the whole triangle's range leaves open
            functions.bound(depth, tile.x, low, high);
            prepare_bounds(state, tile, r, touched, low, high);
            verdicts = judge(state.test, low, high, tile.nearest + first, tile.farthest + first);
            bounded = true;
        }

        // What bounds alone decide.
        const std::uint32_t filled = state.write ? whole & verdicts.all : 0;
        for (std::uint32_t rest = filled; rest; rest &= rest - 1) {
            const int c = static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero32(rest));
            functions.fill(tile, depth, c * block_side, y, low[c], high[c], id);
            tile.nearest[first + c] = low[c], tile.farthest[first + c] = high[c];
        }
        tile.loose &= ~(static_cast<std::uint64_t>(filled) << first);
        const std::uint32_t decided = filled | (counting ? 0 : whole & verdicts.none);
        counts.covered += 64 * bit_count(decided);
        counts.passed += 64 * bit_count(filled);

        for (std::uint32_t rest = touched & ~decided; rest; rest &= rest - 1) {
            const int column = static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero32(rest)), x = column * block_side;
            const int block = first + column;
            std::uint64_t covered = every_pixel;
            if (!(whole >> column & 1)) {
                covered = edges.covered(row, column, y);
                if (!(in_box >> column & 1)) covered &= box_pixels(box, x, y);
                if (!covered) continue;
            }
            counts.covered += bit_count(covered);
            const bool all = verdicts.all >> column & 1;
            std::uint64_t passed = 0;
            if (all && !with_ids && !state.write) {
                passed = covered;
            } else if (!(verdicts.none >> column & 1)) {
                passed = functions.test(state, tile, depth, x, y, covered, all, id);
                if (passed && state.write) loosen_bounds(state, tile, block, low[column], high[column]);
            }
            counts.passed += bit_count(passed);
            if constexpr (counting) count_fragments<mode>(state, tile, t.front, block, covered, passed, counts);
        }
    }
}

template <ListMode mode>
void draw_all(const ListState& state, DepthTile& tile, const SetupTriangle* triangles, const std::uint16_t* list,
              std::size_t count, std::uint32_t first_id, TileCounts& counts) {
    constexpr bool counting = mode == ListMode::Count8 || mode == ListMode::Count32;
    const BlockFunctions functions = block_functions<mode == ListMode::Ids>(state);
    for (std::size_t k = 0; k < count; ++k) {
        const SetupTriangle& t = triangles[list[k]];
        const LocalBox box = local_box(t, tile);
        const std::uint32_t id = first_id + list[k];
        if (t.small && !counting)
            functions.small(state, tile, t, box, id, counts);
        else
            draw_blocks<mode>(state, functions, tile, t, box, id, counts);
    }
}

void draw(const ListState& state, DepthTile& tile, const SetupTriangle* triangles, const std::uint16_t* list,
          std::size_t count, std::uint32_t first_id, TileCounts& counts) {
    switch (state.mode) {
    case ListMode::Depth:
        return draw_all<ListMode::Depth>(state, tile, triangles, list, count, first_id, counts);
    case ListMode::Ids:
        return draw_all<ListMode::Ids>(state, tile, triangles, list, count, first_id, counts);
    case ListMode::Count8:
        return draw_all<ListMode::Count8>(state, tile, triangles, list, count, first_id, counts);
    case ListMode::Count32:
        return draw_all<ListMode::Count32>(state, tile, triangles, list, count, first_id, counts);
    }
}

DrawList list_table() { return draw; }

} // namespace gnomon::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "raster/isa.h"

namespace gnomon::detail {
HWY_EXPORT(list_table);

DrawList draw_list() {
    static const DrawList chosen = for_chosen_isa([] { return HWY_DYNAMIC_DISPATCH(list_table)(); });
    return chosen;
}
} // namespace gnomon::detail
#endif
