#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

double mean_square_error(const ImagePair& pair) {
    return reduce_differences(pair, [](double t, double r) { return (t - r) * (t - r); }).mean();
}

Metric mse_metric() {
    Metric metric;
    metric.id = "mse";
    metric.title = "mean square error";
    metric.formula = "mean (test - reference)^2";
    metric.range = "0 (equal) to 1";
    metric.source = "the second power mean of the differences, squared";
    metric.blind_to = "sign and place; unlike the mean absolute error, few strong differences outweigh many faint ones";
    metric.evaluate = [](const ImagePair& pair) { return mean_square_error(pair); };
    return metric;
}

} // namespace gnomon
