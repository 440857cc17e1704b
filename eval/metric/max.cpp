#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Measure max_measure() {
    Metric metric;
    metric.id = "max";
    metric.title = "largest absolute error";
    metric.formula = "max |test - reference|";
    metric.range = "0 (equal) to 1";
    metric.source = "the maximum norm of the difference";
    metric.blind_to = "extent: one pixel decides, and a silhouette shifted by one pixel reaches 1";
    metric.pooling = Metric::Pooling::Largest;
    return measure_of(
        metric, +[](const ImagePair& pair) {
            const PixelSum sum = reduce_differences(pair, [](double t, double r) { return std::abs(t - r); });
            return sum.count > 0 ? sum.largest : std::numeric_limits<double>::quiet_NaN();
        });
}

} // namespace gnomon
