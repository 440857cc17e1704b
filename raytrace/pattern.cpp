#include "raytrace/pattern.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <string>

#include "core/error.h"
#include "core/random.h"
#include "core/vector_clones.h"

namespace gnomon {
namespace {

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x & 0xff00ff00u) >> 8) | ((x & 0x00ff00ffu) << 8);
    x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
    return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

// A permutation in which each bit depends on the bits below it only: on reversed bits, a nested uniform (Owen)
// scramble. Principle: Laine and Karras 2011, "Stratified Sampling for Stochastic Transparency"; use: Burley 2020,
// "Practical Hash-based Owen Scrambling", section 4; constants: Vegdahl 2021, "Building a Better LK Hash".
constexpr std::uint32_t nested_permutation(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

constexpr std::uint32_t owen_scramble_reversed(std::uint32_t reversed, std::uint32_t seed) {
    return reverse_bits(nested_permutation(reversed, seed));
}

GNOMON_VECTOR_CLONES
void scramble(std::span<const std::uint32_t> reversed, std::uint32_t seed, std::span<float> coordinates) {
    const std::uint32_t* from = reversed.data();
    float* __restrict to = coordinates.data();
    for (size_t k = 0; k < reversed.size(); ++k) to[k] = to_unit(owen_scramble_reversed(from[k], seed));
}

// Sobol's second dimension, bits reversed: the points are linear over GF(2), so that each power of two doubles the
// list. Its matrix is Pascal's triangle modulo 2, whose columns follow from v ^= v >> 1 [Sobol 1967; Kollig and Keller
// 2002].
std::vector<std::uint32_t> sobol_second_dimension(size_t count) {
    std::vector<std::uint32_t> y(count);
    std::uint32_t column = 0x80000000u;
    for (size_t half = 1; half < count; half *= 2) {
        const std::uint32_t reversed = reverse_bits(column);
        const size_t end = std::min(count, 2 * half);
        for (size_t i = half; i < end; ++i) y[i] = y[i - half] ^ reversed;
        column ^= column >> 1;
    }
    return y;
}

// Columns and rows of a grid of `samples` cells, as square as can be.
ivec2 grid_cells(int samples) {
    int rows = 1;
    for (int n = 1; n * n <= samples; ++n)
        if (samples % n == 0) rows = n;
    if (rows == 1 && samples > 3)
        throw UsageError("a grid of " + std::to_string(samples) +
                         " samples would be one row, because that is a prime number: choose a square such as 256");
    return {samples / rows, rows};
}

// Interleaves the upper 16 bits of two coordinates: sorted by it, neighbours in the list are neighbours in the square.
std::uint32_t morton(std::uint32_t x, std::uint32_t y) {
    const auto spread = [](std::uint32_t v) {
        v >>= 16;
        v = (v | (v << 8)) & 0x00ff00ffu;
        v = (v | (v << 4)) & 0x0f0f0f0fu;
        v = (v | (v << 2)) & 0x33333333u;
        return (v | (v << 1)) & 0x55555555u;
    };
    return spread(x) | (spread(y) << 1);
}

// An Owen scramble maps elementary intervals onto elementary intervals, so the order found on the unscrambled points
// keeps the scrambled points of every pixel together as well.
void pack(PreparedPattern& prepared) {
    std::vector<std::uint32_t> key(prepared.size());
    const auto columns = static_cast<std::uint32_t>(prepared.cells.x);
    for (std::uint32_t i = 0; i < key.size(); ++i)
        key[i] = prepared.pattern == Pattern::Sobol ? morton(reverse_bits(i), reverse_bits(prepared.y[i]))
                                                    : morton((i % columns) << 16, (i / columns) << 16);
    std::stable_sort(prepared.index.begin(), prepared.index.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return key[a] < key[b]; });
}

std::uint32_t pixel_seed(std::uint32_t pixel, std::uint32_t seed, Pattern pattern) {
    return hash(pixel, seed, static_cast<std::uint32_t>(pattern));
}

void fill_cells(const PreparedPattern& prepared, std::uint32_t key, bool jittered, std::span<float> u,
                std::span<float> v) {
    const auto columns = static_cast<std::uint32_t>(prepared.cells.x),
               rows = static_cast<std::uint32_t>(prepared.cells.y);
    constexpr float below_one = 1.0f - 0x1p-24f; // the last cell's sum may round up to 1
    for (size_t k = 0; k < prepared.size(); ++k) {
        const std::uint32_t i = prepared.index[k];
        const float du = jittered ? to_unit(hash(key, 2 * i)) : 0.5f;
        const float dv = jittered ? to_unit(hash(key, 2 * i + 1)) : 0.5f;
        u[k] = std::min((static_cast<float>(i % columns) + du) / static_cast<float>(columns), below_one);
        v[k] = std::min((static_cast<float>(i / columns) + dv) / static_cast<float>(rows), below_one);
    }
}

} // namespace

PreparedPattern prepare_pattern(Pattern pattern, int samples, SampleOrder order) {
    if (samples < 1) throw UsageError("a pattern needs at least one sample, not " + std::to_string(samples));
    PreparedPattern prepared;
    prepared.pattern = pattern;
    prepared.index.resize(static_cast<size_t>(samples));
    std::iota(prepared.index.begin(), prepared.index.end(), 0u);
    if (pattern == Pattern::Grid || pattern == Pattern::Stratified) prepared.cells = grid_cells(samples);
    if (pattern == Pattern::Sobol) prepared.y = sobol_second_dimension(prepared.size());
    if (order == SampleOrder::Packed && pattern != Pattern::Random) pack(prepared);
    if (pattern == Pattern::Sobol) {
        // The first dimension is the radical inverse: its reversed bits are the index.
        prepared.x = prepared.index;
        const std::vector<std::uint32_t> sequence = std::move(prepared.y);
        prepared.y.resize(prepared.size());
        for (size_t k = 0; k < prepared.size(); ++k) prepared.y[k] = sequence[prepared.index[k]];
    }
    return prepared;
}

void fill_pattern(const PreparedPattern& prepared, std::uint32_t pixel, std::uint32_t seed, std::span<float> u,
                  std::span<float> v) {
    assert(u.size() == prepared.size() && v.size() == prepared.size());
    const std::uint32_t key = pixel_seed(pixel, seed, prepared.pattern);
    const size_t count = prepared.size();
    switch (prepared.pattern) {
    case Pattern::Sobol: {
        scramble(prepared.x, hash(key, 1), u);
        scramble(prepared.y, hash(key, 2), v);
        break;
    }
    case Pattern::Stratified:
        fill_cells(prepared, key, true, u, v);
        break;
    case Pattern::Grid:
        fill_cells(prepared, key, false, u, v);
        break;
    case Pattern::Random:
        for (size_t k = 0; k < count; ++k) {
            const std::uint32_t i = prepared.index[k];
            u[k] = to_unit(hash(key, 2 * i));
            v[k] = to_unit(hash(key, 2 * i + 1));
        }
        break;
    }
}

void fill_pattern(Pattern pattern, std::uint32_t pixel, std::uint32_t seed, std::span<vec2> points) {
    if (points.empty()) return;
    const PreparedPattern prepared = prepare_pattern(pattern, static_cast<int>(points.size()), SampleOrder::Sequence);
    std::vector<float> u(points.size()), v(points.size());
    fill_pattern(prepared, pixel, seed, u, v);
    for (size_t i = 0; i < points.size(); ++i) points[i] = {u[i], v[i]};
}

} // namespace gnomon
