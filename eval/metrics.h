#pragma once
// Numbers that say how far a test image is from a reference. Each metric is one row of `metrics()`: name, formula,
// range, source and what it is blind to. Pixels outside the mask, and pixels where either image is not finite, are left
// out; the latter are counted. docs/metrics.md explains them at length.

#include <array>
#include <cstdint>
#include <functional>
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
    bool srgb = false; // the values are sRGB codes in [0, 1], else linear
};

// The same for a colour; a grey picture is the same channel three times.
struct ColorPair {
    std::array<const Image<float>*, 3> test, reference; // R, G, B
    const Image<std::uint8_t>& mask;
    bool srgb = false;
};

struct Metric {
    std::string id;    // "rmse": the key in JSON and in --metrics
    std::string title; // "root mean square error"
    std::string formula, range, source, blind_to;
    bool lower_is_better = true;
    // How the values of several channels make one, each weighted by its pixels: RMSE over R, G, B is the root of the
    // mean of their squares, not the mean of their roots.
    enum class Pooling { Mean, RootMeanSquare, Decibel, Largest } pooling = Pooling::Mean;
    enum class Domain {
        Any,         // every channel by itself
        Visibility,  // means nothing on colours
        Picture,     // colours and visibility as a viewer sees them, three channels at once
        SceneLinear, // the same for colours that are not display-referred
        Sequence,    // frames of a sequence, see eval/sequence.h
    } domain = Domain::Any;
};

// The word for it in lists: "any channel", "visibility", …
const char* domain_name(Metric::Domain domain);

// Metrics that one computation yields. All have the same domain, and one of the functions is set, or none for a
// Sequence. Values are in the order of `metrics`, NaN where one does not apply (no pixels).
struct Measure {
    std::vector<Metric> metrics;
    std::function<std::vector<double>(const ImagePair&)> of_channel;
    std::function<std::vector<double>(const ColorPair&)> of_color;
};
Measure measure_of(Metric metric, double (*evaluate)(const ImagePair&));
Measure measure_of(Metric metric, double (*evaluate)(const ColorPair&));

// All of them, in the order in which they are listed.
const std::vector<Measure>& measures();
const std::vector<Metric>& metrics(); // of all measures: mae, mse, rmse, psnr, max, …
const Metric* find_metric(const std::string& id);

// One metric of one channel; a picture's, of the channel as grey. NaN where it does not apply.
double evaluate(const Metric& metric, const ImagePair& pair);

// One value of several channels', `weights[i]` pixels each; channels where the metric is NaN are left out.
double pool(const Metric& metric, std::span<const double> values, std::span<const double> weights);

// Pixels inside the mask where one of the images is not finite.
std::int64_t count_missing(const ImagePair& pair);
std::int64_t count_masked(const ImagePair& pair); // pixels that take part

} // namespace gnomon
