#include "eval/metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

const std::vector<Metric>& metrics() {
    static const std::vector<Metric> table = {
        mae_metric(),  mse_metric(),  rmse_metric(),         psnr_metric(), max_metric(),
        ssim_metric(), leak_metric(), false_shadow_metric(), over_metric(), under_metric(),
    };
    return table;
}

const Metric* find_metric(const std::string& id) {
    const auto found = std::find_if(metrics().begin(), metrics().end(), [&](const Metric& m) { return m.id == id; });
    return found == metrics().end() ? nullptr : &*found;
}

double pool(const Metric& metric, std::span<const double> values, std::span<const double> weights) {
    assert(values.size() == weights.size());
    double sum = 0.0, weight = 0.0, largest = 0.0;
    for (size_t i = 0; i < values.size(); ++i) {
        if (std::isnan(values[i]) || weights[i] <= 0.0) continue;
        double value = values[i];
        if (metric.pooling == Metric::Pooling::RootMeanSquare) value *= value;
        if (metric.pooling == Metric::Pooling::Decibel) value = std::pow(10.0, -value / 10.0);
        sum += weights[i] * value;
        weight += weights[i];
        largest = std::max(largest, value);
    }
    if (weight == 0.0) return std::numeric_limits<double>::quiet_NaN();
    switch (metric.pooling) {
    case Metric::Pooling::RootMeanSquare:
        return std::sqrt(sum / weight);
    case Metric::Pooling::Decibel:
        return 0.0 - 10.0 * std::log10(sum / weight);
    case Metric::Pooling::Largest:
        return largest;
    case Metric::Pooling::Mean:
        break;
    }
    return sum / weight;
}

std::int64_t count_missing(const ImagePair& pair) {
    return reduce_pixels(pair.test.size(),
                         [&](size_t pixel, PixelSum& sum) {
                             if (!pair.mask.empty() && pair.mask.values()[pixel] == 0) return;
                             if (!takes_part(pair, pixel)) sum.add(0.0);
                         })
        .count;
}

std::int64_t count_masked(const ImagePair& pair) {
    return reduce_differences(pair, [](double, double) { return 0.0; }).count;
}

} // namespace gnomon
