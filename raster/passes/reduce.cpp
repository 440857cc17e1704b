#include "raster/passes/reduce.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "core/vector_clones.h"
#include "raster/passes/rows.h"

namespace gnomon {
namespace {

constexpr size_t lanes = 8;           // of a sum
constexpr size_t scan_rows_grain = 4; // rows of one task
constexpr size_t scan_stripe = 256;   // columns of one task

// NaN loses every comparison, so it never replaces anything.
GNOMON_VECTOR_CLONES
MinMax min_max_leaf(const float* values, size_t count) {
    float minimum[lanes], maximum[lanes];
    std::fill_n(minimum, lanes, infinity);
    std::fill_n(maximum, lanes, -infinity);
    const size_t whole = count / lanes * lanes;
    for (size_t i = 0; i < whole; i += lanes)
        for (size_t j = 0; j < lanes; ++j) {
            minimum[j] = values[i + j] < minimum[j] ? values[i + j] : minimum[j];
            maximum[j] = values[i + j] > maximum[j] ? values[i + j] : maximum[j];
        }
    MinMax result;
    for (size_t i = whole; i < count; ++i) {
        result.minimum = values[i] < result.minimum ? values[i] : result.minimum;
        result.maximum = values[i] > result.maximum ? values[i] : result.maximum;
    }
    for (size_t j = 0; j < lanes; ++j) {
        result.minimum = std::min(result.minimum, minimum[j]);
        result.maximum = std::max(result.maximum, maximum[j]);
    }
    return result;
}

MinMax merge(MinMax a, MinMax b) { return {std::min(a.minimum, b.minimum), std::max(a.maximum, b.maximum)}; }

template <class T> double sum_leaf(const T* values, size_t count) {
    std::array<double, lanes> sums{};
    const size_t whole = count / lanes * lanes;
    for (size_t i = 0; i < whole; i += lanes)
        for (size_t j = 0; j < lanes; ++j) sums[j] += static_cast<double>(values[i + j]);
    for (size_t i = whole; i < count; ++i) sums[i - whole] += static_cast<double>(values[i]);
    return ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7]));
}

template <class T> double sum_in_double(Pass& pass, std::span<const T> values) {
    detail::count_reduction(pass, values.size(), sizeof(T), sizeof(double));
    return reduce_leaves<double>(
        values.size(), 0.0, [&](size_t begin, size_t end) { return sum_leaf(values.data() + begin, end - begin); },
        [](double a, double b) { return a + b; });
}

// term(value) -> std::int64_t, summed.
template <class T, class Term> std::int64_t sum_integers(Pass& pass, std::span<const T> values, const Term& term) {
    detail::count_reduction(pass, values.size(), sizeof(T), sizeof(std::int64_t));
    const auto leaf = [&](size_t begin, size_t end) {
        std::int64_t sum = 0;
        for (const T value : values.subspan(begin, end - begin)) sum += term(value);
        return sum;
    };
    return reduce_leaves<std::int64_t>(values.size(), 0, leaf, [](std::int64_t a, std::int64_t b) { return a + b; });
}

// One run of values after another, in place; returns the whole sum.
template <class T> T scan_run(T* values, size_t count, Scan kind) {
    T sum{};
    for (size_t i = 0; i < count; ++i) {
        const T before = sum;
        sum += values[i];
        values[i] = kind == Scan::Inclusive ? sum : before;
    }
    return sum;
}

} // namespace

void detail::count_reduction(Pass& pass, size_t count, size_t element_bytes, size_t result_bytes) {
    PassCounters& counters = pass.counters();
    const auto leaves = static_cast<std::int64_t>(chunk_count(count, reduce_leaf));
    const std::int64_t inner = leaves > 1 ? leaves - 1 : 0; // nodes of the tree above the leaves
    counters.draws += 1;
    counters.texels_fetched += static_cast<std::int64_t>(count) + 2 * inner;
    counters.bytes_read +=
        static_cast<std::int64_t>(count * element_bytes) + 2 * inner * static_cast<std::int64_t>(result_bytes);
    counters.bytes_written += (leaves + inner) * static_cast<std::int64_t>(result_bytes);
}

void detail::count_scan(Pass& pass, size_t count, size_t element_bytes) {
    PassCounters& counters = pass.counters();
    counters.draws += 1;
    counters.texels_fetched += static_cast<std::int64_t>(count);
    counters.bytes_read += static_cast<std::int64_t>(count * element_bytes);
    counters.bytes_written += static_cast<std::int64_t>(count * element_bytes);
}

MinMax reduce_min_max(Pass& pass, std::span<const float> values) {
    detail::count_reduction(pass, values.size(), sizeof(float), sizeof(MinMax));
    return reduce_leaves<MinMax>(
        values.size(), {}, [&](size_t begin, size_t end) { return min_max_leaf(values.data() + begin, end - begin); },
        merge);
}

MinMax reduce_min_max(Pass& pass, const Target& target, int layer) {
    const FormatInfo& format = info(target.format());
    const auto width = static_cast<size_t>(target.width()), height = static_cast<size_t>(target.height());
    const auto channels = static_cast<size_t>(format.channels);
    detail::count_reduction(pass, width * height, static_cast<size_t>(format.bytes), sizeof(MinMax));
    std::vector<MinMax> rows(height); // minima need no order, so rows will do for leaves
    parallel_for(height, scan_rows_grain, [&](size_t begin, size_t end) {
        std::vector<float> row;
        for (size_t y = begin; y < end; ++y) {
            detail::load_row(target, static_cast<int>(y), layer, 0, row);
            for (size_t x = 1; x < width; ++x) row[x] = row[x * channels];
            rows[y] = min_max_leaf(row.data(), width);
        }
    });
    MinMax result;
    for (const MinMax& row : rows) result = merge(result, row);
    return result;
}

double reduce_sum(Pass& pass, std::span<const float> values) { return sum_in_double(pass, values); }
double reduce_sum(Pass& pass, std::span<const double> values) { return sum_in_double(pass, values); }

std::int64_t reduce_sum(Pass& pass, std::span<const std::uint8_t> values) {
    return sum_integers(pass, values, [](std::uint8_t v) { return std::int64_t{v}; });
}
std::int64_t reduce_sum(Pass& pass, std::span<const std::int32_t> values) {
    return sum_integers(pass, values, [](std::int32_t v) { return std::int64_t{v}; });
}
std::int64_t reduce_sum(Pass& pass, std::span<const std::uint32_t> values) {
    return sum_integers(pass, values, [](std::uint32_t v) { return std::int64_t{v}; });
}

std::int64_t reduce_count(Pass& pass, std::span<const std::uint8_t> values) {
    return sum_integers(pass, values, [](std::uint8_t v) { return std::int64_t{v != 0}; });
}
std::int64_t reduce_count(Pass& pass, std::span<const std::uint32_t> values) {
    return sum_integers(pass, values, [](std::uint32_t v) { return std::int64_t{v != 0}; });
}

template <class T> void scan(Pass& pass, std::span<T> values, Scan kind) {
    detail::count_scan(pass, values.size(), sizeof(T));
    std::vector<T> offsets(chunk_count(values.size(), reduce_leaf));
    parallel_for(values.size(), reduce_leaf, [&](size_t begin, size_t end) {
        offsets[begin / reduce_leaf] = scan_run(values.data() + begin, end - begin, kind);
    });
    scan_run(offsets.data(), offsets.size(), Scan::Exclusive);
    parallel_for(values.size(), reduce_leaf, [&](size_t begin, size_t end) {
        const T offset = offsets[begin / reduce_leaf];
        for (size_t i = begin; i < end; ++i) values[i] += offset;
    });
}

template <class T> void scan_rows(Pass& pass, Image<T>& image, Scan kind) {
    detail::count_scan(pass, image.size(), sizeof(T));
    parallel_for(static_cast<size_t>(image.height()), scan_rows_grain, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            scan_run(image.row(static_cast<int>(y)).data(), static_cast<size_t>(image.width()), kind);
    });
}

template <class T> void scan_columns(Pass& pass, Image<T>& image, Scan kind) {
    detail::count_scan(pass, image.size(), sizeof(T));
    parallel_for(static_cast<size_t>(image.width()), scan_stripe, [&](size_t begin, size_t end) {
        std::vector<T> sums(end - begin, T{});
        for (int y = 0; y < image.height(); ++y) {
            T* row = image.row(y).data() + begin;
            for (size_t x = 0; x < sums.size(); ++x) {
                const T before = sums[x];
                sums[x] += row[x];
                row[x] = kind == Scan::Inclusive ? sums[x] : before;
            }
        }
    });
}

#define GNOMON_SCANS(T)                                                                                                \
    template void scan(Pass&, std::span<T>, Scan);                                                                     \
    template void scan_rows(Pass&, Image<T>&, Scan);                                                                   \
    template void scan_columns(Pass&, Image<T>&, Scan);
GNOMON_SCANS(std::uint32_t)
GNOMON_SCANS(std::int64_t)
GNOMON_SCANS(float)
GNOMON_SCANS(double)
#undef GNOMON_SCANS

std::vector<std::int64_t> histogram(Pass& pass, std::span<const float> values, const HistogramRange& range) {
    assert(range.bins > 0 && range.low < range.high);
    const auto bins = static_cast<size_t>(range.bins);
    // At most 64 partial histograms, however long the array.
    const size_t grain = std::max(size_t{65536}, chunk_count(values.size(), 64));
    std::vector<std::int64_t> partial(chunk_count(values.size(), grain) * bins, 0);
    parallel_for(values.size(), grain, [&](size_t begin, size_t end) {
        std::int64_t* counts = partial.data() + begin / grain * bins;
        for (const float value : values.subspan(begin, end - begin)) {
            const double place = (static_cast<double>(value) - range.low) / (range.high - range.low);
            if (place != place || (range.outliers == Outliers::Drop && (place < 0.0 || place > 1.0))) continue;
            const double bin = std::clamp(place, 0.0, 1.0) * static_cast<double>(bins);
            ++counts[std::min(static_cast<size_t>(bin), bins - 1)];
        }
    });
    std::vector<std::int64_t> total(bins, 0);
    for (size_t i = 0; i < partial.size(); ++i) total[i % bins] += partial[i];
    detail::count_reduction(pass, values.size(), sizeof(float), 0);
    pass.counters().bytes_written += static_cast<std::int64_t>(bins * sizeof(std::int64_t));
    return total;
}

} // namespace gnomon
