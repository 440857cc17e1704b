#pragma once
// Numbers that say how far a test image is from a reference. Each metric is one row of `metrics()`: name, formula,
// range, source and what it is blind to. Pixels outside the mask, and pixels where either image is not finite, are left
// out; the latter are counted.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/image.h"

namespace gnomon {

// A pair of single-channel images of equal size with a mask (empty: all pixels; else 1 in, 0 out).
struct ImagePair {
    const Image<float>& test;
    const Image<float>& reference;
    const Image<std::uint8_t>& mask;
};

struct Metric {
    std::string id;    // "rmse": the key in JSON and in --metrics
    std::string title; // "root mean square error"
    std::string formula, range, source, blind_to;
    bool lower_is_better = true;
    double (*evaluate)(const ImagePair& pair); // NaN where it does not apply (no pixels)
    // How the values of several channels make one, each weighted by its pixels: RMSE over R, G, B is the root of the
    // mean of their squares, not the mean of their roots.
    enum class Pooling { Mean, RootMeanSquare, Decibel, Largest } pooling = Pooling::Mean;
    bool visibility_only = false; // means nothing on colours
};

// All metrics, in the order they are listed: mae, mse, rmse, psnr, max, ssim, …
const std::vector<Metric>& metrics();
const Metric* find_metric(const std::string& id);

// One value of several channels', `weights[i]` pixels each; channels where the metric is NaN are left out.
double pool(const Metric& metric, std::span<const double> values, std::span<const double> weights);

// Pixels inside the mask where one of the images is not finite.
std::int64_t count_missing(const ImagePair& pair);
std::int64_t count_masked(const ImagePair& pair); // pixels that take part

} // namespace gnomon
