#include <catch2/catch.hpp>

#include <cmath>

#include "core/error.h"
#include "tests/eval/channels.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

Comparison compared(const ChannelImage& test, const ChannelImage& reference, const std::vector<std::string>& channels,
                    bool as_visibility = false) {
    CompareOptions options;
    options.channels = channels, options.as_visibility = as_visibility;
    return compare(test, reference, options);
}

ChannelImage coded(ChannelImage image) {
    image.attributes["oiio:ColorSpace"] = std::string("sRGB");
    return image;
}

} // namespace

TEST_CASE("a channel can meet one of another name, and a layer stands for its colours") {
    const ChannelImage test =
        with_channels({{"shadow", 0.5f}, {"diffuse.B", 0.1f}, {"diffuse.G", 0.2f}, {"diffuse.R", 0.3f}});
    const ChannelImage truth = with_channels({{"V", 0.75f},
                                              {"R", 0.4f},
                                              {"G", 0.4f},
                                              {"B", 0.4f},
                                              {"diffuse.R", 0.3f},
                                              {"diffuse.G", 0.2f},
                                              {"diffuse.B", 0.4f}});
    CHECK(value_of(compared(test, truth, {"shadow=V"}), "mae") == 0.25);
    const Comparison layer = compared(test, truth, {"diffuse"});
    CHECK(layer.channels == std::vector<std::string>{"diffuse.R", "diffuse.G", "diffuse.B"});
    CHECK(value_of(layer, "max") == Approx(0.3));
    CHECK(value_of(layer, "flip") > 0.0); // a whole colour is a picture
    CHECK(value_of(compared(test, truth, {"diffuse.B", "diffuse.R", "diffuse.G"}), "flip") == value_of(layer, "flip"));
    CHECK(std::isnan(value_of(compared(test, truth, {"diffuse.R", "diffuse.G"}), "flip")));
    CHECK(std::isnan(value_of(compared(test, truth, {"shadow=V"}), "flip"))); // data of unknown meaning
    CHECK_THROWS_AS(compared(test, truth, {"specular"}), InputError);
}

TEST_CASE("channels of any name can be declared visibility") {
    const ChannelImage test = with_channels({{"Y", 0.0f}}), truth = with_channels({{"Y", 1.0f}});
    CHECK(std::isnan(value_of(compared(test, truth, {}), "false_shadow")));
    const Comparison comparison = compared(test, truth, {}, true);
    CHECK(value_of(comparison, "false_shadow") == 1.0);
    REQUIRE(comparison.confusion);
    CHECK((*comparison.confusion)[2][0] == 16 * 12);
}

TEST_CASE("sRGB codes meet scene-linear colours as light") {
    ChannelImage codes = coded(with_channels({{"R", 0.5f}, {"G", 0.5f}, {"B", 0.5f}, {"A", 0.5f}}));
    ChannelImage linear = with_channels({{"R", 0.5f}, {"G", 0.5f}, {"B", 0.5f}});
    CHECK_THROWS_AS(compare(codes, linear), InputError);
    match_encodings(codes, linear);
    CHECK(codes.find("R")->values(0, 0) == linear_from_srgb(0.5f));
    CHECK(codes.find("A")->values(0, 0) == 0.5f);
    CHECK(linear.find("R")->values(0, 0) == 0.5f);
    CHECK(value_of(compare(codes, linear), "mae") == Approx(0.5 - linear_from_srgb(0.5f)));
    ChannelImage one = coded(linear), two = coded(linear);
    match_encodings(one, two);
    CHECK(one.find("R")->values(0, 0) == 0.5f); // two of a kind stay as they are
    CHECK(std::isnan(value_of(compare(one, two), "flip_hdr")));
    CHECK(value_of(compare(linear, linear), "flip_hdr") == 0.0);
}

TEST_CASE("the penumbra of the truth is a mask, of visibility alone") {
    ChannelImage truth = with_channels({{"V", 1.0f}}), test = with_channels({{"V", 0.0f}});
    for (int x = 0; x < 16; ++x) truth.channels[0].values(x, 3) = 0.25f;
    truth.channels[0].values(0, 3) = std::nanf("");
    CompareOptions options;
    options.only_penumbra = true;
    const Comparison comparison = compare(test, truth, options);
    CHECK(comparison.masked == 15);
    CHECK(comparison.missing == 1);
    CHECK(value_of(comparison, "mae") == 0.25);
    CHECK_THROWS_AS(compare(with_channels({{"Y", 1.0f}}), with_channels({{"Y", 1.0f}}), options), UsageError);
}

TEST_CASE("a given mask narrows the images' own") {
    ChannelImage test = with_channels({{"V", 0.5f}, {"M", 1.0f}});
    test.channels[1].values(2, 9) = 0.0f;
    const ChannelImage truth = with_channels({{"V", 1.0f}});
    CompareOptions options;
    options.mask = rectangle_mask(16, 12, 1, 2, 4, 1); // row 2 from the top is row 9 from the bottom
    CHECK(compare(test, truth, options).masked == 3);
    options.mask_source = MaskSource::None;
    CHECK(compare(test, truth, options).masked == 4);
    CHECK_THROWS_AS(rectangle_mask(16, 12, 10, 0, 7, 1), InputError);
    CHECK_THROWS_AS(rectangle_mask(16, 12, 0, 0, 0, 1), InputError);
}

TEST_CASE("ids choose pixels") {
    ChannelImage image = with_channels({{"id", 3.0f}});
    image.channels[0].values(1, 1) = 7.0f, image.channels[0].values(2, 1) = 8.0f;
    const Image<std::uint8_t> mask = id_mask(image, "a.exr", "id", {7, 8});
    CHECK(std::count(mask.values().begin(), mask.values().end(), 1) == 2);
    CHECK(mask(2, 1) == 1);
    CHECK_THROWS_AS(id_mask(image, "a.exr", "object", {7}), InputError);
}

TEST_CASE("confusion is counted over all visibilities, and in the JSON under its own key") {
    const ChannelImage test = with_channels({{"a.V", 0.0f}, {"b.V", 1.0f}}),
                       truth = with_channels({{"a.V", 0.5f}, {"b.V", 1.0f}});
    const auto json = comparison_json(compare(test, truth));
    CHECK(json["confusion"].dump() ==
          R"({"classes":["umbra","penumbra","lit"],"pixels":[[0,0,0],[192,0,0],[0,0,192]]})");
    CHECK(json["metrics"]["class_error"] == 0.5);
    CompareOptions few;
    few.metrics = {"mae"};
    CHECK_FALSE(comparison_json(compare(test, truth, few)).contains("confusion"));
}

TEST_CASE("a colour's map shows luminance, and FLIP where it is a picture") {
    const ChannelImage test = with_channels({{"R", 1.0f}, {"G", 0.0f}, {"B", 0.0f}}),
                       truth = with_channels({{"R", 0.0f}, {"G", 0.0f}, {"B", 0.0f}});
    const ComparedValues values = compared_values(test, truth);
    CHECK(values.what == "luminance");
    CHECK(values.test(3, 3) == 0.2126f);
    CHECK(compared_flip(test, test).what == "HDR-FLIP R G B");
    CHECK(compared_flip(with_channels({{"V", 1.0f}}), with_channels({{"V", 1.0f}})).what == "FLIP V");
    const Image<float> map = compared_flip(test, test).values;
    CHECK(*std::max_element(map.values().begin(), map.values().end()) == 0.0f);
    CompareOptions data;
    data.channels = {"Z"};
    CHECK_THROWS_AS(compared_flip(with_channels({{"Z", 1.0f}}), with_channels({{"Z", 1.0f}}), data), InputError);
}
