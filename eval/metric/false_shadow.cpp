#include "eval/metric/all.h"
#include "eval/metric/classes.h"
#include "eval/metric/reduce.h"

namespace gnomon {

Measure false_shadow_measure() {
    Metric metric;
    metric.id = "false_shadow";
    metric.title = "false shadow";
    metric.formula = "share of the lit pixels (reference >= 0.995) that are drawn darker: test < 0.95";
    metric.range = "0 (none) to 1 (all); absent where the reference has no lit pixels";
    metric.source = "the classes lit, penumbra and umbra of the reference visibility";
    metric.blind_to =
        "how dark a false shadow is beyond 0.05; it cannot tell self-shadowing from a penumbra drawn too wide";
    metric.domain = Metric::Domain::Visibility;
    return measure_of(
        metric, +[](const ImagePair& pair) {
            return reduce_pixels(pair.test.size(),
                                 [&](size_t pixel, PixelSum& sum) {
                                     if (takes_part(pair, pixel) && pair.reference.values()[pixel] >= lit_from)
                                         sum.add(pair.test.values()[pixel] < false_shadow_below ? 1.0 : 0.0);
                                 })
                .mean();
        });
}

} // namespace gnomon
