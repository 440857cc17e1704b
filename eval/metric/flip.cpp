#include "eval/flip.h"

#include "eval/metric/all.h"

namespace gnomon {

Measure flip_measure() {
    Metric metric;
    metric.id = "flip";
    metric.title = "FLIP";
    metric.formula =
        "mean of C^(1 - F): C the HyAB colour difference after filtering by the eye's contrast sensitivity, F the "
        "difference of edges and points; at 67.02 pixels per degree, of values clamped to [0, 1] (sRGB codes are "
        "linearised, visibility is linear grey)";
    metric.range = "0 (equal) to 1";
    metric.source = "Andersson et al., FLIP: A Difference Evaluator for Alternating Images, HPG 2020";
    metric.blind_to = "values beyond [0, 1]; sign and place; a picture seen from nearer shows more";
    metric.domain = Metric::Domain::Picture;
    return measure_of(
        metric, +[](const ColorPair& pair) { return mean_of_map(flip_map(pair)); });
}

Measure flip_hdr_measure() {
    Metric metric;
    metric.id = "flip_hdr";
    metric.title = "HDR-FLIP";
    metric.formula = "mean of the largest flip over exposures at most a stop apart, from the one that puts the "
                     "reference's brightest pixel on the tone curve's shoulder to the one that puts its median there "
                     "(ACES tone curve); a median below 2^-23 counts as that, and 40 exposures are the most";
    metric.range = "0 (equal) to 1; absent for display-referred images";
    metric.source = "Andersson, Nilsson, Shirley, Akenine-Moller, Visualizing Errors in Rendered High Dynamic Range "
                    "Images, Eurographics short papers 2021";
    metric.blind_to = "sign and place; differences that show only far above the brightest or below the median exposure";
    metric.domain = Metric::Domain::SceneLinear;
    return measure_of(
        metric, +[](const ColorPair& pair) { return mean_of_map(flip_hdr_map(pair)); });
}

} // namespace gnomon
