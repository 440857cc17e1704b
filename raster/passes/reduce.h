#pragma once
// Reductions, prefix sums and histograms over whole arrays: depth ranges, bounding boxes of samples, importance
// integrals. [Navrátil 2015, 2.10; Forest 2008, 6; Blelloch 1990]
//
// Orders are fixed, so that floats have the same bits for any number of threads: an array is cut into leaves of
// `reduce_leaf` elements; a leaf is combined as stated at each function; leaf results are combined in a balanced tree
// of neighbours, (0, 1), (2, 3), …, level by level, an odd last one rising as it is. NaN: minimum and maximum pass over
// it, sums and prefix sums keep it, histograms drop it.
//
// Cost: one compute pass, in which every element is fetched once, every leaf writes its result, and every node of the
// tree above fetches two results and writes one; a scan fetches and writes every element once; a histogram writes its
// bins once.

#include <span>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "raster/passes/min_max.h"

namespace gnomon {

inline constexpr size_t reduce_leaf = 4096;

namespace detail {
// The counters of a reduction of `count` elements, and of a scan.
void count_reduction(Pass& pass, size_t count, size_t element_bytes, size_t result_bytes);
void count_scan(Pass& pass, size_t count, size_t element_bytes);
} // namespace detail

// leaf(begin, end) -> T for every leaf, in parallel, then combine(T, T) -> T up the tree. `nothing` for count 0. The
// building block of the others, and of any reduction with a condition.
template <class T, class Leaf, class Combine>
T reduce_leaves(size_t count, const T& nothing, const Leaf& leaf, const Combine& combine) {
    std::vector<T> results(chunk_count(count, reduce_leaf), nothing);
    parallel_for(count, reduce_leaf,
                 [&](size_t begin, size_t end) { results[begin / reduce_leaf] = leaf(begin, end); });
    if (results.empty()) return nothing;
    for (size_t size = results.size(); size > 1; size = (size + 1) / 2) {
        for (size_t i = 0; i < size / 2; ++i) results[i] = combine(results[2 * i], results[2 * i + 1]);
        if (size % 2 == 1) results[size / 2] = results[size - 1];
    }
    return results[0];
}

// map(i) -> T of all i < count, combined from the left within a leaf, counted as fetches of `element_bytes`.
template <class T, class Map, class Combine>
T reduce(Pass& pass, size_t count, size_t element_bytes, const T& nothing, const Map& map, const Combine& combine) {
    detail::count_reduction(pass, count, element_bytes, sizeof(T));
    const auto leaf = [&](size_t begin, size_t end) {
        T result = map(begin);
        for (size_t i = begin + 1; i < end; ++i) result = combine(result, map(i));
        return result;
    };
    return reduce_leaves<T>(count, nothing, leaf, combine);
}

// The smallest and largest value; MinMax{} when there is none. −0 and +0 are equal, and either may come out.
MinMax reduce_min_max(Pass& pass, std::span<const float> values);
// Of the first channel of one layer of a target, of a depth or a colour format.
MinMax reduce_min_max(Pass& pass, const Target& target, int layer = 0);

// In double: eight running sums a leaf, sum j of elements j, j + 8, …, added up as ((0 + 4) + (2 + 6)) + ((1 + 5) + (3
// + 7)).
double reduce_sum(Pass& pass, std::span<const float> values);
double reduce_sum(Pass& pass, std::span<const double> values);
// Exact, unless 64 bits overflow.
std::int64_t reduce_sum(Pass& pass, std::span<const std::uint8_t> values);
std::int64_t reduce_sum(Pass& pass, std::span<const std::int32_t> values);
std::int64_t reduce_sum(Pass& pass, std::span<const std::uint32_t> values);

// How many are not zero.
std::int64_t reduce_count(Pass& pass, std::span<const std::uint8_t> values);
std::int64_t reduce_count(Pass& pass, std::span<const std::uint32_t> values);

// Prefix sums. Inclusive: element i becomes the sum of elements 0 to i; exclusive: of those before i. T is uint32
// (which wraps around), int64 (which must not overflow), float or double.
enum class Scan { Inclusive, Exclusive };

// In place. Integers are exact; floats: sums from the left within a leaf, leaf sums added from the left, then the sum
// of the leaves before it added to each element.
template <class T> void scan(Pass& pass, std::span<T> values, Scan kind);
// Every row from the left, every column from the bottom, one addition after the other.
template <class T> void scan_rows(Pass& pass, Image<T>& image, Scan kind);
template <class T> void scan_columns(Pass& pass, Image<T>& image, Scan kind);

// Counts of values in `bins` equal intervals of [low, high]: a value v falls into ⌊(v − low)/(high − low)·bins⌋, in
// double, `high` itself into the last. Outliers go into the end bins or are dropped; NaN is always dropped.
enum class Outliers { Clamp, Drop };
struct HistogramRange {
    double low = 0.0, high = 1.0; // low < high
    int bins = 256;
    Outliers outliers = Outliers::Clamp;
};
std::vector<std::int64_t> histogram(Pass& pass, std::span<const float> values, const HistogramRange& range);

} // namespace gnomon
