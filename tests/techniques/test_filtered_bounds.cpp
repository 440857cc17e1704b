// What moments say about a receiver, on distributions of depths that are fed to
// the reconstructions directly: closed forms, and properties over random ones.

#include <catch2/catch.hpp>

#include <cmath>
#include <vector>

#include "core/random.h"
#include "raster/format.h"
#include "techniques/moments/bounds.h"
#include "techniques/moments/quantization.h"

using namespace gnomon;

namespace {

struct Layer {
    double depth, share;
};
using Layers = std::vector<Layer>;

template <class Function> auto mean_of(const Layers& layers, const Function& f) {
    decltype(f(0.0)) sum(0.0);
    for (const Layer& layer : layers) sum += f(layer.depth) * layer.share;
    return sum;
}

dvec4 moments_of(const Layers& layers) {
    return mean_of(layers, [](double z) { return four_moments(z); });
}

double lit_share(const Layers& layers, double t) {
    return mean_of(layers, [&](double z) { return z >= t ? 1.0 : 0.0; });
}

double vsm(const Layers& layers, double t) {
    const dvec4 b = moments_of(layers);
    return chebyshev(b.x, b.y, t, 0.0);
}

double esm(const Layers& layers, double t, double c = 80.0) {
    const double mean = mean_of(layers, [&](double z) { return std::exp(c * z); });
    return exponential(std::log(mean) / c, t, c);
}

double warped_chebyshev(const Layers& layers, double t, double sign, double c) {
    const auto warp = [&](double z) { return sign * std::exp(sign * c * (2.0 * z - 1.0)); };
    const double mean = mean_of(layers, warp);
    const double square = mean_of(layers, [&](double z) { return warp(z) * warp(z); });
    return chebyshev(mean, square, warp(t), 0.0);
}

double evsm(const Layers& layers, double t) {
    return std::min(warped_chebyshev(layers, t, 1.0, 40.0), warped_chebyshev(layers, t, -1.0, 5.0));
}

double msm(const Layers& layers, double t, double bias = 3e-5) {
    return hamburger(biased(moments_of(layers), bias), t);
}

double gsm(const Layers& layers, double t) {
    const dvec4 b = moments_of(layers);
    return gaussian_tail(b.x, b.y, t, 0.0, 0.5);
}

double series(const FourierSeries& f, const Layers& layers, double t) {
    return f.value(t, [&](int k) {
        return mean_of(layers, [&](double z) { return FourierSeries::cos_sin(f.frequency(k) * z); });
    });
}

// Up to eight layers at depths in 0.02 to 0.98, no two of them closer than
// 0.02.
Layers random_layers(std::uint32_t i, std::uint32_t seed) {
    Layers layers;
    double sum = 0;
    const std::uint32_t count = 1 + hash(i, 0, seed) % 8;
    for (std::uint32_t k = 0; k < count; ++k) {
        const double slot = 0.02 + 0.96 * (k + 0.9 * static_cast<double>(to_unit(hash(i, 2 * k + 1, seed)))) / count;
        layers.push_back({slot, 0.05 + static_cast<double>(to_unit(hash(i, 2 * k + 2, seed)))});
        sum += layers.back().share;
    }
    for (Layer& layer : layers) layer.share /= sum;
    return layers;
}

} // namespace

TEST_CASE("filtered distributions give the table's answers to the digits given") {
    const double third = 1.0 / 3.0;
    const Layers a = {{0.25, 0.5}, {0.5, 0.5}}, c = {{0.25, 0.5}, {0.7, 0.5}}, e = {{0.3, 0.75}, {0.6, 0.25}};
    const Layers d = {{0.2, third}, {0.4, third}, {0.6, third}};
    struct Row {
        const char* name;
        Layers layers;
        double t, truth, vsm, esm, evsm, msm, gsm;
    };
    const std::vector<Row> rows = {
        {"A", a, 0.5, 0.5, 0.5, 0.5, 0.5, 0.50005, 0.15866},
        {"B", a, 0.75, 0.0, 0.1, 0.0, 0.0, 1.5e-4, 0.00135},
        {"C", c, 0.75, 0.0, 0.40099, 0.009158, 8.5e-5, 0.00194, 0.11081},
        {"D", d, 0.8, 0.0, 0.142857, 0.0, 0.0, 0.01764, 0.00715},
        {"E", e, 0.6, 0.25, 0.25, 0.25, 0.25, 0.25006, 0.04163},
        {"F", d, 0.6, third, 0.4, 0.33333, 0.33333, 0.33388, 0.11034},
    };
    for (const Row& row : rows) {
        INFO(row.name);
        CHECK(lit_share(row.layers, row.t) == Approx(row.truth));
        CHECK(vsm(row.layers, row.t) == Approx(row.vsm).margin(5e-6));
        CHECK(esm(row.layers, row.t) == Approx(row.esm).margin(5e-6));
        CHECK(evsm(row.layers, row.t) == Approx(row.evsm).margin(5e-6));
        CHECK(msm(row.layers, row.t) == Approx(row.msm).margin(5e-6));
        CHECK(gsm(row.layers, row.t) == Approx(row.gsm).margin(5e-6));
    }
}

TEST_CASE("a single layer is lit up to itself and dark behind by the closed forms") {
    for (const double z : {0.1, 0.35, 0.9}) {
        const Layers layer = {{z, 1.0}};
        for (const double t : {0.05, z}) {
            CHECK(vsm(layer, t) == 1.0);
            CHECK(gsm(layer, t) == 1.0);
            CHECK(msm(layer, t) == Approx(1.0).margin(1e-4));
            CHECK(esm(layer, t) == Approx(1.0));
            CHECK(evsm(layer, t) == Approx(1.0));
        }
        const double behind = z + 0.05;
        const dvec4 b = moments_of(layer);
        CHECK(vsm(layer, behind) == Approx(0.0).margin(1e-12));
        CHECK(gsm(layer, behind) == Approx(0.0).margin(1e-12));
        CHECK(msm(layer, behind, 0.0) == Approx(0.0).margin(1e-9));
        CHECK(hausdorff(b, behind) == Approx(0.0).margin(1e-9));
        CHECK(esm(layer, behind) == Approx(std::exp(-80.0 * 0.05)));
        // The least variance of the look-up is what is left: s²/(s² + 0.05²).
        CHECK(chebyshev(b.x, b.y, behind, 1e-4) == Approx(1e-4 / (1e-4 + 0.0025)));
    }
}

TEST_CASE("with the receiver on the far one of two layers, two and four "
          "moments are exact") {
    const std::uint32_t seed = 20181;
    CAPTURE(seed);
    double worst = 0;
    for (std::uint32_t i = 0; i < 2000; ++i) {
        const double near_depth = 0.05 + 0.5 * static_cast<double>(to_unit(hash(i, 0, seed)));
        const double far_depth = near_depth + 0.05 + 0.35 * static_cast<double>(to_unit(hash(i, 1, seed)));
        const double p = 0.02 + 0.96 * static_cast<double>(to_unit(hash(i, 2, seed)));
        const Layers layers = {{near_depth, p}, {far_depth, 1.0 - p}};
        for (const double lit : {vsm(layers, far_depth), evsm(layers, far_depth), msm(layers, far_depth, 1e-11)})
            worst = std::max(worst, std::abs(lit - (1.0 - p)));
        // And nothing is left behind both of them.
        worst = std::max(worst, msm(layers, far_depth + 0.05, 1e-11));
    }
    CHECK(worst < 1e-5);
}

TEST_CASE("the bounds are bounds, four moments bound tighter than two, and all "
          "fall with the receiver's depth") {
    const std::uint32_t seed = 5150;
    CAPTURE(seed);
    double below_truth = 0, above_chebyshev = 0, above_hamburger = 0, rising = 0, tighter = 0;
    const auto note = [](double& worst, double excess) { worst = std::max(worst, excess); };
    for (std::uint32_t i = 0; i < 3000; ++i) {
        const Layers layers = random_layers(i, seed);
        const dvec4 b = moments_of(layers);
        double last[5] = {1, 1, 1, 1, 1};
        for (int step = 0; step <= 24; ++step) {
            const double t = 0.0137 + 0.98 * step / 24.0;
            const double truth = lit_share(layers, t);
            const double bounds[5] = {chebyshev(b.x, b.y, t, 0.0), hamburger(b, t), hausdorff(b, t), esm(layers, t),
                                      evsm(layers, t)};
            for (int k = 0; k < 5; ++k) {
                note(below_truth, truth - bounds[k]);
                note(rising, bounds[k] - last[k]);
                last[k] = bounds[k];
            }
            // A single layer leaves the Hankel system singular, and its guard loosens the bound just behind it.
            if (layers.size() > 1) note(above_chebyshev, bounds[1] - bounds[0]);
            note(above_hamburger, bounds[2] - bounds[1]);
            note(tighter, bounds[1] - bounds[2]);
        }
    }
    CAPTURE(below_truth, above_chebyshev, above_hamburger, rising);
    CHECK(below_truth < 1e-6);
    CHECK(above_chebyshev < 1e-6);
    CHECK(above_hamburger < 1e-6);
    CHECK(rising < 1e-6);
    CHECK(tighter > 0.05); // Hausdorff's problem is another one
}

TEST_CASE("three points carry the moments, and their weights are shares") {
    const Layers layers = {{0.2, 0.3}, {0.4, 0.3}, {0.9, 0.4}};
    const dvec4 b = moments_of(layers);
    for (const double t : {0.3, 0.55, 0.7}) {
        const ThreePoints<double> points = three_points(b, t);
        const glm::dvec3 w = three_weights(b, points, t);
        const dvec4 rebuilt = four_moments(points.z1) * w.x + four_moments(points.z2) * w.y + four_moments(t) * w.z;
        CHECK(w.x + w.y + w.z == Approx(1.0));
        CHECK(glm::min(w.x, glm::min(w.y, w.z)) > 0.0);
        for (int c = 0; c < 4; ++c) CHECK(rebuilt[c] == Approx(b[c]));
    }
    // Hausdorff's points, where Hamburger's leave [0, 1]: all mass in front of t
    // that the moments demand, no more.
    const Layers ends = {{0.0, 0.25}, {0.6, 0.5}, {1.0, 0.25}};
    CHECK(hausdorff(moments_of(ends), 0.6) == Approx(0.75));
    CHECK(hausdorff(moments_of(ends), 0.0) == 1.0);
    CHECK(hausdorff(moments_of(ends), 1.1) == 0.0);
}

TEST_CASE("the quantisation transform inverts, keeps to the unit cube and "
          "commutes with a blur") {
    double worst = 0, outside = 0, mixed = 0;
    for (int i = 0; i <= 100; ++i) {
        const float z = static_cast<float>(i) / 100.0f, other = std::abs(0.7f - z);
        const vec4 b = four_moments(z), q = quantize_moments(b), r = quantize_moments(four_moments(other));
        for (int c = 0; c < 4; ++c) {
            worst = std::max(worst, static_cast<double>(std::abs(dequantize_moments(q)[c] - b[c])));
            outside = std::max(outside, static_cast<double>(std::max(-q[c], q[c] - 1.0f)));
            const float blurred = dequantize_moments(q * 0.25f + r * 0.75f)[c];
            mixed =
                std::max(mixed, static_cast<double>(std::abs(blurred - (b * 0.25f + four_moments(other) * 0.75f)[c])));
        }
    }
    CAPTURE(worst, outside, mixed);
    CHECK(worst < 1e-5);
    CHECK(outside < 1e-5);
    CHECK(mixed < 1e-5);
}

TEST_CASE("sixteen bits of four moments leak no more than the table says") {
    const double third = 1.0 / 3.0;
    struct Row {
        const char* name;
        Layers layers;
        double t, table;
    };
    const std::vector<Row> rows = {{"B", {{0.25, 0.5}, {0.5, 0.5}}, 0.75, 1.5e-4},
                                   {"C", {{0.25, 0.5}, {0.7, 0.5}}, 0.75, 0.00194},
                                   {"D", {{0.2, third}, {0.4, third}, {0.6, third}}, 0.8, 0.01764}};
    const auto rounded = [](vec4 v) {
        for (int c = 0; c < 4; ++c) v[c] = static_cast<float>(unorm_from_float(v[c], 16)) / 65535.0f;
        return v;
    };
    for (const Row& row : rows) {
        INFO(row.name);
        // Rounded when drawn, and after each of two blurs.
        vec4 blurred(0.0f);
        for (const Layer& layer : row.layers)
            blurred += rounded(quantize_moments(four_moments(static_cast<float>(layer.depth)))) *
                       static_cast<float>(layer.share);
        const vec4 b = biased(dequantize_moments(rounded(rounded(blurred))), 3e-5f);
        const float lit = hamburger(b, static_cast<float>(row.t));
        CAPTURE(lit, row.table);
        CHECK(static_cast<double>(lit) <= row.table * 1.005); // the table's last digit
    }
}

TEST_CASE("the Fourier series of the shadow test has its closed values, and "
          "rings as Gibbs says") {
    const Layers far = {{0.75, 1.0}};
    CHECK(series({4, 0.0f}, far, 0.5) == Approx(0.9459).margin(5e-5));
    CHECK(series({16, 0.0f}, far, 0.5) == Approx(0.9860).margin(5e-5));
    for (const int terms : {1, 4, 16}) CHECK(series({terms, 1.0f}, far, 0.75) == Approx(0.5));
    // The first peak, at 1/(2 terms), overshoots by 9 % of the step.
    CHECK(series({16, 0.0f}, far, 0.75 - 1.0 / 32.0) == Approx(1.0895).margin(5e-4));
    CHECK(series({16, 1.0f}, far, 0.75 - 1.0 / 32.0) < 1.0);
    // Linear in the distribution.
    const Layers two = {{0.25, 0.5}, {0.75, 0.5}};
    CHECK(series({16, 0.0f}, two, 0.5) ==
          Approx(0.5 * series({16, 0.0f}, far, 0.5) + 0.5 * series({16, 0.0f}, {{0.25, 1.0}}, 0.5)));
}

TEST_CASE("bleeding is cut from below, and what overflows is dark") {
    CHECK(reduce_bleeding(0.3, 0.3) == 0.0);
    CHECK(reduce_bleeding(1.0, 0.3) == 1.0);
    CHECK(reduce_bleeding(0.65, 0.3) == Approx(0.5));
    CHECK(saturate(std::numeric_limits<float>::quiet_NaN()) == 0.0f);
    CHECK(saturate(infinity) == 1.0f);
    CHECK(chebyshev(infinity, infinity, infinity, 0.0f) == 1.0f); // nothing is seen to lie in front
    CHECK(chebyshev(1.0f, infinity, 2.0f, 0.0f) == 0.0f);
}
