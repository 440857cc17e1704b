#include "eval/metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

const char* domain_name(Metric::Domain domain) {
    constexpr const char* names[] = {"any channel", "visibility", "colours and visibility", "scene-linear colours",
                                     "sequences"};
    return names[static_cast<size_t>(domain)];
}

Measure measure_of(Metric metric, double (*value)(const ImagePair&)) {
    return {{std::move(metric)}, [value](const ImagePair& pair) { return std::vector{value(pair)}; }, nullptr};
}

Measure measure_of(Metric metric, double (*value)(const ColorPair&)) {
    return {{std::move(metric)}, nullptr, [value](const ColorPair& pair) { return std::vector{value(pair)}; }};
}

const std::vector<Measure>& measures() {
    static const std::vector<Measure> table = {
        mae_measure(),     mse_measure(),          rmse_measure(), psnr_measure(),     max_measure(),
        relmse_measure(),  ssim_measure(),         flip_measure(), flip_hdr_measure(), classes_measure(),
        leak_measure(),    false_shadow_measure(), over_measure(), under_measure(),    edges_measure(),
        banding_measure(), temporal_measure(),
    };
    return table;
}

const std::vector<Metric>& metrics() {
    static const std::vector<Metric> table = [] {
        std::vector<Metric> rows;
        for (const Measure& measure : measures())
            rows.insert(rows.end(), measure.metrics.begin(), measure.metrics.end());
        return rows;
    }();
    return table;
}

const Metric* find_metric(const std::string& id) {
    const auto found = std::find_if(metrics().begin(), metrics().end(), [&](const Metric& m) { return m.id == id; });
    return found == metrics().end() ? nullptr : &*found;
}

double evaluate(const Metric& metric, const ImagePair& pair) {
    for (const Measure& measure : measures())
        for (size_t i = 0; i < measure.metrics.size(); ++i) {
            if (measure.metrics[i].id != metric.id) continue;
            if (measure.of_channel) return measure.of_channel(pair)[i];
            const ColorPair grey{{&pair.test, &pair.test, &pair.test},
                                 {&pair.reference, &pair.reference, &pair.reference},
                                 pair.mask,
                                 pair.srgb};
            if (measure.of_color) return measure.of_color(grey)[i];
        }
    return std::numeric_limits<double>::quiet_NaN();
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
