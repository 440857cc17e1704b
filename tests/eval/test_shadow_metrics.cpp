// Closed forms of the metrics on visibility: edges that are moved, bent, widened and quantised by known amounts.

#include <catch2/catch.hpp>

#include <cmath>
#include <functional>

#include "eval/metric/classes.h"
#include "eval/metrics.h"

using namespace gnomon;

namespace {

const Image<std::uint8_t> everywhere;

Image<float> drawn(int width, int height, const std::function<double(int x, int y)>& visibility) {
    Image<float> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) image(x, y) = static_cast<float>(visibility(x, y));
    return image;
}

// Umbra left of `at`, light from there on.
Image<float> edge(int at, int width = 256, int height = 128) {
    return drawn(width, height, [&](int x, int) { return x < at ? 0.0 : 1.0; });
}

// A linear penumbra of `columns` columns around x = 128.
Image<float> ramp(int columns) {
    return drawn(256, 128, [&](int x, int) { return std::clamp((x + 0.5 - 128.0) / columns + 0.5, 0.0, 1.0); });
}

double value_of(const char* id, const Image<float>& test, const Image<float>& reference,
                const Image<std::uint8_t>& mask = everywhere) {
    const Metric* metric = find_metric(id);
    REQUIRE(metric);
    return evaluate(*metric, {test, reference, mask});
}

Image<float> transposed(const Image<float>& image) {
    return drawn(image.height(), image.width(), [&](int x, int y) { return image(y, x); });
}

constexpr const char* distances[] = {"silhouette_mean", "silhouette_p95", "silhouette_max"};

} // namespace

TEST_CASE("a shifted edge has silhouette distance equal to the shift") {
    for (const int shift : {0, 1, 7, -13})
        for (const char* id : distances) {
            INFO(id << " " << shift);
            CHECK(value_of(id, edge(100 + shift), edge(100)) == std::abs(shift));
            CHECK(value_of(id, transposed(edge(100 + shift)), transposed(edge(100))) == std::abs(shift));
        }
}

TEST_CASE("a diagonal edge shifted across has the Euclidean distance") {
    const auto diagonal = [](int at) { return drawn(200, 200, [&](int x, int y) { return x + y < at ? 0.0 : 1.0; }); };
    // At the borders of the image the nearest point is cut off, so the mean is a little larger.
    CHECK(value_of("silhouette_p95", diagonal(206), diagonal(200)) == Approx(3.0 * std::sqrt(2.0)).epsilon(1e-12));
    CHECK(value_of("silhouette_mean", diagonal(206), diagonal(200)) == Approx(3.0 * std::sqrt(2.0)).epsilon(0.02));
}

TEST_CASE("a bump decides the Hausdorff distance and not the others") {
    // A spike of one row, nine pixels deep, on an edge of 128 rows.
    const Image<float> spike = drawn(256, 128, [](int x, int y) { return x < (y == 60 ? 109 : 100) ? 0.0 : 1.0; });
    CHECK(value_of("silhouette_max", spike, edge(100)) == 9.0);
    // The spike has 9 boundary pixels at distances 1 to 9; row 60 of the edge lost its own (the shadow goes on there)
    // and is a pixel from rows 59 and 61.
    const double sum = 1 + 2 + 3 + 4 + 5 + 6 + 7 + 8 + 9 + 1, pixels = 127 + 9 + 128;
    CHECK(value_of("silhouette_mean", spike, edge(100)) == Approx(sum / pixels).epsilon(1e-12));
    CHECK(value_of("silhouette_p95", spike, edge(100)) == 0.0);
}

TEST_CASE("silhouettes that lack in one image are infinitely far, in both they do not apply") {
    const Image<float> lit(64, 64, 1.0f), dark(64, 64, 0.0f);
    for (const char* id : distances) {
        CHECK(value_of(id, lit, edge(30, 64, 64)) == static_cast<double>(infinity));
        CHECK(value_of(id, edge(30, 64, 64), dark) == static_cast<double>(infinity));
        CHECK(std::isnan(value_of(id, lit, dark)));
    }
    CHECK(std::isnan(value_of("jaggedness", edge(30, 64, 64), lit)));
    CHECK(std::isnan(value_of("penumbra_width_error", lit, edge(30, 64, 64))));
}

TEST_CASE("the border of a mask is no silhouette") {
    const Image<float> dark(64, 64, 0.0f);
    Image<float> test = dark;
    Image<std::uint8_t> mask(64, 64, 1);
    for (int y = 0; y < 64; ++y)
        for (int x = 40; x < 64; ++x) test(x, y) = 1.0f, mask(x, y) = 0;
    CHECK(std::isnan(value_of("silhouette_max", test, dark, mask)));
    CHECK(value_of("silhouette_max", test, dark) == static_cast<double>(infinity));
}

TEST_CASE("penumbra-width error is the difference of the widths") {
    for (const int width : {10, 16, 40}) {
        INFO(width);
        CHECK(value_of("penumbra_width_error", ramp(width), ramp(16)) == std::abs(width - 16));
        CHECK(value_of("penumbra_width_error", transposed(ramp(width)), transposed(ramp(16))) == std::abs(width - 16));
    }
    CHECK(value_of("penumbra_width_error", edge(128), ramp(16)) == 16.0); // a hard edge has width 0
    // Where the edge lies does not matter.
    const Image<float> moved =
        drawn(256, 128, [](int x, int) { return std::clamp((x + 0.5 - 150.0) / 12.0 + 0.5, 0.0, 1.0); });
    CHECK(value_of("penumbra_width_error", moved, ramp(16)) == 4.0);
}

TEST_CASE("a penumbra without umbra has no width, whatever umbra lies beyond the light") {
    // A dip to 0.3, then light, then a shadow of its own whose boundary both images share.
    const auto scene = [](int dip) {
        return drawn(256, 128, [&](int x, int) {
            if (x >= 200) return 0.0;
            return std::clamp(0.3 + std::abs(x + 0.5 - 60.0) / dip, 0.0, 1.0);
        });
    };
    CHECK(value_of("penumbra_width_error", scene(40), scene(20)) == 0.0); // of the hard edge at 200 alone
}

TEST_CASE("jaggedness is nothing for edges that are moved or blurred evenly") {
    CHECK(value_of("jaggedness", edge(100), edge(100)) == 0.0);
    CHECK(value_of("jaggedness", edge(105), edge(100)) == 0.0);
    CHECK(value_of("jaggedness", ramp(12), edge(128)) == Approx(0.0).margin(1e-7));
    CHECK(value_of("jaggedness", ramp(12), ramp(16)) == Approx(0.0).margin(1e-7));
}

TEST_CASE("jaggedness of a battlement is half its height, of a saw h pi over 8") {
    for (const int height : {1, 4, 12}) {
        INFO(height);
        const Image<float> battlement =
            drawn(256, 128, [&](int x, int y) { return x < 100 + (y / 8 % 2) * height ? 0.0 : 1.0; });
        CHECK(value_of("jaggedness", battlement, edge(100)) == Approx(height / 2.0).epsilon(1e-12));
        CHECK(value_of("jaggedness", transposed(battlement), transposed(edge(100))) ==
              Approx(height / 2.0).epsilon(1e-12));
    }
    const Image<float> saw = drawn(256, 128, [](int x, int y) { return x < 100 + y % 16 ? 0.0 : 1.0; });
    double sum = 0.0; // the share of the rows whose tooth covers a column
    for (int column = 0; column < 16; ++column) sum += std::sqrt((15 - column) / 16.0 * (1.0 - (15 - column) / 16.0));
    CHECK(value_of("jaggedness", saw, edge(100)) == Approx(sum).epsilon(1e-12));
    CHECK(sum == Approx(2.0 * double{pi}).epsilon(0.02));
}

TEST_CASE("the confusion of classes is counted by reference and test") {
    Image<float> reference(10, 10, 1.0f), test(10, 10, 1.0f);
    for (int x = 0; x < 10; ++x) {
        reference(x, 0) = 0.0f, reference(x, 1) = 0.5f; // ten each of umbra and penumbra, eighty lit
        test(x, 0) = x < 2 ? 1.0f : x < 5 ? 0.3f : 0.005f;
        test(x, 1) = x < 4 ? 0.0f : 0.9f;
        test(x, 2) = x < 3 ? 0.9949f : 0.995f;
    }
    const ConfusionTable table = count_classes({test, reference, everywhere});
    CHECK((table == ConfusionTable{{{5, 3, 2}, {4, 6, 0}, {0, 3, 77}}}));
    CHECK(value_of("class_error", test, reference) == Approx(12.0 / 100.0));
    CHECK(value_of("class_iou", test, reference) == Approx((5.0 / 14.0 + 6.0 / 16.0 + 77.0 / 82.0) / 3.0));
    CHECK(value_of("class_iou", edge(100), edge(100)) == 1.0); // a class that nobody has does not count
}

TEST_CASE("banding is the number of levels, and the steps that the truth does not have") {
    const Image<float> smooth = ramp(64);
    CHECK(value_of("banding_levels", smooth, smooth) == 64.0);
    CHECK(value_of("banding_step", smooth, smooth) == 0.0);
    const Image<float> bands = drawn(256, 128, [&](int x, int) { return std::floor(smooth(x, 0) * 4.0) / 4.0; });
    CHECK(value_of("banding_levels", bands, smooth) == 4.0); // 0, 1/4, 1/2, 3/4
    CHECK(value_of("banding_step", bands, smooth) == Approx(0.25 - 1.0 / 64.0));
    CHECK(std::isnan(value_of("banding_levels", bands, edge(128))));
}

TEST_CASE("relative error weighs the dark, and sees codes as light") {
    const Image<float> reference(20, 20, 0.2f), test(20, 20, 0.3f);
    CHECK(value_of("relmse", test, reference) == Approx(0.01 / (0.04 + 0.01)));
    const double t = std::pow((0.3 + 0.055) / 1.055, 2.4), r = std::pow((0.2 + 0.055) / 1.055, 2.4);
    CHECK(evaluate(*find_metric("relmse"), {test, reference, everywhere, true}) ==
          Approx((t - r) * (t - r) / (r * r + 0.01)).epsilon(1e-5));
}
