#include "raster/passes/filter.h"

#include <algorithm>

#include "raster/full_screen.h"
#include "raster/passes/rows.h"

namespace gnomon {
namespace {

// sum += weight · values, element by element.
void accumulate(float* sum, const float* values, float weight, size_t count) {
    for (size_t i = 0; i < count; ++i) sum[i] += weight * values[i];
}

enum class Direction { Rows, Columns };

void convolve(Pass& pass, const Target& source, Target& destination, std::span<const float> weights,
              Direction direction) {
    const int reach = static_cast<int>(weights.size()) / 2, height = source.height();
    const int channels = info(source.format()).channels;
    const auto row_floats = static_cast<size_t>(source.width() * channels);
    const auto taps = static_cast<std::int64_t>(weights.size()) * source.width();
    for (int layer = 0; layer < source.layers(); ++layer)
        detail::for_each_row(pass, height, [&](int y, PassCounters& counters) {
            std::vector<float> row, sum(row_floats, 0.0f);
            if (direction == Direction::Rows) detail::load_row(source, y, layer, reach, row);
            for (int k = 0; k < static_cast<int>(weights.size()); ++k) {
                if (direction == Direction::Columns)
                    detail::load_row(source, std::clamp(y + k - reach, 0, height - 1), layer, 0, row);
                const float* first = row.data() + (direction == Direction::Rows ? k * channels : 0);
                accumulate(sum.data(), first, weights[static_cast<size_t>(k)], row_floats);
            }
            detail::store_row(destination, y, layer, sum.data());
            detail::count_fragments(counters, source.width(), taps, info(source.format()).bytes,
                                    info(destination.format()).bytes);
        });
}

} // namespace

void convolve_rows(Pass& pass, const Target& source, Target& destination, std::span<const float> weights) {
    convolve(pass, source, destination, weights, Direction::Rows);
}

void convolve_columns(Pass& pass, const Target& source, Target& destination, std::span<const float> weights) {
    convolve(pass, source, destination, weights, Direction::Columns);
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

std::vector<float> box_weights(int n) {
    return std::vector<float>(static_cast<size_t>(n), 1.0f / static_cast<float>(n));
}

} // namespace gnomon
