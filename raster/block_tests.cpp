#include "raster/block_tests.h"

#include <emmintrin.h>

#include "raster/compare.h"

namespace gnomon::detail {
namespace {

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
        const DepthState::Bounds bounds = *tile.state->depth.bounds;
        const Format format = depth()->format();
        counters.bytes_read += std::popcount(mask) * info(format).bytes;
        std::uint64_t inside = mask;
        for_each_pixel(mask, [&](int bit) {
            const float z = depth_from_key(format, stored(*depth(), bit));
            if (z < bounds.minimum || z > bounds.maximum) inside &= ~(std::uint64_t{1} << bit);
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
            if (!holds(f.test, f.reference & f.read_mask, stored(*stencil(), bit) & f.read_mask))
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
                if (!holds(test, (*keys)[static_cast<size_t>(bit)], stored(*depth(), bit)))
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

} // namespace

bool has_whole_rows(const Target& target, int x, int level) {
    return info(target.format()).bytes == 4 && x + block_side <= target.width(level);
}

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

std::uint64_t run_tests(const TileDraw& tile, const SetupTriangle& triangle, int x, int y, int layer,
                        std::uint64_t mask, const Keys* keys, PassCounters& counters) {
    return BlockTests{tile, triangle, x, y, layer, counters, keys}.run(mask);
}

} // namespace gnomon::detail
