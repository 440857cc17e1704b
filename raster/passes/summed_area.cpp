#include "raster/passes/summed_area.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <type_traits>

#include "raster/full_screen.h"
#include "raster/passes/rows.h"

namespace gnomon {
namespace {

constexpr size_t stripe_values = 256; // values across of one task along columns

template <class T> constexpr bool fixed_point = std::is_integral_v<T>;

// `scale` is 2^fraction_bits.
template <class T> T stored(float value, float offset, double scale) {
    if constexpr (!fixed_point<T>) {
        return static_cast<T>(value) - static_cast<T>(offset);
    } else {
        constexpr double lowest = std::is_signed_v<T> ? -0x1p32 : 0.0;
        constexpr double highest = std::is_signed_v<T> ? 0x1p32 : 0x1p32 - 1;
        const double scaled = (static_cast<double>(value) - static_cast<double>(offset)) * scale;
        return scaled == scaled ? static_cast<T>(std::nearbyint(std::clamp(scaled, lowest, highest))) : T(0);
    }
}

template <class T> void add(T* sum, const T* values, size_t count) {
    for (size_t i = 0; i < count; ++i) sum[i] += values[i];
}

// Running sums along a row, channel by channel.
template <class T> void sum_along(std::vector<T>& row, size_t channels) {
    for (size_t i = channels; i < row.size(); ++i) row[i] += row[i - channels];
}

// The same as a GPU's passes do it: each adds what the one before it left 2^k texels to the left.
void sum_along(std::vector<float>& row, size_t channels) {
    std::vector<float> previous;
    for (size_t step = channels; step < row.size(); step *= 2) {
        previous = row;
        add(row.data() + step, previous.data(), row.size() - step);
    }
}

// Sums along the columns of a stripe of `count` values, row by row.
template <class T> void sum_up(T* first, size_t row_values, size_t height, size_t count) {
    for (size_t y = 1; y < height; ++y) add(first + y * row_values, first + (y - 1) * row_values, count);
}

// From the top down, so that a row still finds what the previous pass left below it.
void sum_up(float* first, size_t row_values, size_t height, size_t count) {
    for (size_t step = 1; step < height; step *= 2)
        for (size_t y = height; y-- > step;) add(first + y * row_values, first + (y - step) * row_values, count);
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
    SummedArea<T> table{width,       height,
                        channels,    options.offset,
                        1.0 / scale, std::vector<T, LargeAllocator<T>>(row_values * static_cast<size_t>(height)),
                        {}};
    const auto bytes = static_cast<std::int64_t>(table.sums.size() * sizeof(T));
    table.metered = MeteredBytes(options.meter, bytes);
    const MeteredBytes ping_pong(options.meter, bytes);

    parallel_for(static_cast<size_t>(height), detail::full_screen_rows, [&](size_t begin, size_t end) {
        std::vector<float> values;
        std::vector<T> row(row_values);
        for (size_t y = begin; y < end; ++y) {
            detail::load_row(source, static_cast<int>(y), options.layer, 0, values);
            for (size_t i = 0; i < row_values; ++i) row[i] = stored<T>(values[i], options.offset, scale);
            sum_along(row, static_cast<size_t>(channels));
            std::copy(row.begin(), row.end(), table.sums.begin() + static_cast<std::ptrdiff_t>(y * row_values));
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
