#include "raster/passes/summed_area.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <type_traits>
#include <vector>

#include "core/vector_clones.h"
#include "raster/full_screen.h"
#include "raster/passes/rows.h"

namespace gnomon {
namespace {

constexpr size_t stripe_values = 256; // values across of one task along columns
constexpr size_t near_rows = 64;      // a power of two
constexpr size_t band_rows = 256;
constexpr size_t rows_of_task = 16;

template <class T> constexpr bool fixed_point = std::is_integral_v<T>;

// (value − offset) · scale within [lowest, highest], rounded to nearest even; NaN is 0.
struct FixedPoint {
    double offset, scale, lowest, highest;
};

// Adding 1.5·2⁵² to a number below 2⁵¹ leaves its nearest integer in the low bits.
constexpr double rounding = 0x1.8p52;
inline std::int64_t nearest(float value, const FixedPoint& fixed) {
    double scaled = (static_cast<double>(value) - fixed.offset) * fixed.scale;
    scaled = scaled < fixed.lowest ? fixed.lowest : scaled;
    scaled = scaled > fixed.highest ? fixed.highest : scaled;
    scaled = scaled == scaled ? scaled : 0.0;
    return std::bit_cast<std::int64_t>(scaled + rounding) - std::bit_cast<std::int64_t>(rounding);
}

GNOMON_VECTOR_CLONES
void store_row(const float* values, size_t count, const FixedPoint& fixed, std::int64_t* row) {
    for (size_t i = 0; i < count; ++i) row[i] = nearest(values[i], fixed);
}
GNOMON_VECTOR_CLONES
void store_row(const float* values, size_t count, const FixedPoint& fixed, std::uint32_t* row) {
    for (size_t i = 0; i < count; ++i) row[i] = static_cast<std::uint32_t>(nearest(values[i], fixed));
}
GNOMON_VECTOR_CLONES
void store_row(const float* values, size_t count, const FixedPoint& fixed, double* row) {
    for (size_t i = 0; i < count; ++i) row[i] = static_cast<double>(values[i]) - fixed.offset;
}
GNOMON_VECTOR_CLONES
void store_row(const float* values, size_t count, const FixedPoint& fixed, float* row) {
    const auto offset = static_cast<float>(fixed.offset);
    for (size_t i = 0; i < count; ++i) row[i] = values[i] - offset;
}

GNOMON_VECTOR_CLONES
void add(std::int64_t* sum, const std::int64_t* values, size_t count) {
    for (size_t i = 0; i < count; ++i) sum[i] += values[i];
}
GNOMON_VECTOR_CLONES
void add(std::uint32_t* sum, const std::uint32_t* values, size_t count) {
    for (size_t i = 0; i < count; ++i) sum[i] += values[i];
}
GNOMON_VECTOR_CLONES
void add(double* sum, const double* values, size_t count) {
    for (size_t i = 0; i < count; ++i) sum[i] += values[i];
}

// out[i] = in[i] + in[i − step], where there is such a one.
GNOMON_VECTOR_CLONES
void add_step(const float* in, float* out, size_t count, size_t step) {
    std::copy(in, in + step, out);
    for (size_t i = step; i < count; ++i) out[i] = in[i] + in[i - step];
}

// The same twice, with `step` and with 2·step < count, in one go.
GNOMON_VECTOR_CLONES
void add_two_steps(const float* in, float* out, size_t count, size_t step) {
    add_step(in, out, 2 * step, step);
    const size_t ramp = std::min(3 * step, count);
    for (size_t i = 2 * step; i < ramp; ++i) out[i] = (in[i] + in[i - step]) + in[i - 2 * step];
    for (size_t i = 3 * step; i < count; ++i) out[i] = (in[i] + in[i - step]) + (in[i - 2 * step] + in[i - 3 * step]);
}

// Recursive doubling along an array whose neighbours are `step` apart, as a GPU's passes do it: each adds what the one
// before it left 2^k places back. Steps below `end`; the result is in `values`, `other` is as large.
void recursive_doubling(std::vector<float>& values, std::vector<float>& other, size_t step, size_t end) {
    end = std::min(end, values.size());
    while (step < end) {
        const bool two = 2 * step < end;
        (two ? add_two_steps : add_step)(values.data(), other.data(), values.size(), step);
        std::swap(values, other);
        step *= two ? 4 : 2;
    }
}

template <int channels, class T> void running_sums(T* row, size_t count) {
    T sum[channels];
    std::copy(row, row + channels, sum);
    for (size_t i = channels; i < count; i += channels)
        for (size_t c = 0; c < channels; ++c) row[i + c] = sum[c] = sum[c] + row[i + c];
}

// Running sums along a row, channel by channel.
template <class T> void sum_along(T* row, size_t count, int channels) {
    switch (channels) {
    case 1:
        return running_sums<1>(row, count);
    case 2:
        return running_sums<2>(row, count);
    case 3:
        return running_sums<3>(row, count);
    default:
        return running_sums<4>(row, count);
    }
}

// A row of the table from a row of the source, with running sums along it. `values` and `other` are as long and are
// used up.
template <class T>
void sum_row(std::vector<float>& values, std::vector<float>&, const FixedPoint& fixed, int channels, T* row) {
    store_row(values.data(), values.size(), fixed, row);
    sum_along(row, values.size(), channels);
}

void sum_row(std::vector<float>& values, std::vector<float>& other, const FixedPoint& fixed, int channels, float* row) {
    store_row(values.data(), values.size(), fixed, values.data());
    recursive_doubling(values, other, static_cast<size_t>(channels), values.size());
    std::copy(values.begin(), values.end(), row);
}

// Sums along the columns of a stripe of `count` values, row by row.
template <class T> void sum_up(T* first, size_t row_values, size_t height, size_t count) {
    for (size_t y = 1; y < height; ++y) add(first + y * row_values, first + (y - 1) * row_values, count);
}

// The same by recursive doubling, in two sweeps that stay in the cache: steps below near_rows in bands, from the top
// down, with what they need of the rows below; then the longer ones among rows that lie so many apart.
void sum_up(float* first, size_t row_values, size_t height, size_t count) {
    std::vector<float> values, other;
    const auto rows = [&](size_t begin, size_t stride, size_t number, size_t kept, size_t end) {
        values.resize(number * count), other.resize(number * count);
        for (size_t r = 0; r < number; ++r)
            std::copy_n(first + (begin + r * stride) * row_values, count, &values[r * count]);
        recursive_doubling(values, other, count, end * count);
        for (size_t r = number - kept; r < number; ++r)
            std::copy_n(&values[r * count], count, first + (begin + r * stride) * row_values);
    };
    for (size_t band = (height + band_rows - 1) / band_rows; band-- > 0;) {
        const size_t y = band * band_rows, below = std::min(y, near_rows - 1);
        const size_t kept = std::min(band_rows, height - y);
        rows(y - below, 1, below + kept, kept, near_rows);
    }
    for (size_t y = 0; y < near_rows && y + near_rows < height; ++y) {
        const size_t number = (height - y + near_rows - 1) / near_rows;
        rows(y, near_rows, number, number, number);
    }
}

// The passes of recursive doubling along an axis of `side` texels with `across` texels beside one another.
void count_doubling(PassCounters& counters, std::int64_t side, std::int64_t across, std::int64_t bytes) {
    for (std::int64_t step = 1; step < side; step *= 2) {
        detail::count_fragments(counters, side * across, (side + (side - step)) * across, bytes, bytes);
        ++counters.draws;
    }
}

// Where an extent along one axis lies between corners of the table: corner k is the sum of all texels before k.
struct Extent {
    int corners[4];     // below and above the low end, below and above the high end
    double fraction[2]; // of the low and the high end between its corners
    double length;
};

Extent extent_of(double low, double high, int side) {
    const auto inside = [&](double v) { return v > 0.0 ? std::min(v, static_cast<double>(side)) : 0.0; }; // NaN: 0
    low = inside(low);
    high = inside(high);
    if (!(low < high)) {
        low = std::min(std::floor(low), static_cast<double>(side - 1));
        high = low + 1.0;
    }
    Extent extent;
    const auto split = [&](double v, int end) {
        const int corner = std::min(static_cast<int>(v), side - 1);
        extent.corners[2 * end] = corner;
        extent.corners[2 * end + 1] = corner + 1;
        extent.fraction[end] = v - corner;
    };
    split(low, 0);
    split(high, 1);
    extent.length = high - low;
    return extent;
}

template <class Real> Real mix(Real a, Real b, Real t) { return a + (b - a) * t; }

// The integral over the rectangle, from the sixteen corner sums of one channel.
template <class Real> Real integral(const Real (&sums)[4][4], const Extent& x, const Extent& y) {
    const auto tap = [&](int ex, int ey) {
        const Real fx = static_cast<Real>(x.fraction[ex]), fy = static_cast<Real>(y.fraction[ey]);
        return mix(mix(sums[2 * ey][2 * ex], sums[2 * ey][2 * ex + 1], fx),
                   mix(sums[2 * ey + 1][2 * ex], sums[2 * ey + 1][2 * ex + 1], fx), fy);
    };
    return tap(1, 1) - tap(0, 1) - tap(1, 0) + tap(0, 0);
}

void count_fetches(PassCounters& counters, std::int64_t texels, size_t texel_bytes) {
    counters.texels_fetched += texels;
    counters.bytes_read += texels * static_cast<std::int64_t>(texel_bytes);
}

} // namespace

template <class T> SummedArea<T> summed_area(Pass& pass, const Target& source, const SummedAreaOptions& options) {
    assert(options.fraction_bits >= 0 && options.fraction_bits <= 31);
    const int width = source.width(), height = source.height(), channels = info(source.format()).channels;
    const auto row_values = static_cast<size_t>(width * channels);
    const double scale = fixed_point<T> ? std::ldexp(1.0, options.fraction_bits) : 1.0;
    const FixedPoint fixed = {static_cast<double>(options.offset), scale, std::is_signed_v<T> ? -0x1p32 : 0.0,
                              std::is_signed_v<T> ? 0x1p32 : 0x1p32 - 1};
    SummedArea<T> table{width,       height,
                        channels,    options.offset,
                        1.0 / scale, std::vector<T, LargeAllocator<T>>(row_values * static_cast<size_t>(height)),
                        {}};
    const auto bytes = static_cast<std::int64_t>(table.sums.size() * sizeof(T));
    table.metered = MeteredBytes(options.meter, bytes);
    const MeteredBytes ping_pong(options.meter, bytes);

    parallel_for(static_cast<size_t>(height), rows_of_task, [&](size_t begin, size_t end) {
        std::vector<float> values, other(row_values);
        for (size_t y = begin; y < end; ++y) {
            detail::load_row(source, static_cast<int>(y), options.layer, 0, values);
            sum_row(values, other, fixed, channels, table.sums.data() + y * row_values);
        }
    });
    parallel_for(row_values, stripe_values, [&](size_t begin, size_t end) {
        sum_up(table.sums.data() + begin, row_values, static_cast<size_t>(height), end - begin);
    });
    const std::int64_t texel_bytes = channels * static_cast<std::int64_t>(sizeof(T));
    count_doubling(pass.counters(), width, height, texel_bytes);
    count_doubling(pass.counters(), height, width, texel_bytes);
    return table;
}

template <class T> glm::vec<4, T> box_sum(const SummedArea<T>& table, ivec2 first, ivec2 last, PassCounters& counters) {
    assert(first.x >= 0 && first.y >= 0 && first.x <= last.x && first.y <= last.y);
    assert(last.x < table.width && last.y < table.height);
    glm::vec<4, T> sum(T(0));
    for (int c = 0; c < table.channels; ++c)
        sum[c] = table.sum(last.x, last.y, c) - table.sum(first.x - 1, last.y, c) - table.sum(last.x, first.y - 1, c) +
                 table.sum(first.x - 1, first.y - 1, c);
    const int columns = first.x > 0 ? 2 : 1, rows = first.y > 0 ? 2 : 1;
    count_fetches(counters, columns * rows, sizeof(T) * static_cast<size_t>(table.channels));
    return sum;
}

template <class T> dvec4 box_mean(const SummedArea<T>& table, dvec2 low, dvec2 high, PassCounters& counters) {
    const Extent x = extent_of(low.x, high.x, table.width), y = extent_of(low.y, high.y, table.height);
    dvec4 mean(0.0);
    for (int c = 0; c < table.channels; ++c) {
        const auto corner = [&](int i, int j) { return table.sum(x.corners[i] - 1, y.corners[j] - 1, c); };
        if constexpr (std::is_same_v<T, float>) {
            float sums[4][4];
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i) sums[j][i] = corner(i, j);
            const float area = static_cast<float>(x.length) * static_cast<float>(y.length);
            mean[c] = static_cast<double>(integral(sums, x, y) / area + table.offset);
        } else {
            // A second difference does not change when functions of x alone and of y alone are subtracted: these are
            // sums over boxes from the lower corner, small, and right even where the table has wrapped around.
            double sums[4][4];
            for (int j = 0; j < 4; ++j)
                for (int i = 0; i < 4; ++i)
                    sums[j][i] = static_cast<double>((corner(i, j) - corner(0, j)) - (corner(i, 0) - corner(0, 0)));
            mean[c] = integral(sums, x, y) * table.unit / (x.length * y.length) + static_cast<double>(table.offset);
        }
    }
    std::int64_t columns = 0, rows = 0; // corners at zero are no texels
    for (int k = 0; k < 4; ++k) {
        columns += x.corners[k] > 0;
        rows += y.corners[k] > 0;
    }
    count_fetches(counters, columns * rows, sizeof(T) * static_cast<size_t>(table.channels));
    return mean;
}

#define GNOMON_SUMMED_AREA(T)                                                                                          \
    template SummedArea<T> summed_area(Pass&, const Target&, const SummedAreaOptions&);                                \
    template glm::vec<4, T> box_sum(const SummedArea<T>&, ivec2, ivec2, PassCounters&);                                \
    template dvec4 box_mean(const SummedArea<T>&, dvec2, dvec2, PassCounters&);
GNOMON_SUMMED_AREA(std::int64_t)
GNOMON_SUMMED_AREA(std::uint32_t)
GNOMON_SUMMED_AREA(double)
GNOMON_SUMMED_AREA(float)
#undef GNOMON_SUMMED_AREA

} // namespace gnomon
