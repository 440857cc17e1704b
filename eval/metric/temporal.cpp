#include "eval/metric/all.h"

namespace gnomon {

Measure temporal_measure() {
    Metric mean;
    mean.id = "temporal_mean";
    mean.title = "temporal instability, mean";
    mean.formula = "mean |(test - reference) now - (test - reference) one frame before|, at the same receiver: that of "
                   "the layers P and worldToNDC where both frames have them, else the same pixel";
    mean.range = "0 (the error stays) to 2; absent but for sequences, and without receivers that two frames share";
    mean.source = "the change of the error along a path of the camera or the light";
    mean.blind_to = "errors that stay; receivers that one of two frames does not show; the pace of the path";
    mean.domain = Metric::Domain::Sequence;
    Metric rms = mean;
    rms.id = "temporal_rms";
    rms.title = "temporal instability, root mean square";
    rms.formula = "root of the mean square of the changes that temporal_mean averages";
    rms.blind_to = "as temporal_mean; few strong changes, as of popping, outweigh many faint ones";
    rms.pooling = Metric::Pooling::RootMeanSquare;
    return {{mean, rms}, nullptr, nullptr};
}

} // namespace gnomon
