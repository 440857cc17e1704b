// MS-SSIM against a second implementation, written from the paper [Wang, Simoncelli, Bovik 2003] as plainly as it can
// be: two-dimensional windows, all in double, no filter that is shared with the one under test.

#include <catch2/catch.hpp>

#include <cmath>

#include "core/image_file.h"
#include "eval/metrics.h"
#include "tests/support.h"

using namespace gnomon;

namespace {

struct Plane {
    int width = 0, height = 0;
    std::vector<double> values;

    double operator()(int x, int y) const { return values[static_cast<size_t>(y * width + x)]; }
};

Plane plane_of(const Image<float>& image) {
    Plane plane{image.width(), image.height(), {}};
    plane.values.assign(image.values().begin(), image.values().end());
    return plane;
}

// Low-pass filtered and downsampled by two.
Plane half(const Plane& plane) {
    Plane result{plane.width / 2, plane.height / 2, {}};
    for (int y = 0; y < result.height; ++y)
        for (int x = 0; x < result.width; ++x)
            result.values.push_back(0.25 * (plane(2 * x, 2 * y) + plane(2 * x + 1, 2 * y) + plane(2 * x, 2 * y + 1) +
                                            plane(2 * x + 1, 2 * y + 1)));
    return result;
}

// Means over all windows of the luminance times contrast-structure term, and of the latter alone.
std::pair<double, double> means(const Plane& a, const Plane& b) {
    constexpr double c1 = 1e-4, c2 = 9e-4;
    double weights[11][11], total = 0.0;
    for (int j = 0; j < 11; ++j)
        for (int i = 0; i < 11; ++i)
            total += weights[j][i] = std::exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / (2.0 * 1.5 * 1.5));
    double with_luminance = 0.0, without = 0.0;
    int windows = 0;
    for (int y = 0; y + 11 <= a.height; ++y)
        for (int x = 0; x + 11 <= a.width; ++x) {
            double mean_a = 0, mean_b = 0, variance_a = 0, variance_b = 0, covariance = 0;
            for (int j = 0; j < 11; ++j)
                for (int i = 0; i < 11; ++i) {
                    mean_a += weights[j][i] / total * a(x + i, y + j);
                    mean_b += weights[j][i] / total * b(x + i, y + j);
                }
            for (int j = 0; j < 11; ++j)
                for (int i = 0; i < 11; ++i) {
                    const double w = weights[j][i] / total, p = a(x + i, y + j) - mean_a, q = b(x + i, y + j) - mean_b;
                    variance_a += w * p * p, variance_b += w * q * q, covariance += w * p * q;
                }
            const double structure = (2 * covariance + c2) / (variance_a + variance_b + c2);
            without += structure;
            with_luminance += (2 * mean_a * mean_b + c1) / (mean_a * mean_a + mean_b * mean_b + c1) * structure;
            ++windows;
        }
    return {with_luminance / windows, without / windows};
}

double plain_ms_ssim(Plane a, Plane b) {
    constexpr double exponents[] = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333};
    double product = 1.0;
    for (int scale = 0; scale < 5; ++scale) {
        const auto [full, structure] = means(a, b);
        product *= std::pow(std::max(0.0, scale == 4 ? full : structure), exponents[scale]);
        a = half(a), b = half(b);
    }
    return product;
}

double ms_ssim(const Image<float>& a, const Image<float>& b, const Image<std::uint8_t>& mask = {}) {
    return evaluate(*find_metric("ms_ssim"), {a, b, mask});
}

Image<float> waves(int width, int height, float disturbance) {
    Image<float> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float u = static_cast<float>(x), v = static_cast<float>(y);
            image(x, y) = 0.5f + 0.3f * std::sin(0.13f * u + 0.07f * v) + disturbance * std::sin(1.7f * u + 2.3f * v);
        }
    return image;
}

} // namespace

TEST_CASE("MS-SSIM is what the paper's formula says, on even and odd sizes") {
    for (const ivec2 size : {ivec2(192, 176), ivec2(201, 183)}) {
        const Image<float> reference = waves(size.x, size.y, 0.0f);
        for (const float disturbance : {0.02f, 0.2f}) {
            const Image<float> test = waves(size.x, size.y, disturbance);
            CHECK(ms_ssim(test, reference) == Approx(plain_ms_ssim(plane_of(test), plane_of(reference))).margin(1e-7));
        }
        CHECK(ms_ssim(reference, reference) == 1.0);
    }
}

TEST_CASE("MS-SSIM is what the paper's formula says, on photographs and shadows") {
    const std::string folder = gnomon_tests::shared_path("flip-reference");
    if (folder.empty()) return;
    for (const auto& [name, tests] : {std::pair{"photo", std::vector{"blur", "noise", "shift", "dark"}},
                                      std::pair{"shadow", std::vector{"hard", "alias", "wide", "leak", "acne"}}}) {
        const Image<float> reference = read_image(folder + "/" + name + "_ref.png").find("G")->values;
        for (const char* kind : tests) {
            INFO(name << " " << kind);
            const Image<float> test = read_image(folder + "/" + name + "_" + kind + ".png").find("G")->values;
            CHECK(ms_ssim(test, reference) == Approx(plain_ms_ssim(plane_of(test), plane_of(reference))).margin(1e-7));
        }
    }
}

TEST_CASE("MS-SSIM needs five scales, and leaves out what is masked or missing") {
    const Image<float> small = waves(175, 400, 0.0f);
    CHECK(std::isnan(ms_ssim(small, small)));
    const Image<float> reference = waves(200, 180, 0.0f), clean = waves(200, 180, 0.1f);
    Image<float> spoilt = clean, holes = clean;
    Image<std::uint8_t> mask(200, 180, 1);
    for (int y = 33; y < 70; ++y)
        for (int x = 41; x < 90; ++x) mask(x, y) = 0, spoilt(x, y) = -3.0f, holes(x, y) = infinity;
    CHECK(ms_ssim(spoilt, reference, mask) == ms_ssim(clean, reference, mask));
    CHECK(ms_ssim(holes, reference) == ms_ssim(clean, reference, mask));
    CHECK(ms_ssim(clean, reference, mask) != ms_ssim(clean, reference));
}

TEST_CASE("MS-SSIM of structure turned upside down is nothing") {
    const Image<float> reference = waves(180, 180, 0.3f);
    Image<float> negative = reference;
    for (float& value : negative.values()) value = 1.0f - value;
    CHECK(ms_ssim(negative, reference) == 0.0);
}
