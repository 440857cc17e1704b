#include <catch2/catch.hpp>

#include <cmath>

#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/image_file.h"
#include "eval/flip.h"
#include "eval/vector_math.h"
#include "tests/support.h"

using namespace gnomon;

namespace {

const Image<std::uint8_t> everywhere;

// Two images read from files, as one pair.
struct Pictures {
    ChannelImage test, reference;

    static std::array<const Image<float>*, 3> colors(const ChannelImage& image) {
        return {&image.find("R")->values, &image.find("G")->values, &image.find("B")->values};
    }
    ColorPair pair(bool srgb) const { return {colors(test), colors(reference), everywhere, srgb}; }
};

Pictures read_pair(const std::string& folder, const nlohmann::json& pair) {
    return {read_image(folder + "/" + pair["test"].get<std::string>()),
            read_image(folder + "/" + pair["reference"].get<std::string>())};
}

// The value that the reference files give for "x,y", counted from the top left.
float value_at(const Image<float>& map, const std::string& place) {
    const size_t comma = place.find(',');
    return map(std::stoi(place), map.height() - 1 - std::stoi(place.substr(comma + 1)));
}

Image<float> waves(int width, int height, float phase) {
    Image<float> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            image(x, y) =
                0.5f + 0.4f * std::sin(0.2f * static_cast<float>(x) + phase) * std::cos(0.15f * static_cast<float>(y));
    return image;
}

ColorPair grey(const Image<float>& test, const Image<float>& reference, const Image<std::uint8_t>& mask = everywhere) {
    return {{&test, &test, &test}, {&reference, &reference, &reference}, mask, false};
}

} // namespace

TEST_CASE("FLIP agrees with its authors' program on every pair, in the mean and at every pixel") {
    const std::string folder = gnomon_tests::shared_path("flip-reference");
    if (folder.empty()) return;
    const nlohmann::json values = nlohmann::json::parse(read_file(folder + "/reference_values.json"));
    REQUIRE(values["ldr"].size() == 10);
    for (const nlohmann::json& pair : values["ldr"]) {
        const Pictures pictures = read_pair(folder, pair);
        const std::string test = pair["test"];
        INFO(test);
        const Image<float> map = flip_map(pictures.pair(true));
        CHECK(std::abs(mean_of_map(map) - pair["flip_ldr_mean"].get<double>()) < 1e-5);
        CHECK(std::abs(mean_of_map(flip_map(pictures.pair(true), 30.0f)) - pair["flip_ldr_mean_ppd30"].get<double>()) <
              1e-5);
        for (const auto& [place, expected] : pair["flip_ldr_pixels"].items())
            CHECK(std::abs(value_at(map, place) - expected.get<float>()) < 1e-3f);
        const ChannelImage expected = read_image(folder + "/flipmap_" + test);
        float largest = 0.0f;
        for (size_t i = 0; i < map.size(); ++i)
            largest = std::max(largest, std::abs(map.values()[i] - expected.channels[0].values.values()[i]));
        CHECK(largest < 2e-3f);
    }
}

TEST_CASE("HDR-FLIP agrees with its authors' program, exposures included") {
    const std::string folder = gnomon_tests::shared_path("flip-reference");
    if (folder.empty()) return;
    const nlohmann::json values = nlohmann::json::parse(read_file(folder + "/reference_values.json"));
    REQUIRE(values["hdr"].size() == 2);
    for (const nlohmann::json& pair : values["hdr"]) {
        const Pictures pictures = read_pair(folder, pair);
        INFO(pair["test"].get<std::string>());
        const ExposureRange range = automatic_exposures(pictures.pair(false));
        CHECK(std::abs(range.start - pair["start_exposure"].get<float>()) < 1e-4f);
        CHECK(std::abs(range.stop - pair["stop_exposure"].get<float>()) < 1e-4f);
        CHECK(range.count == pair["num_exposures"].get<int>());
        const Image<float> map = flip_hdr_map(pictures.pair(false));
        CHECK(std::abs(mean_of_map(map) - pair["flip_hdr_mean"].get<double>()) < 1e-5);
        for (const auto& [place, expected] : pair["flip_hdr_pixels"].items())
            CHECK(std::abs(value_at(map, place) - expected.get<float>()) < 2e-3f);
    }
}

TEST_CASE("FLIP of black against white is one, of equal pictures nothing") {
    const Image<float> black(80, 60, 0.0f), white(80, 60, 1.0f), picture = waves(80, 60, 0.0f);
    // The largest difference there is, green against blue, is beyond that of black and white: 0.95 and less at the
    // bend.
    const double difference = mean_of_map(flip_map(grey(black, white)));
    CHECK(difference > 0.9);
    CHECK(difference < 1.0);
    CHECK(mean_of_map(flip_map(grey(picture, picture))) == 0.0);
    CHECK(mean_of_map(flip_hdr_map(grey(picture, picture))) == 0.0);
    const Image<float> beyond(80, 60, 7.0f);
    CHECK(mean_of_map(flip_map(grey(beyond, white))) == 0.0); // clamped
}

namespace {

// A lamp of brightness `peak`, fading over half its width, on black that fills most of the picture.
Image<float> lamp(float peak, float shift) {
    Image<float> image(90, 70, 0.0f);
    for (int y = 20; y < 50; ++y)
        for (int x = 20; x < 60; ++x) {
            const float fade = std::clamp((static_cast<float>(x) - 20.0f + shift) / 20.0f, 0.0f, 1.0f);
            image(x, y) = peak * fade * fade;
        }
    return image;
}

// What the ACES curve makes of a value at an exposure [2021, 3; Narkowicz 2015].
float toned(float value, float stops) {
    const float x = value * std::exp2(stops);
    return std::clamp((0.6f * 0.6f * 2.51f * x + 0.6f * 0.03f) * x /
                          ((0.6f * 0.6f * 2.43f * x + 0.6f * 0.59f) * x + 0.14f),
                      0.0f, 1.0f);
}

} // namespace

TEST_CASE("HDR-FLIP of a picture that is mostly black has as many exposures as its authors' program, up to 40") {
    const auto range_of = [](float peak) {
        const Image<float> picture = lamp(peak, 0.0f);
        return automatic_exposures(grey(picture, picture));
    };
    const ExposureRange one = range_of(1.0f);
    CHECK(one.stop - one.start == Approx(23.0f)); // the median counts as 2^-23
    CHECK(one.count == 23);
    CHECK(range_of(65504.0f).count == 39); // the brightest half float
    CHECK(range_of(1e30f).count == most_exposures);
    CHECK(range_of(1e30f).stop - range_of(1e30f).start == Approx(23.0f + std::log2(1e30f)));
    const Image<float> black(90, 70, 0.0f);
    CHECK(automatic_exposures(grey(black, black)).count == 2);
    CHECK(mean_of_map(flip_hdr_map(grey(black, black))) == 0.0);
}

TEST_CASE("HDR-FLIP is the largest FLIP over the exposures, black surroundings or not") {
    for (const float background : {0.0f, 0.2f}) {
        Image<float> reference = lamp(4.0f, 0.0f), test = lamp(4.0f, 1.5f);
        for (Image<float>* image : {&reference, &test})
            for (float& value : image->values()) value += background;
        const ExposureRange range = automatic_exposures(grey(test, reference));
        CHECK(range.count == (background > 0.0f ? 5 : 25));
        Image<float> expected(90, 70, 0.0f);
        for (int i = 0; i < range.count; ++i) {
            const float stops =
                range.start + (range.stop - range.start) * static_cast<float>(i) / static_cast<float>(range.count - 1);
            Image<float> a = test, b = reference;
            for (Image<float>* image : {&a, &b})
                for (float& value : image->values()) value = toned(value, stops);
            const Image<float> map = flip_map(grey(a, b));
            for (size_t pixel = 0; pixel < map.size(); ++pixel)
                expected.values()[pixel] = std::max(expected.values()[pixel], map.values()[pixel]);
        }
        const Image<float> map = flip_hdr_map(grey(test, reference));
        float largest = 0.0f;
        for (size_t pixel = 0; pixel < map.size(); ++pixel)
            largest = std::max(largest, std::abs(map.values()[pixel] - expected.values()[pixel]));
        CHECK(mean_of_map(map) > 0.005);
        CHECK(largest == 0.0f);
    }
}

TEST_CASE("what is left out of FLIP's work is exactly zero") {
    // A difference in the first task alone, and one more in the second, which is left out without it.
    Image<float> reference = waves(1100, 140, 0.0f), one = reference;
    for (int y = 60; y < 70; ++y) one(480, y) += 0.5f;
    Image<float> two = one;
    two(1000, 20) += 0.5f;
    const Image<float> sparse = flip_map(grey(one, reference)), full = flip_map(grey(two, reference));
    size_t different = 0;
    for (int y = 0; y < 140; ++y)
        for (int x = 0; x < 960; ++x) different += sparse(x, y) != full(x, y);
    CHECK(different == 0);
    CHECK(sparse(482, 65) > 0.0f);
    CHECK(full(1000, 20) > 0.0f);
}

TEST_CASE("FLIP sees neither masked pixels nor missing ones") {
    const Image<float> reference = waves(90, 70, 0.0f), clean = waves(90, 70, 0.4f);
    Image<float> spoilt = clean, holes = clean;
    Image<std::uint8_t> mask(90, 70, 1);
    for (int y = 20; y < 40; ++y)
        for (int x = 30; x < 60; ++x) mask(x, y) = 0, spoilt(x, y) = 0.9f, holes(x, y) = std::nanf("");
    const Image<float> expected = flip_map(grey(clean, reference, mask));
    CHECK(std::isnan(expected(40, 30)));
    for (const Image<float>& map : {flip_map(grey(spoilt, reference, mask)), flip_map(grey(holes, reference))}) {
        bool same = true;
        for (size_t i = 0; i < map.size(); ++i)
            same = same && (map.values()[i] == expected.values()[i] ||
                            (std::isnan(map.values()[i]) && std::isnan(expected.values()[i])));
        CHECK(same);
    }
}

TEST_CASE("a picture of one pixel, and one wider than a task, have FLIP maps without seams") {
    const Image<float> black(1, 1, 0.0f), white(1, 1, 1.0f);
    CHECK(flip_map(grey(black, white))(0, 0) > 0.9f);
    // What depends on x alone must not depend on y, across the rows and columns where tasks meet.
    Image<float> test(1100, 300), reference(1100, 300, 0.5f);
    for (int y = 0; y < 300; ++y)
        for (int x = 0; x < 1100; ++x) test(x, y) = x % 50 < 25 ? 0.2f : 0.7f;
    const Image<float> map = flip_map(grey(test, reference));
    float across = 0.0f, along = 0.0f;
    for (int y = 0; y < 300; ++y)
        for (int x = 50; x < 1000; ++x) {
            across = std::max(across, std::abs(map(x, y) - map(x, 0)));
            along = std::max(along, std::abs(map(x, y) - map(x + 50, y)));
        }
    CHECK(across == 0.0f);
    CHECK(along == 0.0f);
}

TEST_CASE("roots and powers for vector code are within a millionth of the library's") {
    double root_error = 0, log_error = 0, exp_error = 0, pow_error = 0;
    for (int i = 1; i < 20000; ++i) {
        const float x = static_cast<float>(i) / 9000.0f;
        const double d = x;
        root_error = std::max(root_error, std::abs(vector_cbrt(x) / std::cbrt(d) - 1.0));
        log_error =
            std::max(log_error, std::abs(vector_log2(x) - std::log2(d)) / std::max(1.0, std::abs(std::log2(d))));
        exp_error = std::max(exp_error, std::abs(vector_exp2(x - 1.0f) / std::exp2(double{x - 1.0f}) - 1.0));
        pow_error = std::max(pow_error, std::abs(vector_pow(x, 0.7f) / std::pow(d, double{0.7f}) - 1.0));
    }
    CHECK(root_error < 1e-6);
    CHECK(log_error < 1e-6);
    CHECK(exp_error < 1e-6);
    CHECK(pow_error < 1e-6);
    CHECK(vector_pow(0.0f, 0.3f) == 0.0f);
    CHECK(vector_exp2(-100.0f) == 0x1p-100f);
    CHECK(vector_exp2(7.0f) == 128.0f);
}
