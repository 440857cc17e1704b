#include <catch2/catch.hpp>

#include <cmath>

#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/image_file.h"
#include "core/parallel.h"
#include "eval/compare.h"
#include "eval/metrics.h"
#include "tests/support.h"

using namespace gnomon;

namespace {

const Image<std::uint8_t> everywhere;

double value_of(const std::string& id, const Image<float>& test, const Image<float>& reference,
                const Image<std::uint8_t>& mask = everywhere) {
    const Metric* metric = find_metric(id);
    REQUIRE(metric);
    return evaluate(*metric, {test, reference, mask});
}

// A ramp with structure on many scales, and a disturbed copy of it.
Image<float> waves(int width, int height, float disturbance) {
    Image<float> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float u = static_cast<float>(x), v = static_cast<float>(y);
            image(x, y) = 0.5f + 0.3f * std::sin(0.13f * u + 0.07f * v) * std::cos(0.011f * u * v * 0.1f) +
                          disturbance * std::sin(1.7f * u + 2.3f * v);
        }
    return image;
}

} // namespace

TEST_CASE("every metric says what it is") {
    for (const Metric& metric : metrics()) {
        INFO(metric.id);
        CHECK_FALSE(metric.title.empty());
        CHECK_FALSE(metric.formula.empty());
        CHECK_FALSE(metric.range.empty());
        CHECK_FALSE(metric.source.empty());
        CHECK_FALSE(metric.blind_to.empty());
        CHECK(find_metric(metric.id) == &metric);
    }
    CHECK(find_metric("mea") == nullptr);
}

TEST_CASE("a constant difference has the metrics' closed forms") {
    const Image<float> reference(40, 30, 0.25f), test(40, 30, 0.75f);
    CHECK(value_of("mae", test, reference) == 0.5);
    CHECK(value_of("mse", test, reference) == 0.25);
    CHECK(value_of("rmse", test, reference) == 0.5);
    CHECK(value_of("psnr", test, reference) == Approx(10.0 * std::log10(4.0)));
    CHECK(value_of("max", test, reference) == 0.5);
    CHECK(value_of("over", test, reference) == 0.5);
    CHECK(value_of("under", test, reference) == 0.0);
    CHECK(value_of("under", reference, test) == 0.5);
    // Without variance only the luminance term remains.
    CHECK(value_of("ssim", test, reference) == Approx((2 * 0.75 * 0.25 + 1e-4) / (0.75 * 0.75 + 0.25 * 0.25 + 1e-4)));
}

TEST_CASE("equal images are at the good end of every metric") {
    const Image<float> image = waves(70, 50, 0.0f);
    for (const char* id : {"mae", "mse", "rmse", "max", "over", "under"}) CHECK(value_of(id, image, image) == 0.0);
    CHECK(value_of("ssim", image, image) == 1.0);
    CHECK(value_of("psnr", image, image) == static_cast<double>(infinity));
}

TEST_CASE("over and under are the two halves of the mean absolute error") {
    const Image<float> reference = waves(300, 200, 0.0f), test = waves(300, 200, 0.1f);
    CHECK(value_of("over", test, reference) + value_of("under", test, reference) ==
          Approx(value_of("mae", test, reference)).epsilon(1e-12));
    CHECK(value_of("rmse", test, reference) == Approx(std::sqrt(value_of("mse", test, reference))).epsilon(1e-12));
}

TEST_CASE("light leaks are shares of the umbra, false shadows of the lit pixels") {
    Image<float> reference(10, 10, 1.0f), test(10, 10, 1.0f);
    for (int x = 0; x < 10; ++x) {
        reference(x, 0) = reference(x, 1) = 0.0f; // twenty pixels of umbra
        reference(x, 2) = 0.5f;                   // ten of penumbra, which count in neither
        test(x, 0) = x < 5 ? 0.06f : 0.05f;       // five leaks; 0.05 is still dark
        test(x, 1) = test(x, 2) = 0.0f;
        test(x, 9) = x < 7 ? 0.94f : 0.95f; // seven false shadows; 0.95 is still lit
    }
    CHECK(value_of("leak", test, reference) == 5.0 / 20.0);
    CHECK(value_of("false_shadow", test, reference) == 7.0 / 70.0);
    const Image<float> lit(10, 10, 1.0f), dark(10, 10, 0.0f);
    CHECK(std::isnan(value_of("leak", test, lit)));
    CHECK(std::isnan(value_of("false_shadow", test, dark)));
}

TEST_CASE("pixels outside the mask and pixels that are not finite have no say") {
    const Image<float> reference = waves(64, 48, 0.0f), clean = waves(64, 48, 0.05f);
    Image<float> spoilt = clean;
    Image<std::uint8_t> mask(64, 48, 1);
    for (int y = 10; y < 30; ++y)
        for (int x = 20; x < 33; ++x) {
            mask(x, y) = 0;
            spoilt(x, y) = static_cast<float>(x * y);
        }
    for (const char* id : {"mae", "mse", "rmse", "psnr", "max", "ssim", "over", "under"}) {
        INFO(id);
        CHECK(value_of(id, spoilt, reference, mask) == value_of(id, clean, reference, mask));
    }
    // What is missing is left out exactly as if it were masked.
    Image<float> holes = clean;
    for (int y = 10; y < 30; ++y)
        for (int x = 20; x < 33; ++x) holes(x, y) = x % 2 ? std::nanf("") : infinity;
    for (const char* id : {"mae", "rmse", "ssim", "max"})
        CHECK(value_of(id, holes, reference) == value_of(id, clean, reference, mask));
    CHECK(count_missing({holes, reference, everywhere}) == 20 * 13);
    CHECK(count_missing({holes, reference, mask}) == 0);
    CHECK(count_masked({holes, reference, everywhere}) == 64 * 48 - 20 * 13);
    CHECK(count_masked({clean, reference, mask}) == 64 * 48 - 20 * 13);
}

TEST_CASE("a metric without pixels does not apply") {
    const Image<float> image(20, 20, 0.5f);
    const Image<std::uint8_t> nowhere(20, 20, 0);
    for (const Metric& metric : metrics()) {
        INFO(metric.id);
        CHECK(std::isnan(evaluate(metric, {image, image, nowhere})));
    }
    const Image<float> small(10, 40, 0.5f);
    CHECK(std::isnan(value_of("ssim", small, small)));
}

TEST_CASE("SSIM's separable sums are the two-dimensional window's") {
    // A window of its own, at one place, by the definition.
    const Image<float> reference = waves(11, 11, 0.0f), test = waves(11, 11, 0.2f);
    double weights = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    for (int j = 0; j < 11; ++j)
        for (int i = 0; i < 11; ++i) {
            const double w = std::exp(-((i - 5) * (i - 5) + (j - 5) * (j - 5)) / 4.5), t = test(i, j),
                         r = reference(i, j);
            weights += w, x += w * t, y += w * r, xx += w * t * t, yy += w * r * r, xy += w * t * r;
        }
    x /= weights, y /= weights;
    const double variances = xx / weights - x * x + yy / weights - y * y, covariance = xy / weights - x * y;
    const double expected =
        (2 * x * y + 1e-4) * (2 * covariance + 9e-4) / ((x * x + y * y + 1e-4) * (variances + 9e-4));
    CHECK(value_of("ssim", test, reference) == Approx(expected).epsilon(1e-10));
}

TEST_CASE("metrics have the same bits for any number of threads") {
    const Image<float> reference = waves(517, 389, 0.0f), test = waves(517, 389, 0.1f);
    for (const Metric& metric : metrics()) {
        INFO(metric.id);
        double one = 0.0;
        with_threads(1, [&] { one = evaluate(metric, {test, reference, everywhere}); });
        for (const int threads : {2, 7})
            with_threads(threads, [&] {
                const double value = evaluate(metric, {test, reference, everywhere});
                CHECK((value == one || (std::isnan(value) && std::isnan(one))));
            });
    }
}

TEST_CASE("channels are pooled by the rule of their metric") {
    const std::vector<double> weights = {1.0, 1.0, 2.0};
    const double nan = std::nan("");
    CHECK(pool(*find_metric("mae"), std::vector{1.0, 3.0, 4.0}, weights) == 3.0);
    CHECK(pool(*find_metric("mae"), std::vector{1.0, nan, 4.0}, weights) == 3.0);
    CHECK(pool(*find_metric("rmse"), std::vector{1.0, 1.0, 5.0}, weights) == Approx(std::sqrt(13.0)));
    CHECK(pool(*find_metric("max"), std::vector{1.0, 7.0, 5.0}, weights) == 7.0);
    CHECK(pool(*find_metric("psnr"), std::vector{10.0, 10.0, 10.0}, weights) == Approx(10.0));
    CHECK(std::isnan(pool(*find_metric("mae"), std::vector{nan, nan, nan}, weights)));
}

TEST_CASE("metrics agree with scikit-image and NumPy on photographs and shadows") {
    const std::string folder = gnomon_tests::shared_path("flip-reference");
    if (folder.empty()) return;
    const nlohmann::json values = nlohmann::json::parse(read_file(folder + "/reference_values.json"));
    for (const nlohmann::json& pair : values["ldr"]) {
        CompareOptions options;
        options.test_name = pair["test"], options.reference_name = pair["reference"];
        const Comparison comparison = compare(read_image(folder + "/" + options.test_name),
                                              read_image(folder + "/" + options.reference_name), options);
        INFO(options.test_name);
        const auto value = [&](const char* id) { return comparison_json(comparison)["metrics"][id]; };
        CHECK(std::abs(value("mse").get<double>() - pair["mse_srgb01"].get<double>()) < 1e-8);
        CHECK(std::abs(value("rmse").get<double>() - pair["rmse_srgb01"].get<double>()) < 1e-7);
        CHECK(std::abs(value("mae").get<double>() - pair["mae_srgb01"].get<double>()) < 1e-7);
        CHECK(std::abs(value("ssim").get<double>() - pair["ssim_wang2004_rgb_skimage"].get<double>()) < 1e-6);
        if (pair["psnr_srgb_db"].is_null())
            CHECK(value("psnr").is_null());
        else
            CHECK(value("psnr").get<double>() ==
                  Approx(pair["psnr_srgb_db"].get<double>()).epsilon(1e-6)); // codes / 255 in float
        CHECK_FALSE(comparison_json(comparison)["metrics"].contains("leak"));
    }
    for (const nlohmann::json& pair : values["hdr"]) {
        const Comparison comparison = compare(read_image(folder + "/" + pair["test"].get<std::string>()),
                                              read_image(folder + "/" + pair["reference"].get<std::string>()));
        const nlohmann::ordered_json found = comparison_json(comparison)["metrics"];
        for (const char* id : {"mse", "rmse", "mae"})
            CHECK(found[id].get<double>() == Approx(pair[id].get<double>()).epsilon(1e-6));
    }
}

TEST_CASE("the documentation says of every metric what the table says") {
    const std::string page = read_file(std::string(GNOMON_SOURCE) + "/docs/metrics.md");
    for (const Metric& metric : metrics()) {
        INFO(metric.id);
        CHECK(page.find("### `" + metric.id + "`: " + metric.title + "\n\n" + metric.formula + ".\n") !=
              std::string::npos);
        CHECK(page.find("* range: " + metric.range + "\n* blind to: " + metric.blind_to +
                        "\n* source: " + metric.source) != std::string::npos);
    }
}
