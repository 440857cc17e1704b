#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Metric rmse_metric() {
    Metric metric;
    metric.id = "rmse";
    metric.title = "root mean square error";
    metric.formula = "sqrt(mean (test - reference)^2)";
    metric.range = "0 (equal) to 1";
    metric.source = "the square root of mse; over several channels, of the mean of their mse";
    metric.blind_to = "sign and place; an unshadowed surroundings that fills the picture dilutes it";
    metric.pooling = Metric::Pooling::RootMeanSquare;
    metric.evaluate = [](const ImagePair& pair) { return std::sqrt(mean_square_error(pair)); };
    return metric;
}

} // namespace gnomon
