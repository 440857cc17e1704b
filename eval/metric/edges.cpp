#include "eval/metric/all.h"
#include "eval/metric/silhouette.h"

namespace gnomon {
namespace {

Metric silhouette_metric(const char* id, const char* title, const char* of_distances) {
    Metric metric;
    metric.id = id;
    metric.title = title;
    metric.formula = std::string(of_distances) +
                     " of the distances, in pixels, from each boundary pixel of either image to the nearest of the "
                     "other; a boundary pixel is darker than 0.5 and has one that is not beside, below or above it";
    metric.range = "0 (equal) upwards; infinite where only one image has a boundary, absent where none has";
    metric.source = "symmetric surface distance and Hausdorff distance, by exact Euclidean distance transforms";
    metric.blind_to = "everything but where visibility crosses 0.5: the width of penumbrae, which edge meets which";
    metric.domain = Metric::Domain::Visibility;
    return metric;
}

Metric width_metric() {
    Metric metric;
    metric.id = "penumbra_width_error";
    metric.title = "penumbra-width error";
    metric.formula = "mean over the boundary pixels of the reference of |width there - width at the nearest boundary "
                     "pixel of the test|, in pixels; width = distance to the nearest lit pixel + distance to the "
                     "nearest pixel of umbra - 1";
    metric.range =
        "0 (equal) upwards; absent where an image has no boundary or no penumbra that ends in light and umbra";
    metric.source = "Euclidean distance transforms of the classes lit and umbra";
    metric.blind_to = "the course of visibility inside the penumbra; penumbrae without umbra; where the boundary lies";
    metric.domain = Metric::Domain::Visibility;
    return metric;
}

Metric jaggedness_metric() {
    Metric metric;
    metric.id = "jaggedness";
    metric.title = "jaggedness";
    metric.formula = "sum over distances of -16 to 16 pixels from the reference's boundary of the standard deviation "
                     "of test - reference at that distance, in pixels; per tile of 64x64 pixels, weighted by the "
                     "boundary pixels in it. Stairs of height h have h pi/8";
    metric.range = "0 (an edge moved or blurred evenly, or equal) upwards; absent where the reference has no boundary";
    metric.source = "the deviation along a straight edge, integrated across it, of the specification of Macedo 2018, "
                    "made local";
    metric.blind_to = "an even shift or blur; stairs that are longer than a tile";
    metric.domain = Metric::Domain::Visibility;
    return metric;
}

} // namespace

Measure edges_measure() {
    Measure measure;
    measure.metrics = {silhouette_metric("silhouette_mean", "silhouette distance, mean", "mean"),
                       silhouette_metric("silhouette_p95", "silhouette distance, 95 %", "95th percentile"),
                       silhouette_metric("silhouette_max", "silhouette distance, largest (Hausdorff)", "largest"),
                       width_metric(), jaggedness_metric()};
    measure.metrics[2].pooling = Metric::Pooling::Largest;
    measure.of_channel = [](const ImagePair& pair) {
        const Silhouettes silhouettes = find_silhouettes(pair);
        const SilhouetteDistances distances = silhouette_distances(silhouettes);
        return std::vector{distances.mean, distances.percentile_95, distances.largest,
                           penumbra_width_error(pair, silhouettes), jaggedness(pair, silhouettes)};
    };
    return measure;
}

} // namespace gnomon
