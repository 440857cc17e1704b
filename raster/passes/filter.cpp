#include "raster/passes/filter.h"

#include <algorithm>
#include <cmath>

#include "raster/full_screen.h"
#include "raster/passes/rows.h"

namespace gnomon {
namespace {

// sum += weight · values, element by element.
void accumulate(float* sum, const float* values, float weight, size_t count) {
    for (size_t i = 0; i < count; ++i) sum[i] += weight * values[i];
}

void keep_larger(float* largest, const float* values, size_t count) {
    for (size_t i = 0; i < count; ++i) largest[i] = values[i] > largest[i] ? values[i] : largest[i];
}

enum class Direction { Rows, Columns };

// The taps of one row of the destination, each as a row of floats.
class Taps {
public:
    Taps(const Target& source, int layer, int y, int count, Direction direction)
        : source_(source), layer_(layer), y_(y), reach_(count / 2), direction_(direction) {
        if (direction == Direction::Rows) detail::load_row(source, y, layer, reach_, row_);
    }
    // Valid until the next call.
    const float* operator[](int k) {
        if (direction_ == Direction::Rows) return row_.data() + k * info(source_.format()).channels;
        detail::load_row(source_, std::clamp(y_ + k - reach_, 0, source_.height() - 1), layer_, 0, row_);
        return row_.data();
    }

private:
    const Target& source_;
    int layer_, y_, reach_;
    Direction direction_;
    std::vector<float> row_;
};

// combine(taps, result) for every row of every layer; result is the row's zeroed floats.
template <class Combine>
void filter_rows(Pass& pass, const Target& source, Target& destination, size_t count, Direction direction,
                 const Combine& combine) {
    const auto row_floats = static_cast<size_t>(source.width() * info(source.format()).channels);
    const auto taps = static_cast<std::int64_t>(count) * source.width();
    for (int layer = 0; layer < source.layers(); ++layer)
        detail::for_each_row(pass, source.height(), [&](int y, PassCounters& counters) {
            std::vector<float> result(row_floats, 0.0f);
            Taps taps_of_row(source, layer, y, static_cast<int>(count), direction);
            combine(taps_of_row, result);
            detail::store_row(destination, y, layer, result.data());
            detail::count_fragments(counters, source.width(), taps, info(source.format()).bytes,
                                    info(destination.format()).bytes);
        });
}

void convolve(Pass& pass, const Target& source, Target& destination, std::span<const float> weights,
              Direction direction) {
    const auto combine = [&](Taps& taps, std::vector<float>& sum) {
        for (size_t k = 0; k < weights.size(); ++k)
            accumulate(sum.data(), taps[static_cast<int>(k)], weights[k], sum.size());
    };
    filter_rows(pass, source, destination, weights.size(), direction, combine);
}

void convolve_log(Pass& pass, const Target& source, Target& destination, std::span<const float> weights, float c,
                  Direction direction) {
    const auto combine = [&](Taps& taps, std::vector<float>& result) {
        std::vector<float> largest(result.size(), -infinity);
        for (size_t k = 0; k < weights.size(); ++k)
            keep_larger(largest.data(), taps[static_cast<int>(k)], largest.size());
        for (size_t k = 0; k < weights.size(); ++k) {
            const float* values = taps[static_cast<int>(k)];
            for (size_t i = 0; i < result.size(); ++i) result[i] += weights[k] * std::exp(c * (values[i] - largest[i]));
        }
        for (size_t i = 0; i < result.size(); ++i) result[i] = largest[i] + std::log(result[i]) / c;
    };
    filter_rows(pass, source, destination, weights.size(), direction, combine);
}

} // namespace

void convolve_rows(Pass& pass, const Target& source, Target& destination, std::span<const float> weights) {
    convolve(pass, source, destination, weights, Direction::Rows);
}

void convolve_columns(Pass& pass, const Target& source, Target& destination, std::span<const float> weights) {
    convolve(pass, source, destination, weights, Direction::Columns);
}

void convolve_rows_log(Pass& pass, const Target& source, Target& destination, std::span<const float> weights, float c) {
    convolve_log(pass, source, destination, weights, c, Direction::Rows);
}

void convolve_columns_log(Pass& pass, const Target& source, Target& destination, std::span<const float> weights,
                          float c) {
    convolve_log(pass, source, destination, weights, c, Direction::Columns);
}

std::vector<float> binomial_weights(int n) {
    std::vector<float> weights;
    double weight = 1.0;
    for (int k = 1; k < n; ++k) weight *= 0.5; // 2^−(n−1), exact
    for (int k = 0; k < n; ++k) {
        weights.push_back(static_cast<float>(weight));
        weight = weight * (n - 1 - k) / (k + 1);
    }
    return weights;
}

std::vector<float> gaussian_weights(int n, double sigma) {
    std::vector<double> values;
    double sum = 0.0;
    for (int k = 0; k < n; ++k) {
        const double offset = (k - 0.5 * (n - 1)) / sigma;
        values.push_back(std::exp(-0.5 * offset * offset));
        sum += values.back();
    }
    std::vector<float> weights;
    for (const double value : values) weights.push_back(static_cast<float>(value / sum));
    return weights;
}

std::vector<float> box_weights(int n) {
    return std::vector<float>(static_cast<size_t>(n), 1.0f / static_cast<float>(n));
}

} // namespace gnomon
