#include "core/image_file.h"
#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Measure relmse_measure() {
    Metric metric;
    metric.id = "relmse";
    metric.title = "relative mean square error";
    metric.formula = "mean (test - reference)^2 / (reference^2 + 0.01), of linear values: sRGB codes are linearised";
    metric.range = "0 (equal) upwards";
    metric.source = "Rousselle, Knaus, Zwicker, Adaptive Sampling and Reconstruction using Greedy Error Minimization, "
                    "ACM TOG 30(6), 2011";
    metric.blind_to = "sign and place; errors where the reference is far below 0.1 count less than relatively";
    return measure_of(
        metric, +[](const ImagePair& pair) {
            const auto relative = [](double t, double r) { return (t - r) * (t - r) / (r * r + 0.01); };
            const auto linear = [](double code) {
                return static_cast<double>(linear_from_srgb(static_cast<float>(code)));
            };
            if (!pair.srgb) return reduce_differences(pair, relative).mean();
            return reduce_differences(pair, [&](double t, double r) { return relative(linear(t), linear(r)); }).mean();
        });
}

} // namespace gnomon
