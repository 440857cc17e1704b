#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Measure psnr_measure() {
    Metric metric;
    metric.id = "psnr";
    metric.title = "peak signal-to-noise ratio";
    metric.formula = "-10 log10(mse), of a peak of 1, in decibels";
    metric.range = "above 0 for values in [0, 1]; infinite (null in JSON) where equal";
    metric.source = "a logarithmic scale of mse";
    metric.blind_to = "all that mse is blind to; differences between good results look larger than they are";
    metric.lower_is_better = false;
    metric.pooling = Metric::Pooling::Decibel;
    return measure_of(
        metric, +[](const ImagePair& pair) {
            return 0.0 - 10.0 * std::log10(mean_square_error(pair)); // of 0: plus infinity
        });
}

} // namespace gnomon
