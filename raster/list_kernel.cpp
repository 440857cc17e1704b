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
template <class V> HWY_INLINE auto to_key(V z, double scale) {
    const hn::Rebind<std::int32_t, hn::DFromV<V>> i;
    const hn::Rebind<float, hn::DFromV<V>> f;
    if (scale == 0) return hn::BitCast(i, hn::DemoteTo(f, z));
    const hn::DFromV<V> d;
    return hn::DemoteTo(i, hn::Add(hn::Mul(z, hn::Set(d, scale)), hn::Set(d, 0.5)));
}

// One part of a row of keys from as many doubles as it takes; `depth(k)` gives the k-th vector of doubles.
template <class Depth> HWY_INLINE Int keys_of(std::size_t part, double scale, const Depth& depth) {
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_AVX3 // as many doubles in a vector as integers in a part
    return to_key(depth(part), scale);
#else
    return hn::Combine(Ints(), to_key(depth(2 * part + 1), scale), to_key(depth(2 * part), scale));
#endif
}

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

enum class Verdict : std::uint8_t { None, All, Some };

// Whether depths in [low, high] pass against stored ones in [nearest, farthest].
HWY_INLINE Verdict judge(Compare test, std::int32_t low, std::int32_t high, std::int32_t nearest,
                         std::int32_t farthest) {
    const auto verdict = [](bool all, bool none) { return all ? Verdict::All : none ? Verdict::None : Verdict::Some; };
    const bool apart = high < nearest || low > farthest;
    switch (test) {
    case Compare::Less:
        return verdict(high < nearest, low >= farthest);
    case Compare::LessEqual:
        return verdict(high <= nearest, low > farthest);
    case Compare::Greater:
        return verdict(low > farthest, high <= nearest);
    case Compare::GreaterEqual:
        return verdict(low >= farthest, high < nearest);
    case Compare::Equal:
        return verdict(false, apart);
    case Compare::NotEqual:
        return verdict(apart, false);
    case Compare::Always:
        return Verdict::All;
    case Compare::Never:
        break;
    }
    return Verdict::None;
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
template <bool with_ids>
void draw_small(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box, std::uint32_t id,
                TileCounts& counts) {
    const Ints i;
    const Doubles d;
    DepthRows<Doubles> depth(d, t, tile.x + box.x0);
    std::uint64_t covered = 0, passed = 0;
    for (int x = box.x0; x <= box.x1; x += block_side) {
        if (x != box.x0) depth.move(t, tile.x + x);
        const SmallEdges edges(t, state.conservative, tile.x + x, tile.y + box.y0);
        Int value[3][int_parts];
        Lanes inside_box[int_parts];
        for (std::size_t p = 0; p < int_parts; ++p) {
            const auto lane = hn::Iota(i, static_cast<std::int32_t>(p * int_lanes));
            inside_box[p] = hn::Lt(lane, hn::Set(i, box.x1 - x + 1));
            for (int e = 0; e < 3; ++e)
                value[e][p] = hn::Add(hn::Set(i, edges.base[e]), hn::Mul(lane, hn::Set(i, edges.a[e])));
        }
        for (int y = box.y0; y <= box.y1; ++y) {
            const double row = depth.row(tile.y + y);
            for (std::size_t p = 0; p < int_parts; ++p) {
                const Int outside = hn::Or(hn::Or(value[0][p], value[1][p]), value[2][p]);
                const Lanes inside = hn::And(hn::Gt(outside, hn::Set(i, -1)), inside_box[p]);
                for (int e = 0; e < 3; ++e) value[e][p] = hn::Add(value[e][p], hn::Set(i, edges.b[e]));
                const std::size_t at = static_cast<std::size_t>(y * tile_side + x) + p * int_lanes;
                const Int fresh = keys_of(p, state.key_scale, [&](std::size_t k) { return depth.at(row, k); });
                const Lanes pass = hn::And(passes(state.test, fresh, hn::LoadU(i, tile.depth + at)), inside);
                if (state.write) hn::BlendedStore(fresh, pass, i, tile.depth + at);
                if constexpr (with_ids)
                    hn::BlendedStore(hn::Set(i, static_cast<std::int32_t>(id)), pass, i,
                                     reinterpret_cast<std::int32_t*>(tile.id) + at);
                covered += hn::CountTrue(i, inside);
                passed += hn::CountTrue(i, pass);
            }
        }
    }
    counts.covered += static_cast<std::int64_t>(covered);
    counts.passed += static_cast<std::int64_t>(passed);
    if (state.write) tile.stale |= blocks_of(box);
}

// One row of eight blocks: which of them the edges touch or leave whole, and the range of the triangle's depths in
// each.
struct BlockRow {
    std::uint32_t touched = 0xff, whole = 0xff;
    alignas(64) std::int32_t low[tile_blocks], high[tile_blocks];
};

HWY_INLINE void classify_edges(const TileEdges& edges, int y, BlockRow& row) {
    const Ints i;
    constexpr std::int32_t span = block_side - 1;
    for (std::size_t p = 0; p < int_parts; ++p) {
        auto any = hn::Zero(i), all = hn::Zero(i); // negative: a block outside, or not whole
        const auto block = hn::Iota(i, static_cast<std::int32_t>(p * int_lanes));
        for (int e = 0; e < 3; ++e) {
            const std::int32_t a = edges.a[e], b = edges.b[e];
            const auto corner = hn::Add(hn::Set(i, edges.base[e] + b * y), hn::Mul(block, hn::Set(i, a * block_side)));
            any = hn::Or(any, hn::Add(corner, hn::Set(i, span * (most(a, 0) + most(b, 0)))));
            all = hn::Or(all, hn::Add(corner, hn::Set(i, span * (least(a, 0) + least(b, 0)))));
        }
        const std::uint64_t lanes = (std::uint64_t{1} << int_lanes) - 1;
        const auto clear = [&](std::uint32_t& bits, Int sign) {
            bits &= ~static_cast<std::uint32_t>((bits_of(i, hn::Lt(sign, hn::Zero(i))) & lanes) << (p * int_lanes));
        };
        clear(row.touched, any);
        clear(row.whole, all);
    }
}

// Depth is monotonic along x and y, rounding and all, so the extremes over a block are at its corners.
HWY_INLINE void bound_depths(const ListState& state, const SetupTriangle& t, const DepthRows<Doubles>& depth,
                             int tile_x, int y, BlockRow& row) {
    const Ints i;
    const Doubles d;
    constexpr int last = block_side - 1;
    const auto bound = [&](bool upper, std::int32_t* out) {
        const double first = (tile_x + ((t.depth_dx > 0) == upper ? last : 0) + 0.5) - t.x[0] * (1.0 / subpixels);
        const double z = depth.row(y + ((t.depth_dy > 0) == upper ? last : 0));
        for (std::size_t p = 0; p < int_parts; ++p) {
            const Int keys = keys_of(p, state.key_scale, [&](std::size_t k) {
                const auto x = hn::Add(hn::Set(d, first),
                                       hn::Mul(hn::Iota(d, static_cast<double>(k * hn::MaxLanes(d))), hn::Set(d, 8.0)));
                return depth.finish(hn::Add(hn::Set(d, z), hn::Mul(hn::Set(d, t.depth_dx), x)));
            });
            hn::StoreU(keys, i, out + p * int_lanes);
        }
    };
    bound(false, row.low);
    bound(true, row.high);
}

// Makes a block's depth bounds anew.
HWY_INLINE void refresh_bounds(DepthTile& tile, int block) {
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
    tile.stale &= ~(std::uint64_t{1} << block);
}

// Depth test, or with `all` only the write, of the covered pixels of one block; returns those that pass.
template <bool with_ids>
HWY_INLINE std::uint64_t test_block(const ListState& state, DepthTile& tile, const DepthRows<Doubles>& depth, int x,
                                    int y, std::uint64_t covered, bool all, std::uint32_t id) {
    const Ints i;
    std::uint64_t passed = 0;
    for (int j = 0; j < block_side; ++j) {
        const std::uint64_t row_bits = covered >> (8 * j) & 0xff;
        if (row_bits == 0) continue;
        const double row = depth.row(tile.y + y + j);
        for (std::size_t p = 0; p < int_parts; ++p) {
            const std::uint8_t bits[8] = {static_cast<std::uint8_t>(row_bits >> (p * int_lanes))};
            std::int32_t* at = tile.depth + (y + j) * tile_side + x + p * int_lanes;
            const Int fresh = keys_of(p, state.key_scale, [&](std::size_t k) { return depth.at(row, k); });
            Lanes pass = hn::LoadMaskBits(i, bits);
            if (!all) pass = hn::And(pass, passes(state.test, fresh, hn::LoadU(i, at)));
            if (state.write) hn::BlendedStore(fresh, pass, i, at);
            if constexpr (with_ids)
                hn::BlendedStore(hn::Set(i, static_cast<std::int32_t>(id)), pass, i,
                                 reinterpret_cast<std::int32_t*>(tile.id) + (at - tile.depth));
            passed |= bits_of(i, pass) << (static_cast<std::size_t>(8 * j) + p * int_lanes);
        }
    }
    return passed;
}

// Writes a block that is covered and passes throughout.
template <bool with_ids>
HWY_INLINE void fill_block(const ListState& state, DepthTile& tile, const DepthRows<Doubles>& depth, int x, int y,
                           std::uint32_t id) {
    const Ints i;
    std::int32_t* at = tile.depth + y * tile_side + x;
    for (int j = 0; j < block_side; ++j, at += tile_side) {
        const double row = depth.row(tile.y + y + j);
        for (std::size_t p = 0; p < int_parts; ++p) {
            hn::StoreU(keys_of(p, state.key_scale, [&](std::size_t k) { return depth.at(row, k); }), i,
                       at + p * int_lanes);
            if constexpr (with_ids)
                hn::StoreU(hn::Set(i, static_cast<std::int32_t>(id)), i,
                           reinterpret_cast<std::int32_t*>(tile.id) + (at - tile.depth) + p * int_lanes);
        }
    }
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

// One triangle, by blocks.
template <ListMode mode>
void draw_blocks(const ListState& state, DepthTile& tile, const SetupTriangle& t, const LocalBox& box, std::uint32_t id,
                 TileCounts& counts) {
    constexpr bool with_ids = mode == ListMode::Ids, counting = mode == ListMode::Count8 || mode == ListMode::Count32;
    const TileEdges edges = tile_edges(t, state.conservative, tile.x, tile.y);
    if (edges.empty) return;
    const std::int8_t on_pass = state.counts[t.front][1], on_fail = state.counts[t.front][0];
    DepthRows<Doubles> depth(Doubles(), t, tile.x);
    const int c0 = box.x0 >> 3, c1 = box.x1 >> 3;
    const std::uint32_t columns = (2u << c1) - (1u << c0);
    // Columns and rows of blocks that the box holds whole.
    const int w0 = (box.x0 + 7) >> 3, w1 = (box.x1 + 1) >> 3;
    const std::uint32_t whole_columns = w1 > w0 ? (1u << w1) - (1u << w0) : 0;
    for (int y = box.y0 & ~7; y <= box.y1; y += block_side) {
        BlockRow row;
        classify_edges(edges, y, row);
        row.touched &= columns;
        if (!row.touched) continue;
        row.whole &= y >= box.y0 && y + 7 <= box.y1 ? whole_columns : 0;
        bound_depths(state, t, depth, tile.x, tile.y + y, row);
        for (std::uint32_t rest = row.touched; rest; rest &= rest - 1) {
            const int column = static_cast<int>(hwy::Num0BitsBelowLS1Bit_Nonzero32(rest)), x = column * block_side;
            const int block = (y >> 3) * tile_blocks + column;
            const bool whole = row.whole >> column & 1;
            std::uint64_t covered = every_pixel;
            if (!whole) {
                const int first = most(box.y0 - y, 0), last = least(box.y1 - y, block_side - 1);
                covered = covered_pixels(edges, x, y, first, last) & box_pixels(box, x, y);
                if (!covered) continue;
            }
            const int covered_count = whole ? 64 : bit_count(covered);
            counts.covered += covered_count;
            if (tile.stale >> block & 1) refresh_bounds(tile, block);
            const Verdict verdict =
                judge(state.test, row.low[column], row.high[column], tile.nearest[block], tile.farthest[block]);
            std::uint64_t passed = 0;
            if (verdict == Verdict::All && whole && !counting) {
                passed = every_pixel;
                if (state.write || with_ids) {
                    depth.move(t, tile.x + x);
                    if (state.write) {
                        fill_block<with_ids>(state, tile, depth, x, y, id);
                        tile.nearest[block] = row.low[column], tile.farthest[block] = row.high[column];
                    } else {
                        test_block<with_ids>(state, tile, depth, x, y, covered, true, id);
                    }
                }
                counts.passed += 64;
                continue;
            }
            if (verdict == Verdict::All && counting) {
                passed = covered;
            } else if (verdict != Verdict::None) {
                depth.move(t, tile.x + x);
                passed = test_block<with_ids>(state, tile, depth, x, y, covered, verdict == Verdict::All, id);
                if (passed && state.write) tile.stale |= std::uint64_t{1} << block;
            }
            const int passed_count = passed == covered ? covered_count : bit_count(passed);
            counts.passed += passed_count;
            if constexpr (counting) {
                const auto update = [&](std::uint64_t pixels, std::int8_t step, int count) {
                    if (!step || !pixels) return;
                    counts.counted += count;
                    if constexpr (mode == ListMode::Count8)
                        count_block(tile.count8 + 64 * block, pixels, step);
                    else
                        count_block(tile.count32 + 64 * block, pixels, step);
                };
                update(passed, on_pass, passed_count);
                update(covered & ~passed, on_fail, covered_count - passed_count);
            }
        }
    }
}

template <ListMode mode>
void draw_all(const ListState& state, DepthTile& tile, const SetupTriangle* triangles, const std::uint16_t* list,
              std::size_t count, std::uint32_t first_id, TileCounts& counts) {
    for (std::size_t k = 0; k < count; ++k) {
        const SetupTriangle& t = triangles[list[k]];
        const LocalBox box = local_box(t, tile);
        const std::uint32_t id = first_id + list[k];
        if constexpr (mode == ListMode::Depth || mode == ListMode::Ids) {
            if (t.small) {
                draw_small<mode == ListMode::Ids>(state, tile, t, box, id, counts);
                continue;
            }
        }
        draw_blocks<mode>(state, tile, t, box, id, counts);
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
