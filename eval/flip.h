#pragma once
// ꟻLIP: the difference that a viewer sees when flipping between two pictures, per pixel, 0 (none) to 1.
// LDR: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, FLIP: A Difference Evaluator for Alternating
// Images, HPG 2020. HDR: Andersson, Nilsson, Shirley, Akenine-Möller, Visualizing Errors in Rendered High Dynamic Range
// Images, Eurographics short papers 2021.

#include "eval/metrics.h"

namespace gnomon {

// A display 0.7 m wide with 3840 pixels, seen from 0.7 m.
inline constexpr float default_pixels_per_degree = 67.0206433f;

// Values beyond [0, 1] are clamped; where `pair.srgb`, codes are linearised first. Pixels that do not take part are
// black in both pictures, and NaN in the map.
Image<float> flip_map(const ColorPair& pair, float pixels_per_degree = default_pixels_per_degree);

// Stops between which HDR-FLIP exposes the pictures: from the one that puts the brightest pixel of the reference
// on the shoulder of the tone curve to the one that puts its median there, at most a stop apart. A median of less than
// 2^-23, as where more than half of a picture is black, counts as that, which is what the authors' program does. From
// there to the brightest value of a half float are 39 stops; a range of more than 40 is covered by 40 exposures,
// evenly, so that the work has a bound.
inline constexpr int most_exposures = 40;
struct ExposureRange {
    float start = 0.0f, stop = 0.0f;
    int count = 2;
};
ExposureRange automatic_exposures(const ColorPair& pair);

// The largest difference per pixel over the exposures, each under the ACES tone curve. Values are scene-linear.
Image<float> flip_hdr_map(const ColorPair& pair, float pixels_per_degree = default_pixels_per_degree);

// Mean of a map over its pixels that are not NaN; NaN without any.
double mean_of_map(const Image<float>& map);

} // namespace gnomon
