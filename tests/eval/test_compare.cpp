#include <catch2/catch.hpp>

#include <cmath>

#include "core/error.h"
#include "tests/eval/channels.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

template <class Failure>
std::string error_of(const ChannelImage& test, const ChannelImage& reference, CompareOptions options = {}) {
    options.test_name = "a.exr", options.reference_name = "b.exr";
    try {
        compare(test, reference, options);
    } catch (const Failure& error) {
        return error.what();
    }
    return "";
}

} // namespace

TEST_CASE("visibility is compared where both images have it, colour otherwise") {
    const ChannelImage both = with_channels({{"R", 0.1f}, {"G", 0.1f}, {"B", 0.1f}, {"V", 0.75f}});
    const ChannelImage truth = with_channels({{"V", 1.0f}, {"R", 0.1f}, {"G", 0.2f}, {"B", 0.4f}});
    const ChannelImage color = with_channels({{"R", 0.1f}, {"G", 0.1f}, {"B", 0.1f}});
    const Comparison visibility = compare(both, truth);
    CHECK(visibility.channels == std::vector<std::string>{"V"});
    CHECK(value_of(visibility, "mae") == 0.25);
    CHECK(value_of(visibility, "false_shadow") == 1.0);
    const Comparison colors = compare(color, truth);
    CHECK(colors.channels == std::vector<std::string>{"R", "G", "B"});
    CHECK(value_of(colors, "mae") == Approx((0.0 + 0.1 + 0.3) / 3));
    CHECK(value_of(colors, "rmse") == Approx(std::sqrt((0.01 + 0.09) / 3)));
    CHECK(value_of(colors, "psnr") == Approx(-10.0 * std::log10((0.01 + 0.09) / 3)));
    CHECK(value_of(colors, "max") == Approx(0.3));
    CHECK(std::isnan(value_of(colors, "false_shadow")));
}

TEST_CASE("one light called differently is one light, of several, the common ones are compared") {
    CHECK(value_of(compare(with_channels({{"V", 0.5f}}), with_channels({{"lamp.V", 1.0f}})), "mae") == 0.5);
    const ChannelImage test = with_channels({{"lamp.V", 0.5f}, {"sun.V", 1.0f}, {"sky.V", 0.0f}});
    const ChannelImage truth = with_channels({{"lamp.V", 1.0f}, {"sun.V", 1.0f}});
    const Comparison comparison = compare(test, truth);
    CHECK(comparison.channels == std::vector<std::string>{"lamp.V", "sun.V"});
    CHECK(value_of(comparison, "mae") == 0.25);
    CHECK(value_of(comparison, "rmse") == Approx(std::sqrt(0.125)));
}

TEST_CASE("explicit channels are compared, and only they") {
    const ChannelImage test = with_channels({{"V", 0.5f}, {"Z", 3.0f}, {"G", 0.5f}});
    const ChannelImage truth = with_channels({{"V", 1.0f}, {"Z", 5.0f}, {"G", 0.25f}});
    CompareOptions options;
    options.channels = {"Z"};
    CHECK(value_of(compare(test, truth, options), "mae") == 2.0);
    options.channels = {"G", "V"};
    CHECK(value_of(compare(test, truth, options), "mae") == 0.375);
    options.channels = {"Q"};
    CHECK(error_of<InputError>(test, truth, options) ==
          "there is no channel 'Q' to compare 'a.exr' with 'b.exr': 'a.exr' has V, Z, G");
}

TEST_CASE("the mask is the images' own, a given one, or none") {
    ChannelImage test = with_channels({{"lamp.V", 0.5f}, {"lamp.M", 1.0f}, {"M", 0.0f}});
    ChannelImage truth = with_channels({{"lamp.V", 1.0f}, {"lamp.M", 1.0f}});
    test.channels[0].values(3, 4) = 0.0f;
    test.channels[1].values(3, 4) = 0.0f;  // left out by the test
    truth.channels[1].values(5, 5) = 0.0f; // left out by the reference
    Comparison comparison = compare(test, truth);
    CHECK(comparison.pixels == 16 * 12);
    CHECK(comparison.masked == 16 * 12 - 2);
    CHECK(value_of(comparison, "max") == 0.5);
    CompareOptions options;
    options.mask_source = MaskSource::None;
    comparison = compare(test, truth, options);
    CHECK(comparison.masked == 16 * 12);
    CHECK(value_of(comparison, "max") == 1.0);
    options.mask_source = MaskSource::Given;
    options.mask = Image<std::uint8_t>(16, 12, 0);
    options.mask(3, 4) = 1;
    comparison = compare(test, truth, options);
    CHECK(comparison.masked == 1);
    CHECK(value_of(comparison, "mae") == 1.0);
    options.mask = Image<std::uint8_t>(15, 12, 0);
    CHECK(error_of<InputError>(test, truth, options) == "the mask is 15x12 but 'a.exr' and 'b.exr' are 16x12");
}

TEST_CASE("a colour that is missing in one channel is left out of all") {
    ChannelImage test = with_channels({{"R", 0.5f}, {"G", 0.5f}, {"B", 0.5f}});
    const ChannelImage truth = with_channels({{"R", 0.5f}, {"G", 0.5f}, {"B", 0.5f}});
    test.channels[0].values(2, 2) = std::nanf("");
    test.channels[2].values(2, 2) = 9.0f;
    const Comparison comparison = compare(test, truth);
    CHECK(comparison.missing == 1);
    CHECK(comparison.masked == 16 * 12 - 1);
    CHECK(value_of(comparison, "max") == 0.0);
}

TEST_CASE("an error map sees the mean of the compared channels") {
    const ChannelImage test = with_channels({{"a.V", 0.5f}, {"a.M", 1.0f}, {"b.V", 1.0f}, {"b.M", 0.0f}});
    ChannelImage truth = with_channels({{"a.V", 0.25f}, {"b.V", 0.0f}, {"a.M", 1.0f}});
    CompareOptions everywhere;
    everywhere.mask_source = MaskSource::None;
    ComparedValues values = compared_values(test, truth);
    CHECK(values.test(1, 1) == 0.5f);
    CHECK(values.reference(1, 1) == 0.25f);
    CHECK(values.mask(1, 1) == 1);
    truth.channels[2].values(1, 1) = 0.0f;
    CHECK(compared_values(test, truth).mask(1, 1) == 0);
    values = compared_values(test, truth, everywhere);
    CHECK(values.test(1, 1) == 0.75f);
    CHECK(values.mask.empty());
}

TEST_CASE("images that cannot be compared are errors that name both") {
    const ChannelImage visibility = with_channels({{"V", 1.0f}}), color = with_channels({{"R", 1.0f}, {"G", 1.0f}});
    CHECK(error_of<InputError>(visibility, with_channels({{"V", 1.0f}}, 8, 12)) ==
          "'a.exr' is 16x12 but 'b.exr' is 8x12; only images of one size can be compared");
    CHECK(error_of<InputError>(visibility, color) ==
          "'a.exr' (V) and 'b.exr' (R, G) have no visibility and no colour in common");
    CompareOptions options;
    options.metrics = {"rmsee"};
    CHECK(error_of<UsageError>(visibility, visibility, options) == "there is no metric 'rmsee'; did you mean 'rmse'?");
}

TEST_CASE("a comparison's JSON has the documented keys, and null for infinity") {
    CompareOptions options;
    options.test_name = "a.exr", options.reference_name = "b.exr", options.metrics = {"psnr", "rmse", "leak"};
    const ChannelImage image = with_channels({{"V", 1.0f}});
    CHECK(comparison_json(compare(image, image, options)).dump() ==
          R"({"test":"a.exr","reference":"b.exr","channels":["V"],"pixels":192,"masked":192,"missing":0,)"
          R"("metrics":{"rmse":0.0,"psnr":null}})");
}
