#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Measure rmse_measure() {
    Metric metric;
    metric.id = "rmse";
    metric.title = "root mean square error";
    metric.formula = "sqrt(mean (test - reference)^2)";
    metric.range = "0 (equal) to 1";
    metric.source = "the square root of mse; over several channels, of the mean of their mse";
    metric.blind_to = "sign and place; an unshadowed surroundings that fills the picture dilutes it";
    metric.pooling = Metric::Pooling::RootMeanSquare;
    return measure_of(
        metric, +[](const ImagePair& pair) { return std::sqrt(mean_square_error(pair)); });
}

} // namespace gnomon
