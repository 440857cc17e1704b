#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Measure over_measure() {
    Metric metric;
    metric.id = "over";
    metric.title = "over-estimation";
    metric.formula = "mean max(test - reference, 0): how much too light";
    metric.range = "0 (nowhere too light) to 1";
    metric.source = "the positive part of the difference; over + under = mae, over - under = the bias";
    metric.blind_to = "place: it counts light leaking and a penumbra shifted inwards alike";
    return measure_of(
        metric, +[](const ImagePair& pair) {
            return reduce_differences(pair, [](double t, double r) { return std::max(t - r, 0.0); }).mean();
        });
}

} // namespace gnomon
