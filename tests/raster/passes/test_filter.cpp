#include "raster/passes/edge_aware.h"
#include "raster/passes/filter.h"
#include "tests/raster/passes/images.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

Target constant(int width, int height, float value) {
    Target target(Format::R32F, width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) target.store(x, y, 0, vec4(value));
    return target;
}

double worst_difference(const Target& a, const Target& b) {
    double worst = 0;
    for (int y = 0; y < a.height(); ++y)
        for (int x = 0; x < a.width(); ++x)
            for (int c = 0; c < 4; ++c)
                worst = std::max(worst, static_cast<double>(std::abs(a.load(x, y)[c] - b.load(x, y)[c])));
    return worst;
}

} // namespace

TEST_CASE("gaussian weights are symmetric, sum to one and have their variance") {
    const std::vector<float> weights = gaussian_weights(31, 2.5);
    double sum = 0, variance = 0;
    for (int k = 0; k < 31; ++k) {
        CHECK(weights[static_cast<size_t>(k)] == weights[static_cast<size_t>(30 - k)]);
        sum += static_cast<double>(weights[static_cast<size_t>(k)]);
        variance += static_cast<double>(weights[static_cast<size_t>(k)]) * (k - 15) * (k - 15);
    }
    CHECK(sum == Approx(1.0).epsilon(1e-7));
    CHECK(variance == Approx(6.25).epsilon(1e-5));
    CHECK(gaussian_weights(3, 1.0)[1] / gaussian_weights(3, 1.0)[0] == Approx(std::exp(0.5)));
    CHECK(gaussian_weights(1, 1.0) == std::vector<float>{1.0f});
    CHECK(gaussian_weights(2, 1.0) == std::vector<float>{0.5f, 0.5f});
}

TEST_CASE("filtering in log space is filtering of exponentials") {
    TestPass t;
    const float c = 80.0f;
    const std::vector<float> weights = binomial_weights(7);
    const Target depth = random_target(Format::RG32F, 21, 13, 6);
    Target rows(Format::RG32F, 21, 13), both(Format::RG32F, 21, 13);
    convolve_rows_log(t.pass, depth, rows, weights, c);
    convolve_columns_log(t.pass, rows, both, weights, c);
    CHECK(t.pass.counters().texels_fetched == 2 * 7 * 21 * 13);
    for (int y = 0; y < 13; ++y)
        for (int x = 0; x < 21; ++x) {
            double sum = 0;
            for (int j = -3; j <= 3; ++j)
                for (int i = -3; i <= 3; ++i)
                    sum +=
                        static_cast<double>(weights[static_cast<size_t>(i + 3)] * weights[static_cast<size_t>(j + 3)]) *
                        std::exp(80.0 *
                                 static_cast<double>(depth.load(std::clamp(x + i, 0, 20), std::clamp(y + j, 0, 12)).y));
            if (std::abs(static_cast<double>(both.load(x, y).y) - std::log(sum) / 80.0) > 1e-6) FAIL(x << " " << y);
        }
    // Far beyond what e^(c·x) could hold: equal values stay, and the largest wins otherwise.
    const Target far = constant(5, 5, 1000.0f);
    Target kept(Format::R32F, 5, 5);
    convolve_rows_log(t.pass, far, kept, box_weights(3), c);
    CHECK(kept.load(2, 2).x == Approx(1000.0f));
}

TEST_CASE("the mean filter keeps constants and equals the box on one surface") {
    TestPass t;
    const int width = 19, height = 14;
    const Target flat = constant(width, height, 5.0f), reach = constant(width, height, 2.7f);
    const Target image = random_target(Format::RGBA32F, width, height, 12);
    Target rows(Format::RGBA32F, width, height), both(Format::RGBA32F, width, height);
    mean_filter(t.pass, image, flat, reach, rows, {.axis = Axis::Rows, .threshold = 0.1f});
    mean_filter(t.pass, rows, flat, reach, both, {.axis = Axis::Columns, .threshold = 0.1f});
    for (int y = 2; y < height - 2; ++y)
        for (int x = 2; x < width - 2; ++x) {
            vec4 sum(0.0f);
            for (int j = -2; j <= 2; ++j)
                for (int i = -2; i <= 2; ++i) sum += image.load(x + i, y + j);
            CHECK(glm::length(both.load(x, y) - sum / 25.0f) < 1e-6f);
        }
    // From the edge of ±2.7 on: −2.7, −1.7, …, 2.3, which are the pixels from −3 to 2.
    mean_filter(t.pass, image, flat, reach, rows, {.axis = Axis::Rows, .from_edge = true});
    for (int x = 3; x < width - 2; ++x) {
        vec4 sum(0.0f);
        for (int i = -3; i <= 2; ++i) sum += image.load(x + i, 4);
        CHECK(glm::length(rows.load(x, 4) - sum / 6.0f) < 1e-6f);
    }
    Target same(Format::R32F, width, height);
    const Target third = constant(width, height, 0.375f);
    mean_filter(t.pass, third, flat, constant(width, height, 1e30f), same, {});
    CHECK(worst_difference(same, third) == 0);
}

TEST_CASE(
    "the mean filter replaces the taps of another surface, of the background and of the outside by the pixel itself") {
    TestPass t;
    const int width = 7;
    Target image(Format::R32F, width, 1), guide(Format::R32F, width, 1), result(Format::R32F, width, 1);
    const float values[] = {1, 2, 4, 8, 16, 32, 64}, guides[] = {0, 0, 0, 1, 1, infinity, 1};
    for (int x = 0; x < width; ++x) {
        image.store(x, 0, 0, vec4(values[x]));
        guide.store(x, 0, 0, vec4(guides[x]));
    }
    mean_filter(t.pass, image, guide, constant(width, 1, 1.0f), result, {.threshold = 1.0f});
    CHECK(result.load(0, 0).x == (1.0f + 1.0f + 2.0f) / 3.0f); // outside
    CHECK(result.load(1, 0).x == 7.0f / 3.0f);
    CHECK(result.load(2, 0).x == (2.0f + 4.0f + 4.0f) / 3.0f); // a difference equal to the threshold is an edge
    CHECK(result.load(4, 0).x == (8.0f + 16.0f + 16.0f) / 3.0f);
    CHECK(result.load(5, 0).x == 32.0f); // background keeps its value
    CHECK(result.load(6, 0).x == 64.0f);
    // Values and guides of 2 or 3 taps, 1 for the background; a half width each.
    CHECK(t.pass.counters().texels_fetched == 2 * (2 + 3 + 3 + 3 + 3 + 1 + 2) + 7);
    mean_filter(t.pass, image, guide, constant(width, 1, -3.0f), result, {});
    CHECK(worst_difference(result, image) == 0);
}

TEST_CASE("a bilateral filter without edges is a gaussian, and with them it stops") {
    TestPass t;
    const int width = 41;
    Target image(Format::R32F, width, 1), guide(Format::R32F, width, 1), result(Format::R32F, width, 1);
    image.store(20, 0, 0, vec4(1.0f));
    const Target flat = constant(width, 1, 3.0f), reach = constant(width, 1, 6.0f);
    bilateral_filter(t.pass, image, flat, reach, result, {.taps = 13, .sigma_space = 0.5f, .sigma_range = infinity});
    const std::vector<float> weights = gaussian_weights(13, 3.0);
    for (int k = -6; k <= 6; ++k)
        CHECK(result.load(20 + k, 0).x == Approx(weights[static_cast<size_t>(k + 6)]).epsilon(1e-5));
    CHECK(result.load(13, 0).x == 0.0f);

    // Two surfaces, lit and not: nothing crosses.
    for (int x = 0; x < width; ++x) {
        image.store(x, 0, 0, vec4(x < 20 ? 1.0f : 0.0f));
        guide.store(x, 0, 0, vec4(x < 20 ? 10.0f : 300.0f));
    }
    bilateral_filter(t.pass, image, guide, reach, result, {});
    CHECK(worst_difference(result, image) == 0);
    bilateral_filter(t.pass, image, flat, reach, result, {});
    CHECK(result.load(19, 0).x < 0.7f);
    CHECK(result.load(20, 0).x > 0.3f);
    CHECK(result.load(19, 0).x + result.load(20, 0).x == Approx(1.0f)); // symmetric about the step
    bilateral_filter(t.pass, image, flat, constant(width, 1, 0.0f), result, {});
    CHECK(worst_difference(result, image) == 0);
}

TEST_CASE(
    "a bilateral filter turned by the axis is the transposed image, with the same bits for any number of threads") {
    const Target image = random_target(Format::RG32F, 37, 37, 4), guide = random_target(Format::R32F, 37, 37, 5);
    const Target reach = constant(37, 37, 7.3f);
    const auto turned = [](const Target& source) {
        Target result(source.format(), source.height(), source.width());
        for (int y = 0; y < source.height(); ++y)
            for (int x = 0; x < source.width(); ++x) result.store(y, x, 0, source.load(x, y));
        return result;
    };
    const auto filtered = [&](const Target& source, const Target& edges, Axis axis) {
        TestPass t;
        Target result(source.format(), source.width(), source.height());
        bilateral_filter(t.pass, source, edges, reach, result, {.axis = axis, .sigma_range = 0.2f});
        return result;
    };
    CHECK(same_bits(filtered(image, guide, Axis::Rows), turned(filtered(turned(image), turned(guide), Axis::Columns))));
    check_threads([&] { return filtered(image, guide, Axis::Columns); },
                  [](const Target& a, const Target& b) { return same_bits(a, b); });
}
