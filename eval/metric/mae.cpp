#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Measure mae_measure() {
    Metric metric;
    metric.id = "mae";
    metric.title = "mean absolute error";
    metric.formula = "mean |test - reference|";
    metric.range = "0 (equal) to 1";
    metric.source = "the first power mean of the differences";
    metric.blind_to = "sign and place: a faint error everywhere and a strong one in few pixels can weigh the same";
    return measure_of(
        metric, +[](const ImagePair& pair) {
            return reduce_differences(pair, [](double t, double r) { return std::abs(t - r); }).mean();
        });
}

} // namespace gnomon
