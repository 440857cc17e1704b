#include "eval/metric/all.h"
#include "eval/metric/classes.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Measure leak_measure() {
    Metric metric;
    metric.id = "leak";
    metric.title = "light leaking";
    metric.formula = "share of the umbra pixels (reference <= 0.005) that are drawn lighter: test > 0.05";
    metric.range = "0 (none) to 1 (all); absent where the reference has no umbra";
    metric.source = "the classes lit, penumbra and umbra of the reference visibility";
    metric.blind_to = "how light a leak is beyond 0.05; it cannot tell a leak from a penumbra drawn too wide";
    metric.domain = Metric::Domain::Visibility;
    return measure_of(
        metric, +[](const ImagePair& pair) {
            return reduce_pixels(pair.test.size(),
                                 [&](size_t pixel, PixelSum& sum) {
                                     if (takes_part(pair, pixel) && pair.reference.values()[pixel] <= umbra_up_to)
                                         sum.add(pair.test.values()[pixel] > leak_above ? 1.0 : 0.0);
                                 })
                .mean();
        });
}

} // namespace gnomon
