#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Metric leak_metric() {
    Metric metric;
    metric.id = "leak";
    metric.title = "light leaking";
    metric.formula = "share of the umbra pixels (reference <= 0.005) that are drawn lighter: test > 0.05";
    metric.range = "0 (none) to 1 (all); absent where the reference has no umbra";
    metric.source = "the classes lit, penumbra and umbra of the reference visibility";
    metric.blind_to = "how light a leak is beyond 0.05; it cannot tell a leak from a penumbra drawn too wide";
    metric.visibility_only = true;
    metric.evaluate = [](const ImagePair& pair) {
        // A reference of 1024 rays counts as umbra with up to five of them unblocked.
        return reduce_pixels(pair.test.size(),
                             [&](size_t pixel, PixelSum& sum) {
                                 if (takes_part(pair, pixel) && pair.reference.values()[pixel] <= 0.005f)
                                     sum.add(pair.test.values()[pixel] > 0.05f ? 1.0 : 0.0);
                             })
            .mean();
    };
    return metric;
}

} // namespace gnomon
