#include "raytrace/pattern.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/random.h"
#include "core/vector_clones.h"
#include "raytrace/poisson.h"

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

std::uint32_t fixed_point(double unit) { return static_cast<std::uint32_t>(unit * 4294967296.0); }

std::uint32_t third_radical_inverse(std::uint32_t i) {
    double value = 0, digit = 1;
    for (; i > 0; i /= 3) value += (digit /= 3) * (i % 3);
    return fixed_point(value);
}

// The places of the points before any pixel scrambles them, × 2³².
std::pair<std::uint32_t, std::uint32_t> unscrambled(const PreparedPattern& prepared, size_t k) {
    switch (prepared.pattern) {
    case Pattern::Sobol:
        return {reverse_bits(prepared.x[k]), reverse_bits(prepared.y[k])};
    case Pattern::Halton:
        return {reverse_bits(prepared.x[k]), third_radical_inverse(prepared.index[k])};
    case Pattern::Poisson:
        return {prepared.x[k], prepared.y[k]};
    case Pattern::Stratified:
    case Pattern::Grid: {
        const PatternCell& cell = prepared.cells[k];
        return {fixed_point((cell.column + 0.5) / cell.columns),
                fixed_point((cell.first + 0.5 * cell.columns) / prepared.samples)};
    }
    case Pattern::Random:
        break;
    }
    return {0, 0};
}

template <class T> void reorder(std::vector<T>& values, const std::vector<std::uint32_t>& order) {
    if (values.empty()) return;
    std::vector<T> sorted(values.size());
    for (size_t k = 0; k < order.size(); ++k) sorted[k] = values[order[k]];
    values = std::move(sorted);
}

// A scramble of digits maps elementary intervals onto elementary intervals, and a shift keeps neighbours, so the order
// found on the unscrambled points keeps the points of every pixel together as well. Halton's intervals are thirds of
// the height, which Morton's order would cut across: its points go by 8 × 9 of them first.
void pack(PreparedPattern& prepared) {
    std::vector<std::uint64_t> key(prepared.size());
    for (size_t k = 0; k < key.size(); ++k) {
        const auto [x, y] = unscrambled(prepared, k);
        key[k] = morton(x, y);
        if (prepared.pattern == Pattern::Halton) key[k] |= ((std::uint64_t{y} * 9 >> 32) * 8 + (x >> 29)) << 32;
    }
    std::vector<std::uint32_t> order(prepared.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key[a] < key[b]; });
    reorder(prepared.index, order);
    reorder(prepared.cells, order);
    reorder(prepared.x, order);
    reorder(prepared.y, order);
}

std::uint32_t pixel_seed(std::uint32_t pixel, std::uint32_t seed, Pattern pattern) {
    return hash(pixel, seed, static_cast<std::uint32_t>(pattern));
}

constexpr float below_one = 1.0f - 0x1p-24f; // sums may round up to 1

void fill_cells(const PreparedPattern& prepared, std::uint32_t key, bool jittered, std::span<float> u,
                std::span<float> v) {
    for (size_t k = 0; k < prepared.size(); ++k) {
        const std::uint32_t i = prepared.index[k];
        const PatternCell& cell = prepared.cells[k];
        const float du = jittered ? to_unit(hash(key, 2 * i)) : 0.5f;
        const float dv = jittered ? to_unit(hash(key, 2 * i + 1)) : 0.5f;
        u[k] = std::min((cell.column + du) / cell.columns, below_one);
        v[k] = std::min((cell.first + dv * cell.columns) / static_cast<float>(prepared.samples), below_one);
    }
}

// The radical inverse in base 3 with every digit's place permuted by itself: uniform, because each digit is, and every
// run of 3^k points has one in each 3^k-th of the unit interval, as without permutations [Halton 1960; Braaten and
// Weller 1979]. Five digits at a time are looked up; what follows the last digits is the same random rest for all.
class ThirdRadicalInverse {
public:
    ThirdRadicalInverse(std::uint32_t key, std::uint32_t largest_index) {
        std::uint64_t weight = one, reach = 1; // integers, so that no sum depends on how many digits are looked up
        for (std::uint32_t level = 0; level < 5 * tables_.size();) {
            const bool needed = reach <= largest_index;
            std::array<std::uint64_t, run> values{};
            for (std::uint32_t below = 1; below < run; below *= 3, ++level) {
                weight /= 3;
                const std::array<std::uint8_t, 3>& permutation = permutations[hash(key, level) % 6];
                if (needed)
                    for (std::uint32_t i = 3 * below; i-- > 0;)
                        values[i] = values[i % below] + weight * permutation[i / below];
                else
                    rest_ += weight * permutation[0];
            }
            if (needed) tables_[used_++] = values;
            reach *= run;
        }
        rest_ += weight * hash(key, 5 * static_cast<std::uint32_t>(tables_.size())) >> 32;
    }

    float operator()(std::uint32_t index) const {
        std::uint64_t value = rest_;
        for (size_t t = 0; t < used_; ++t, index /= run) value += tables_[t][index % run];
        return to_unit(static_cast<std::uint32_t>(value >> 24));
    }

private:
    static constexpr std::uint64_t one = std::uint64_t{1} << 56;
    static constexpr std::uint32_t run = 243;
    static constexpr std::array<std::array<std::uint8_t, 3>, 6> permutations = {
        {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    std::array<std::array<std::uint64_t, run>, 3> tables_; // 3¹⁵ indices
    size_t used_ = 0;
    std::uint64_t rest_ = 0;
};

// What does not depend on the pixel, for points first … samples − 1 in sequence.
void prepare_points(PreparedPattern& prepared, std::uint32_t first) {
    const auto from = static_cast<std::ptrdiff_t>(first);
    switch (prepared.pattern) {
    case Pattern::Sobol: {
        const std::vector<std::uint32_t> y = sobol_second_dimension(prepared.samples);
        prepared.x = prepared.index; // the first dimension is the radical inverse: its reversed bits are the index
        prepared.y.assign(y.begin() + from, y.end());
        break;
    }
    case Pattern::Halton:
        prepared.x = prepared.index;
        break;
    case Pattern::Poisson:
        for (const TorusPoint point : best_candidates(prepared.samples))
            prepared.x.push_back(point.x), prepared.y.push_back(point.y);
        prepared.x.erase(prepared.x.begin(), prepared.x.begin() + from);
        prepared.y.erase(prepared.y.begin(), prepared.y.begin() + from);
        break;
    case Pattern::Stratified:
    case Pattern::Grid:
        for (const std::uint32_t i : prepared.index) prepared.cells.push_back(grid_cell(i, prepared.samples));
        break;
    case Pattern::Random:
        break;
    }
}

} // namespace

// Rows of as nearly the same number of cells as can be, row j from cell ⌊j·N/rows⌋ on.
PatternCell grid_cell(std::uint32_t i, std::uint32_t samples) {
    const auto rows = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::lround(std::sqrt(samples))));
    const auto start = [&](std::uint64_t row) { return row * samples / rows; };
    const std::uint64_t row = ((i + 1) * rows - 1) / samples;
    return {static_cast<float>(i - start(row)), static_cast<float>(start(row + 1) - start(row)),
            static_cast<float>(start(row))};
}

PreparedPattern prepare_pattern(Pattern pattern, int samples, SampleOrder order, int first) {
    if (samples < 1) throw UsageError("a pattern needs at least one sample, not " + std::to_string(samples));
    if (first < 0 || first >= samples)
        throw UsageError("a pattern of " + std::to_string(samples) + " samples cannot go on from " +
                         std::to_string(first));
    PreparedPattern prepared;
    prepared.pattern = pattern;
    prepared.samples = static_cast<std::uint32_t>(samples);
    prepared.index.resize(static_cast<size_t>(samples - first));
    std::iota(prepared.index.begin(), prepared.index.end(), static_cast<std::uint32_t>(first));
    prepare_points(prepared, static_cast<std::uint32_t>(first));
    if (order == SampleOrder::Packed && pattern != Pattern::Random) pack(prepared);
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
    case Pattern::Halton: {
        scramble(prepared.x, hash(key, 1), u);
        const ThirdRadicalInverse inverse(hash(key, 2), prepared.samples - 1);
        for (size_t k = 0; k < count; ++k) v[k] = inverse(prepared.index[k]);
        break;
    }
    case Pattern::Poisson:
        for (size_t k = 0; k < count; ++k) {
            u[k] = to_unit(prepared.x[k] + hash(key, 1));
            v[k] = to_unit(prepared.y[k] + hash(key, 2));
        }
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
