#include "raster/tile.h"

#include <algorithm>
#include <bit>

#include <emmintrin.h>

#include "raster/blend.h"

namespace gnomon::detail {
namespace {

constexpr std::uint64_t all_pixels = ~std::uint64_t{0};

TileEdges rebase(const SetupTriangle& t, int tile_x, int tile_y) {
    TileEdges edges;
    constexpr std::int64_t span = tile_side - 1;
    for (int e = 0; e < 3; ++e) {
        const std::int64_t corner =
            t.a[e] * (std::int64_t{tile_x} * 256 + 128) + t.b[e] * (std::int64_t{tile_y} * 256 + 128) + t.c[e];
        const std::int64_t base = corner >> 8;
        const std::int64_t least =
            base + span * (std::min<std::int64_t>(t.a[e], 0) + std::min<std::int64_t>(t.b[e], 0));
        const std::int64_t most = base + span * (std::max<std::int64_t>(t.a[e], 0) + std::max<std::int64_t>(t.b[e], 0));
        edges.empty |= most < 0;
        const bool inside = least >= 0;
        edges.base[e] = inside || most < 0 ? 0 : static_cast<std::int32_t>(base);
        edges.a[e] = inside ? 0 : static_cast<std::int32_t>(t.a[e]);
        edges.b[e] = inside ? 0 : static_cast<std::int32_t>(t.b[e]);
    }
    return edges;
}

// Pixels of the block at (x, y) that lie in the inclusive box.
std::uint64_t box_mask(const SetupTriangle& t, int x, int y) {
    const int x0 = std::max(t.x0 - x, 0), x1 = std::min(t.x1 - x, block_side - 1);
    const int y0 = std::max(t.y0 - y, 0), y1 = std::min(t.y1 - y, block_side - 1);
    if (x0 > x1 || y0 > y1) return 0;
    const std::uint64_t row = (0xffull >> (7 - x1)) & (0xffull << x0) & 0xff;
    const std::uint64_t rows = (all_pixels >> (8 * (7 - y1))) & (all_pixels << (8 * y0));
    return (row * 0x0101010101010101ull) & rows;
}

using Keys = std::array<std::uint32_t, 64>;

template <class Visit> void for_each_pixel(std::uint64_t mask, const Visit& visit) {
    for (; mask; mask &= mask - 1) visit(std::countr_zero(mask));
}

template <class Visit> void for_each_row(std::uint64_t mask, const Visit& visit) {
    for (int j = 0; mask; ++j, mask >>= 8)
        if (mask & 0xff) visit(j, static_cast<std::uint32_t>(mask & 0xff));
}

using Depths = std::array<double, 64>;

// depth_key for values that are in [0, 1] already.
void quantize_depth(Format format, std::uint64_t mask, const Depths& depth, Keys& keys) {
    const double scale = format == Format::D16 ? 65535.0 : 16777215.0;
    for_each_row(mask, [&](int j, std::uint32_t) {
        const double* z = depth.data() + 8 * j;
        std::uint32_t* out = keys.data() + 8 * j;
        if (format == Format::D32F)
            for (int i = 0; i < block_side; ++i) out[i] = std::bit_cast<std::uint32_t>(static_cast<float>(z[i]));
        else
            for (int i = 0; i < block_side; ++i)
                out[i] = static_cast<std::uint32_t>(static_cast<std::int32_t>(z[i] * scale + 0.5));
    });
}

bool compare(Compare test, std::uint32_t fresh, std::uint32_t stored) {
    switch (test) {
    case Compare::Never:
        return false;
    case Compare::Less:
        return fresh < stored;
    case Compare::Equal:
        return fresh == stored;
    case Compare::LessEqual:
        return fresh <= stored;
    case Compare::Greater:
        return fresh > stored;
    case Compare::NotEqual:
        return fresh != stored;
    case Compare::GreaterEqual:
        return fresh >= stored;
    case Compare::Always:
        return true;
    }
    return true;
}

// Four lanes of a bit mask as all-ones words.
__m128i lane_mask(std::uint32_t lanes, int shift) {
    const __m128i bits = _mm_set_epi32(8 << shift, 4 << shift, 2 << shift, 1 << shift);
    return _mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32(static_cast<int>(lanes)), bits), bits);
}

__m128i load4(const std::uint32_t* at) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(at)); }
void store4(std::uint32_t* at, __m128i value) { _mm_storeu_si128(reinterpret_cast<__m128i*>(at), value); }

// Bit i: `fresh[i] test stored[i]`. Keys lie below 2³¹ (depths in [0, 1]), so that signed comparison orders them.
std::uint32_t compare_row(Compare test, const std::uint32_t* fresh, const std::uint32_t* stored) {
    std::uint32_t greater = 0, equal = 0;
    for (int half = 0; half < 2; ++half) {
        const __m128i a = load4(fresh + 4 * half), b = load4(stored + 4 * half);
        const auto bits = [&](__m128i lanes) {
            return static_cast<std::uint32_t>(_mm_movemask_ps(_mm_castsi128_ps(lanes))) << (4 * half);
        };
        greater |= bits(_mm_cmpgt_epi32(a, b));
        equal |= bits(_mm_cmpeq_epi32(a, b));
    }
    switch (test) {
    case Compare::Never:
        return 0;
    case Compare::Less:
        return ~(greater | equal) & 0xff;
    case Compare::Equal:
        return equal;
    case Compare::LessEqual:
        return ~greater & 0xff;
    case Compare::Greater:
        return greater;
    case Compare::NotEqual:
        return ~equal & 0xff;
    case Compare::GreaterEqual:
        return greater | equal;
    case Compare::Always:
        return 0xff;
    }
    return 0;
}

// stored[i] = fresh[i] in the lanes.
void store_row(std::uint32_t* stored, const std::uint32_t* fresh, std::uint32_t lanes) {
    for (int half = 0; half < 2; ++half) {
        const __m128i mask = lane_mask(lanes, 4 * half);
        const __m128i old = load4(stored + 4 * half), value = load4(fresh + 4 * half);
        store4(stored + 4 * half, _mm_or_si128(_mm_and_si128(mask, value), _mm_andnot_si128(mask, old)));
    }
}

// Adds one to the lanes, or subtracts it, wrapping.
void count_row(std::uint32_t* stored, std::uint32_t lanes, bool up) {
    for (int half = 0; half < 2; ++half) {
        const __m128i mask = lane_mask(lanes, 4 * half); // −1 in the lanes
        const __m128i old = load4(stored + 4 * half);
        store4(stored + 4 * half, up ? _mm_sub_epi32(old, mask) : _mm_add_epi32(old, mask));
    }
}

void count_row(std::uint8_t* stored, std::uint32_t lanes, bool up) {
    const __m128i mask =
        _mm_packs_epi16(_mm_packs_epi32(lane_mask(lanes, 0), lane_mask(lanes, 4)), _mm_setzero_si128());
    const __m128i old = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(stored));
    const __m128i fresh = up ? _mm_sub_epi8(old, mask) : _mm_add_epi8(old, mask);
    _mm_storel_epi64(reinterpret_cast<__m128i*>(stored), fresh);
}

std::uint32_t apply(StencilOp op, std::uint32_t value, std::uint32_t reference, std::uint32_t maximum) {
    switch (op) {
    case StencilOp::Keep:
        return value;
    case StencilOp::Zero:
        return 0;
    case StencilOp::Replace:
        return reference & maximum;
    case StencilOp::Increment:
        return value == maximum ? maximum : value + 1;
    case StencilOp::Decrement:
        return value == 0 ? 0 : value - 1;
    case StencilOp::Invert:
        return ~value & maximum;
    case StencilOp::IncrementWrap:
        return (value + 1) & maximum;
    case StencilOp::DecrementWrap:
        return (value - 1) & maximum;
    }
    return value;
}

// Whether rows of eight 32-bit values can be read and written at once: the block does not stick out of the target.
bool has_whole_rows(const Target& target, int x, int level) {
    return info(target.format()).bytes == 4 && x + block_side <= target.width(level);
}

// One block of one triangle on its way through the tests. Masks as in block_coverage.
struct BlockTests {
    const TileDraw& tile;
    const SetupTriangle& triangle;
    int x, y;
    int layer; // of the targets' memory: that of the sample
    PassCounters& counters;
    const Keys*
        keys; // of the pixels' depths; null where the kernel for whole D32F rows evaluates, tests and writes at once

    // Those that pass depth bounds, stencil and depth; updates stencil and depth memory.
    std::uint64_t run(std::uint64_t mask) {
        mask = depth_bounds(mask);
        const std::uint64_t stencil_passed = stencil_test(mask);
        const std::uint64_t passed = depth_test(stencil_passed);
        stencil_update(mask & ~stencil_passed, face().fail);
        stencil_update(stencil_passed & ~passed, face().depth_fail);
        stencil_update(passed, face().pass);
        return passed;
    }

private:
    Target* depth() const { return tile.targets->depth; }
    Target* stencil() const { return tile.state->stencil.enabled ? tile.targets->stencil : nullptr; }
    int level() const { return tile.targets->level; }
    const StencilFace& face() const { return triangle.front ? tile.state->stencil.front : tile.state->stencil.back; }
    std::uint32_t stored(const Target& target, int bit) const {
        return target.load_key(x + (bit & 7), y + (bit >> 3), layer, level());
    }

    bool whole_rows(const Target& target) const { return has_whole_rows(target, x, level()); }
    template <class T> T* row_of(Target& target, int j) const { return target.row<T>(y + j, layer, level()) + x; }

    std::uint64_t depth_bounds(std::uint64_t mask) {
        if (!depth() || !tile.state->depth.bounds) return mask;
        const auto [minimum, maximum] = *tile.state->depth.bounds;
        const Format format = depth()->format();
        counters.bytes_read += std::popcount(mask) * info(format).bytes;
        std::uint64_t inside = mask;
        for_each_pixel(mask, [&](int bit) {
            const float z = depth_from_key(format, stored(*depth(), bit));
            if (z < minimum || z > maximum) inside &= ~(std::uint64_t{1} << bit);
        });
        return inside;
    }

    std::uint64_t stencil_test(std::uint64_t mask) {
        if (!stencil()) return mask;
        counters.bytes_read += std::popcount(mask) * info(stencil()->format()).bytes;
        const StencilFace& f = face();
        if (f.test == Compare::Always) return mask;
        std::uint64_t passed = mask;
        for_each_pixel(mask, [&](int bit) {
            if (!compare(f.test, f.reference & f.read_mask, stored(*stencil(), bit) & f.read_mask))
                passed &= ~(std::uint64_t{1} << bit);
        });
        return passed;
    }

    // Tests, and writes those that pass.
    std::uint64_t depth_test(std::uint64_t mask) {
        const DepthState& state = tile.state->depth;
        if (!depth() || !mask) return mask;
        const int bytes = info(depth()->format()).bytes;
        if (state.test != Compare::Always) counters.bytes_read += std::popcount(mask) * bytes;
        std::uint64_t passed = mask;
        if (!keys) {
            if (state.test == Compare::Always && !state.write) return mask;
            passed = tile.kernels->test_d32f(triangle, x, y, mask, row_of<float>(*depth(), 0),
                                             static_cast<size_t>(depth()->width(level())), state.test, state.write);
        } else {
            if (state.test != Compare::Always) passed = test_keys(mask);
            if (state.write) write_keys(passed);
        }
        if (state.write) counters.bytes_written += std::popcount(passed) * bytes;
        return passed;
    }

    std::uint64_t test_keys(std::uint64_t mask) {
        const Compare test = tile.state->depth.test;
        std::uint64_t passed = mask;
        if (whole_rows(*depth())) {
            for_each_row(mask, [&](int j, std::uint32_t lanes) {
                const std::uint32_t kept = compare_row(test, keys->data() + 8 * j, row_of<std::uint32_t>(*depth(), j));
                passed &= ~(static_cast<std::uint64_t>(lanes & ~kept) << (8 * j));
            });
        } else {
            for_each_pixel(mask, [&](int bit) {
                if (!compare(test, (*keys)[static_cast<size_t>(bit)], stored(*depth(), bit)))
                    passed &= ~(std::uint64_t{1} << bit);
            });
        }
        return passed;
    }

    void write_keys(std::uint64_t mask) {
        if (whole_rows(*depth()))
            for_each_row(mask, [&](int j, std::uint32_t lanes) {
                store_row(row_of<std::uint32_t>(*depth(), j), keys->data() + 8 * j, lanes);
            });
        else
            for_each_pixel(mask, [&](int bit) {
                depth()->store_key(x + (bit & 7), y + (bit >> 3), layer, (*keys)[static_cast<size_t>(bit)], level());
            });
    }

    void stencil_update(std::uint64_t mask, StencilOp op) {
        if (!stencil() || op == StencilOp::Keep || !mask) return;
        const int bytes = info(stencil()->format()).bytes;
        const std::uint32_t maximum = bytes == 1 ? 0xffu : 0xffffffffu;
        const StencilFace& f = face();
        counters.bytes_written += std::popcount(mask) * bytes;
        const bool counts = op == StencilOp::IncrementWrap || op == StencilOp::DecrementWrap;
        if (counts && (f.write_mask & maximum) == maximum && x + block_side <= stencil()->width(level())) {
            for_each_row(mask, [&](int j, std::uint32_t lanes) {
                if (bytes == 1)
                    count_row(row_of<std::uint8_t>(*stencil(), j), lanes, op == StencilOp::IncrementWrap);
                else
                    count_row(row_of<std::uint32_t>(*stencil(), j), lanes, op == StencilOp::IncrementWrap);
            });
            return;
        }
        for_each_pixel(mask, [&](int bit) {
            const std::uint32_t old = stored(*stencil(), bit);
            const std::uint32_t fresh = apply(op, old, f.reference, maximum);
            stencil()->store_key(x + (bit & 7), y + (bit >> 3), layer, (old & ~f.write_mask) | (fresh & f.write_mask),
                                 level());
        });
    }
};

using Colors = std::array<std::array<vec4, 64>, max_color_targets>;

glm::uvec4 combined(LogicOp op, glm::uvec4 source, const Target& target, int x, int y, int layer, int level) {
    switch (op) {
    case LogicOp::Copy:
        return source;
    case LogicOp::Clear:
        return glm::uvec4(0);
    case LogicOp::Set:
        return glm::uvec4(0xffffffffu);
    case LogicOp::And:
        return source & target.load_uint(x, y, layer, level);
    case LogicOp::Or:
        return source | target.load_uint(x, y, layer, level);
    case LogicOp::Xor:
        return source ^ target.load_uint(x, y, layer, level);
    case LogicOp::Invert:
        return ~target.load_uint(x, y, layer, level);
    }
    return source;
}

void write_colors(const TileDraw& tile, int x, int y, int layer, std::uint64_t mask, const Colors& colors,
                  PassCounters& counters) {
    const int level = tile.targets->level;
    for (size_t c = 0; c < tile.targets->color.size(); ++c) {
        Target* target = tile.targets->color[c];
        const std::uint8_t channels = tile.state->color_mask[c];
        if (!target || channels == 0) continue;
        const FormatInfo& format = info(target->format());
        const bool integer = format.kind == FormatInfo::Kind::Uint;
        const bool blended = tile.state->blend.enabled && !integer;
        counters.bytes_written += std::popcount(mask) * format.bytes;
        const bool reads = blended || (integer && tile.state->logic_op >= LogicOp::And);
        if (reads) counters.bytes_read += std::popcount(mask) * format.bytes;
        for_each_pixel(mask, [&](int bit) {
            const int px = x + (bit & 7), py = y + (bit >> 3);
            const vec4 source = colors[c][static_cast<size_t>(bit)];
            if (integer) {
                const glm::uvec4 bits = glm::floatBitsToUint(source);
                target->store_uint(px, py, layer, combined(tile.state->logic_op, bits, *target, px, py, layer, level),
                                   channels, level);
            } else if (blended)
                target->store(px, py, layer, blend(tile.state->blend, source, target->load(px, py, layer, level)),
                              channels, level);
            else
                target->store(px, py, layer, source, channels, level);
        });
    }
}

// What one sample of a block has to show: the triangle as it sees it, the pixels it covers, its layer of the targets.
struct Sample {
    const SetupTriangle* triangle;
    std::uint64_t mask;
    int layer;
};

// The fragment program on a block, its inputs and outputs.
struct Shading {
    const TileDraw& tile;
    PassCounters& counters;
    Colors colors;
    FragmentBlock block;

    Shading(const TileDraw& t, const AttributePlanes* attributes, int x, int y, PassCounters& c)
        : tile(t), counters(c) {
        block.attributes = attributes;
        block.x = x, block.y = y;
        block.color = &colors;
        block.counters = &c;
    }
    // Runs it for the lanes; returns those that it keeps.
    std::uint64_t run(const SetupTriangle& triangle, std::uint64_t lanes, const Depths& depth) {
        block.triangle = &triangle;
        block.mask = lanes;
        for_each_pixel(lanes, [&](int bit) {
            block.depth[static_cast<size_t>(bit)] = static_cast<float>(depth[static_cast<size_t>(bit)]);
        });
        counters.fragments_shaded += std::popcount(lanes);
        tile.draw->fragments(block, tile.varyings);
        return block.mask;
    }
};

bool tests_wait(const Draw& draw) { return draw.flags.discards || draw.flags.writes_depth; }

// Tests a sample's fragments and counts those that pass. `written` is the program's own depth, or null.
std::uint64_t test_sample(const TileDraw& tile, const Sample& sample, int x, int y,
                          const std::array<float, 64>* written, PassCounters& counters) {
    const Target* target = tile.targets->depth;
    const bool fused =
        target && target->format() == Format::D32F && has_whole_rows(*target, x, tile.targets->level) && !written;
    Keys keys;
    if (target && written) {
        for_each_pixel(sample.mask, [&](int bit) {
            const auto i = static_cast<size_t>(bit);
            keys[i] = depth_key(target->format(), static_cast<double>((*written)[i]));
        });
    } else if (target && !fused) {
        Depths depth;
        tile.kernels->depth(*sample.triangle, x, y, sample.mask, depth.data());
        quantize_depth(target->format(), sample.mask, depth, keys);
    }
    BlockTests tests{tile, *sample.triangle, x, y, sample.layer, counters, fused ? nullptr : &keys};
    const std::uint64_t passed = tests.run(sample.mask);
    counters.fragments_passed += std::popcount(passed);
    return passed;
}

// A block through tests, program and blending. With several samples the program runs once a pixel, at its centre, for
// all samples that it is kept in; or, where it asks for that, once a sample, there.
void draw_block(const TileDraw& tile, const SetupTriangle& triangle, const AttributePlanes* attributes, int x, int y,
                std::span<Sample> samples, PassCounters& counters) {
    const Draw& draw = *tile.draw;
    std::uint64_t any = 0;
    for (const Sample& sample : samples) {
        counters.fragments_covered += std::popcount(sample.mask);
        any |= sample.mask;
    }
    if (!draw.fragments) {
        for (const Sample& sample : samples)
            if (sample.mask) test_sample(tile, sample, x, y, nullptr, counters);
        return;
    }
    if (samples.size() > 1 && draw.flags.per_sample) {
        for (Sample& sample : samples)
            if (sample.mask) {
                counters.fragments_covered -= std::popcount(sample.mask); // counted above
                draw_block(tile, *sample.triangle, attributes, x, y, std::span(&sample, 1), counters);
            }
        return;
    }

    Shading shading(tile, attributes, x, y, counters);
    Depths depth;
    const bool late = tests_wait(draw);
    if (late) {
        tile.kernels->depth(triangle, x, y, any, depth.data());
        const std::uint64_t kept = shading.run(triangle, any, depth);
        for (Sample& sample : samples) sample.mask &= kept;
    }
    any = 0;
    for (Sample& sample : samples) {
        const std::array<float, 64>* written = draw.flags.writes_depth ? &shading.block.depth : nullptr;
        if (sample.mask) sample.mask = test_sample(tile, sample, x, y, written, counters);
        any |= sample.mask;
    }
    if (!any) return;
    if (!late) {
        tile.kernels->depth(triangle, x, y, any, depth.data());
        shading.run(triangle, any, depth);
    }
    for (const Sample& sample : samples)
        if (sample.mask) write_colors(tile, x, y, sample.layer, sample.mask, shading.colors, counters);
}

} // namespace

void draw_in_tile(const TileDraw& tile, const SetupTriangle& triangle, const AttributePlanes* attributes, int tile_x,
                  int tile_y, PassCounters& counters) {
    const std::span<const glm::ivec2> positions = sample_positions(tile.targets->samples);
    const size_t count = positions.size();
    std::array<SetupTriangle, max_samples> moved; // left alone with one sample
    std::array<TileEdges, max_samples> edges;
    std::array<Sample, max_samples> samples;
    bool empty = true;
    for (size_t s = 0; s < count; ++s) {
        if (count > 1) moved[s] = seen_by_sample(triangle, positions[s]);
        samples[s].triangle = count > 1 ? &moved[s] : &triangle;
        samples[s].layer = tile.targets->layer * static_cast<int>(count) + static_cast<int>(s);
        edges[s] = rebase(*samples[s].triangle, tile_x, tile_y);
        empty = empty && edges[s].empty;
    }
    if (empty) return;
    const int x0 = std::max(triangle.x0, tile_x) & ~(block_side - 1);
    const int y0 = std::max(triangle.y0, tile_y) & ~(block_side - 1);
    const int x1 = std::min(triangle.x1, tile_x + tile_side - 1), y1 = std::min(triangle.y1, tile_y + tile_side - 1);
    for (int y = y0; y <= y1; y += block_side)
        for (int x = x0; x <= x1; x += block_side) {
            const int first = std::max(triangle.y0 - y, 0), last = std::min(triangle.y1 - y, block_side - 1);
            const std::uint64_t box = box_mask(triangle, x, y);
            std::uint64_t any = 0;
            for (size_t s = 0; s < count; ++s) {
                samples[s].mask =
                    edges[s].empty ? 0 : tile.kernels->coverage(edges[s], x - tile_x, y - tile_y, first, last) & box;
                any |= samples[s].mask;
            }
            if (any) draw_block(tile, triangle, attributes, x, y, std::span(samples.data(), count), counters);
        }
}

} // namespace gnomon::detail
