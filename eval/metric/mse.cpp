#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

double mean_square_error(const ImagePair& pair) {
    return reduce_differences(pair, [](double t, double r) { return (t - r) * (t - r); }).mean();
}

Measure mse_measure() {
    Metric metric;
    metric.id = "mse";
    metric.title = "mean square error";
    metric.formula = "mean (test - reference)^2";
    metric.range = "0 (equal) to 1";
    metric.source = "the second power mean of the differences, squared";
    metric.blind_to = "sign and place; unlike the mean absolute error, few strong differences outweigh many faint ones";
    return measure_of(
        metric, +[](const ImagePair& pair) { return mean_square_error(pair); });
}

} // namespace gnomon
