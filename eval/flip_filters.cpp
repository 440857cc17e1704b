#include "eval/flip_filters.h"

#include <algorithm>
#include <cmath>

#include "core/math.h"
#include "core/vector_clones.h"
#include "eval/vector_math.h"

namespace gnomon {
namespace {

// A sum of Gaussians a √(π / b) exp(−π² x² / b), x in degrees, is the eye's point spread for one opponent colour.
// [2020, table 1]
struct Sensitivity {
    double a, b;
};
constexpr Sensitivity lightness_sensitivity{1.0, 0.0047}, red_green_sensitivity{1.0, 0.0053};
constexpr std::array<Sensitivity, 2> blue_yellow_sensitivity = {{{34.1, 0.04}, {13.5, 0.025}}};
constexpr double widest = 0.04;         // the largest b
constexpr double feature_width = 0.082; // degrees, of what the eye sees as an edge [2020, 4.2]

// HyAB differences to FLIP's: a power, then two straight pieces that meet at `bend` of the largest. [2020, eq. 6]
constexpr float color_exponent = 0.7f, bend = 0.4f, bend_value = 0.95f;

struct Lab {
    float l, a, b;
};

FlipKernel gaussian(double falloff, int radius) {
    FlipKernel kernel;
    for (int x = -radius; x <= radius; ++x) kernel.push_back(static_cast<float>(std::exp(-falloff * x * x)));
    return kernel;
}

double sum_of(const FlipKernel& kernel) {
    double sum = 0.0;
    for (const float weight : kernel) sum += weight;
    return sum;
}

void scale(FlipKernel& kernel, double factor) {
    for (float& weight : kernel) weight = static_cast<float>(weight * factor);
}

FlipKernel sensitivity_kernel(double b, double pixels_per_degree, int radius) {
    FlipKernel kernel = gaussian(pi * pi / (b * pixels_per_degree * pixels_per_degree), radius);
    scale(kernel, 1.0 / sum_of(kernel));
    return kernel;
}

// Positive weights sum to 1, negative ones to −1.
void balance(FlipKernel& kernel) {
    double positive = 0.0, negative = 0.0;
    for (const float weight : kernel) (weight > 0.0f ? positive : negative) += std::abs(weight);
    for (float& weight : kernel) weight = static_cast<float>(weight / (weight > 0.0f ? positive : negative));
}

// out += the sum of weights[tap] · rows[tap], four rows at a time.
GNOMON_VECTOR_CLONES
void add_weighted(const float* const* rows, const float* weights, size_t taps, float* out, size_t count) {
    size_t tap = 0;
    for (; tap + 4 <= taps; tap += 4) {
        const float *a = rows[tap], *b = rows[tap + 1], *c = rows[tap + 2], *d = rows[tap + 3];
        const float of_a = weights[tap], of_b = weights[tap + 1], of_c = weights[tap + 2], of_d = weights[tap + 3];
        for (size_t x = 0; x < count; ++x) out[x] += of_a * a[x] + of_b * b[x] + of_c * c[x] + of_d * d[x];
    }
    for (; tap < taps; ++tap) {
        const float* row = rows[tap];
        const float weight = weights[tap];
        for (size_t x = 0; x < count; ++x) out[x] += weight * row[x];
    }
}

GNOMON_VECTOR_CLONES
void lengths(const float* x, float* y_to_length, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const float across = x[i] * (1.0f / 116.0f), along = y_to_length[i] * (1.0f / 116.0f);
        y_to_length[i] = std::sqrt(across * across + along * along);
    }
}

inline float lab_curve(float t) {
    constexpr float knee = 6.0f / 29.0f;
    const float linear = t * (1.0f / (3.0f * knee * knee)) + 4.0f / 29.0f;
    return t > knee * knee * knee ? vector_cbrt(t) : linear;
}

// CIELAB with Hunt's effect: the darker, the less colour. [2020, 4.1]
inline Lab hunt_lab(FlipXyz c) {
    const float x = lab_curve(c.x), y = lab_curve(c.y), z = lab_curve(c.z), l = 116.0f * y - 16.0f;
    return {l, 0.01f * l * 500.0f * (x - y), 0.01f * l * 200.0f * (y - z)};
}

// Of filtered opponent colours, clamped to what the display can show.
inline Lab shown_lab(float lightness, float red_green, float blue_yellow) {
    const float y = (lightness + 16.0f) * (1.0f / 116.0f);
    const float x = y + red_green * (1.0f / 500.0f), z = y - blue_yellow * (1.0f / 200.0f);
    const auto clamped = [](float value) { return std::min(std::max(value, 0.0f), 1.0f); };
    // The inverse of xyz_from_rgb.
    return hunt_lab(xyz_from_rgb(clamped(3.080341988f * x - 1.537398969f * y - 0.542943019f * z),
                                 clamped(-0.921178396f * x + 1.875929984f * y + 0.045248412f * z),
                                 clamped(0.052881293f * x - 0.204011206f * y + 1.151129913f * z)));
}

inline float hyab(Lab p, Lab q) {
    const float a = p.a - q.a, b = p.b - q.b;
    return std::abs(p.l - q.l) + std::sqrt(a * a + b * b);
}

GNOMON_VECTOR_CLONES
void color_differences(const float* const* test, const float* const* reference, float largest, float* out,
                       size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const Lab p = shown_lab(test[0][i], test[1][i], test[2][i]);
        const Lab q = shown_lab(reference[0][i], reference[1][i], reference[2][i]);
        const float difference = vector_pow(hyab(p, q), color_exponent), knee = bend * largest;
        const float below = difference * (bend_value / knee);
        const float above = bend_value + (difference - knee) / (largest - knee) * (1.0f - bend_value);
        out[i] = difference < knee ? below : above;
    }
}

GNOMON_VECTOR_CLONES
void apply_features(const float* test_edges, const float* reference_edges, const float* test_points,
                    const float* reference_points, float* in_out, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const float edges = std::abs(test_edges[i] - reference_edges[i]);
        const float points = std::abs(test_points[i] - reference_points[i]);
        const float feature = std::sqrt(std::max(edges, points) * 0.70710678f);
        in_out[i] = vector_pow(in_out[i], 1.0f - feature);
    }
}

} // namespace

FlipKernels flip_kernels(float pixels_per_degree) {
    FlipKernels kernels;
    const double ppd = pixels_per_degree;
    const int spatial = static_cast<int>(std::ceil(3.0 * std::sqrt(widest / (2.0 * pi * pi)) * ppd));
    kernels.lightness = sensitivity_kernel(lightness_sensitivity.b, ppd, spatial);
    kernels.red_green = sensitivity_kernel(red_green_sensitivity.b, ppd, spatial);
    std::array<double, 2> shares{};
    for (size_t i = 0; i < 2; ++i) {
        const auto [a, b] = blue_yellow_sensitivity[i];
        const double sum = sum_of(gaussian(pi * pi / (b * ppd * ppd), spatial));
        shares[i] = a * std::sqrt(pi / b) * sum * sum;
        kernels.blue_yellow[i] = kernels.blue_yellow_up[i] = sensitivity_kernel(b, ppd, spatial);
    }
    for (size_t i = 0; i < 2; ++i) scale(kernels.blue_yellow_up[i], shares[i] / (shares[0] + shares[1]));

    const double deviation = 0.5 * feature_width * ppd;
    const int detector = static_cast<int>(std::ceil(3.0 * deviation));
    kernels.gauss = gaussian(0.5 / (deviation * deviation), detector);
    kernels.edge = kernels.point = kernels.gauss;
    for (int x = -detector; x <= detector; ++x) {
        const auto i = static_cast<size_t>(x + detector);
        kernels.edge[i] *= static_cast<float>(-x);
        kernels.point[i] *= static_cast<float>(x * x / (deviation * deviation) - 1.0);
    }
    scale(kernels.gauss, 1.0 / sum_of(kernels.gauss));
    balance(kernels.edge);
    balance(kernels.point);
    kernels.radius = std::max(spatial, detector);
    return kernels;
}

FlipRows::FlipRows(const FlipKernels& kernels, const FlipArea& area)
    : kernels_(kernels), area_(area), ring_(static_cast<size_t>(2 * kernels.radius + 1)), window_(ring_.size()) {
    const auto count = static_cast<size_t>(area.columns);
    for (Row& row : ring_)
        for (std::vector<float>& values : row) values.resize(count);
    padded_.resize(count + 2 * static_cast<size_t>(kernels.radius));
    for (std::vector<float>& values : filtered_.colors) values.resize(count);
    for (std::vector<float>* values : {&across_, &filtered_.edges, &filtered_.points}) values->resize(count);
}

void FlipRows::filter_along(int y, Part part, const FlipKernel& kernel) {
    const size_t first = static_cast<size_t>(kernels_.radius) - kernel.size() / 2;
    for (size_t tap = 0; tap < kernel.size(); ++tap) window_[tap] = padded_.data() + first + tap;
    std::vector<float>& out = slot(y)[part];
    std::fill(out.begin(), out.end(), 0.0f);
    add_weighted(window_.data(), kernel.data(), kernel.size(), out.data(), out.size());
}

void FlipRows::load_row(int y, const Load& load) {
    const int radius = kernels_.radius, first = area_.first_column - radius;
    const int begin = std::max(first, 0), end = std::min(area_.first_column + area_.columns + radius, area_.width);
    load(y, begin, end, opponents_);
    for (size_t c = 0; c < 3; ++c) {
        const auto left = padded_.begin() + (begin - first), right = left + (end - begin);
        std::fill(padded_.begin(), left, opponents_[c].front());
        std::copy(opponents_[c].begin(), opponents_[c].end(), left);
        std::fill(right, padded_.end(), opponents_[c].back());
        if (c == 0) {
            filter_along(y, Lightness, kernels_.lightness);
            filter_along(y, Gauss, kernels_.gauss);
            filter_along(y, Edge, kernels_.edge);
            filter_along(y, Point, kernels_.point);
        }
        if (c == 1) filter_along(y, RedGreen, kernels_.red_green);
        if (c == 2) {
            filter_along(y, BlueYellow, kernels_.blue_yellow[0]);
            filter_along(y, BlueYellow2, kernels_.blue_yellow[1]);
        }
    }
}

void FlipRows::add_up(int y, Part part, const FlipKernel& kernel, std::vector<float>& out) {
    const int reach = static_cast<int>(kernel.size() / 2);
    for (int tap = -reach; tap <= reach; ++tap)
        window_[static_cast<size_t>(tap + reach)] = slot(std::clamp(y + tap, 0, area_.height - 1))[part].data();
    add_weighted(window_.data(), kernel.data(), kernel.size(), out.data(), out.size());
}

void FlipRows::filter_row(int y, const Load& load) {
    const int radius = kernels_.radius;
    next_ = std::max(next_, y - radius);
    for (; next_ <= std::min(y + radius, area_.height - 1); ++next_) load_row(next_, load);
    for (std::vector<float>& values : filtered_.colors) std::fill(values.begin(), values.end(), 0.0f);
    add_up(y, Lightness, kernels_.lightness, filtered_.colors[0]);
    add_up(y, RedGreen, kernels_.red_green, filtered_.colors[1]);
    add_up(y, BlueYellow, kernels_.blue_yellow_up[0], filtered_.colors[2]);
    add_up(y, BlueYellow2, kernels_.blue_yellow_up[1], filtered_.colors[2]);
    const auto strength = [&](Part derived, const FlipKernel& kernel, std::vector<float>& out) {
        std::fill(across_.begin(), across_.end(), 0.0f);
        std::fill(out.begin(), out.end(), 0.0f);
        add_up(y, derived, kernels_.gauss, across_);
        add_up(y, Gauss, kernel, out);
        lengths(across_.data(), out.data(), out.size());
    };
    strength(Edge, kernels_.edge, filtered_.edges);
    strength(Point, kernels_.point, filtered_.points);
}

void flip_differences(const FlipFiltered& test, const FlipFiltered& reference, float* out, size_t count) {
    // The largest difference that there is: green against blue.
    const float largest =
        vector_pow(hyab(hunt_lab(xyz_from_rgb(0, 1, 0)), hunt_lab(xyz_from_rgb(0, 0, 1))), color_exponent);
    const float *test_colors[3], *reference_colors[3];
    for (size_t c = 0; c < 3; ++c) {
        test_colors[c] = test.colors[c].data();
        reference_colors[c] = reference.colors[c].data();
    }
    color_differences(test_colors, reference_colors, largest, out, count);
    apply_features(test.edges.data(), reference.edges.data(), test.points.data(), reference.points.data(), out, count);
}

} // namespace gnomon
