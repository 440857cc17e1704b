#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Measure under_measure() {
    Metric metric;
    metric.id = "under";
    metric.title = "under-estimation";
    metric.formula = "mean max(reference - test, 0): how much too dark";
    metric.range = "0 (nowhere too dark) to 1";
    metric.source = "the negative part of the difference; over + under = mae, over - under = the bias";
    metric.blind_to = "place: it counts false self-shadowing and a penumbra shifted outwards alike";
    return measure_of(
        metric, +[](const ImagePair& pair) {
            return reduce_differences(pair, [](double t, double r) { return std::max(r - t, 0.0); }).mean();
        });
}

} // namespace gnomon
