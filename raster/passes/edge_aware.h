#pragma once
// Separable screen-space filters that stop at edges, with a width of their own at every pixel: what blurs a shadow in
// the image without carrying it from one surface to another. A guide image (depth, as a rule) tells surfaces apart.
// [Macedo 2018, 2.10.5, 2.14 and 2.25; cross-bilateral and separable: Eisemann & Durand 2004, Pham & van Vliet 2005]
//
// `guide` is the first channel of a target, `half_width` too, in pixels. A pixel whose guide is not finite is invalid
// (background): it keeps its value and is no tap of others. Taps outside the image are invalid too. Run along rows,
// then along columns on the result; the guide and the widths stay those of the pixel. Layer 0 of targets of one size.
//
// Cost: a fragment fetches its own value, guide and half width, and value and guide of every other tap inside the
// image.

#include "raster/target.h"

namespace gnomon {

enum class Axis { Rows, Columns };

// Replaced taps, not dropped ones: a tap that is invalid, or whose guide differs by `threshold` or more, counts as the
// pixel itself. I' = Σ over k = −H..H / (2H + 1), H = ⌊half_width⌋ (0 unless positive, at most the image's side), in
// float from the lowest k up. [Macedo 2018, 2.29b, meanPass] `from_edge` starts at −half_width instead, whole or not,
// and goes up to half_width in steps of 1, each tap the nearest pixel (halves away from 0). [the author's programs]
struct MeanFilter {
    Axis axis = Axis::Rows;
    float threshold = infinity; // in the guide's units
    bool from_edge = false;
};
void mean_filter(Pass& pass, const Target& source, const Target& guide, const Target& half_width, Target& destination,
                 const MeanFilter& filter);

// I' = Σ w·I / Σ w over `taps` nearest pixels at offsets half_width·k/K (halves away from 0), k = −K..K, K = (taps −
// 1)/2, where w is exp(−½·(k/K)²/sigma_space²) · exp(−½·(Δguide/sigma_range)²) and invalid taps have none. Float, from
// the lowest k up. A pixel without a positive half width keeps its value. [Macedo 2018, 2.29b, bilateral1D]
struct BilateralFilter {
    Axis axis = Axis::Rows;
    int taps = 31;            // odd, at least 3
    float sigma_space = 0.5f; // as a fraction of half_width: it is 2σ
    float sigma_range = 1.0f; // in the guide's units; infinity: no edges
};
void bilateral_filter(Pass& pass, const Target& source, const Target& guide, const Target& half_width,
                      Target& destination, const BilateralFilter& filter);

} // namespace gnomon
