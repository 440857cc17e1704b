// Images as other programs write them: half, float and whole numbers, channels in any order, tiles, several parts.

#include <catch2/catch.hpp>

#include <OpenImageIO/imageio.h>

#include "core/error.h"
#include "core/image_file.h"
#include "tests/support.h"

using namespace gnomon;

namespace {

constexpr int width = 70, height = 45;

float value_of(int channel, int x, int y) { return static_cast<float>(channel * 4000 + y * width + x) / 16384.0f; }

struct Layout {
    std::vector<std::string> channels = {"R", "G", "B"};
    std::vector<OIIO::TypeDesc> types = {};
    OIIO::TypeDesc type = OIIO::TypeFloat;
    int tile = 0;
    int images = 1;
};

// Rows from the top; the channel of each name has the values of its place in "RGBid".
std::string write(const std::string& name, const Layout& layout) {
    const std::string path = gnomon_tests::temporary_folder() + "/" + name;
    OIIO::ImageSpec spec(width, height, static_cast<int>(layout.channels.size()), layout.type);
    spec.channelnames = layout.channels;
    spec.channelformats = layout.types;
    spec.tile_width = spec.tile_height = layout.tile;
    std::vector<float> samples;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (const std::string& channel : layout.channels)
                samples.push_back(value_of(static_cast<int>(std::string("RGB").find(channel)), x, y));
    const auto output = OIIO::ImageOutput::create(path);
    REQUIRE(output);
    const std::vector<OIIO::ImageSpec> specs(static_cast<size_t>(layout.images), spec);
    REQUIRE((layout.images > 1 ? output->open(path, layout.images, specs.data()) : output->open(path, spec)));
    for (int image = 0; image < layout.images; ++image) {
        if (image > 0) REQUIRE(output->open(path, spec, OIIO::ImageOutput::AppendSubimage));
        REQUIRE(output->write_image(OIIO::TypeFloat, samples.data()));
    }
    REQUIRE(output->close());
    return path;
}

float largest_error(const std::string& path) {
    const ChannelImage image = read_image(path);
    REQUIRE(image.width == width);
    REQUIRE(image.height == height);
    float largest = 0.0f;
    for (const char* name : {"R", "G", "B"}) {
        const Channel* channel = image.find(name);
        REQUIRE(channel);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                largest = std::max(largest, std::abs(channel->values(x, height - 1 - y) -
                                                     value_of(static_cast<int>(std::string("RGB").find(name)), x, y)));
    }
    return largest;
}

} // namespace

TEST_CASE("images of any layout give the values that are in them") {
    CHECK(largest_error(write("float.exr", {})) == 0.0f);
    CHECK(largest_error(write("order.exr", {.channels = {"B", "G", "R"}})) == 0.0f);
    CHECK(largest_error(write("half.exr", {.type = OIIO::TypeHalf})) < 1e-3f);
    CHECK(largest_error(write("tiled.exr", {.tile = 16})) == 0.0f);
    CHECK(largest_error(write("mixed.exr", {.types = {OIIO::TypeHalf, OIIO::TypeFloat, OIIO::TypeHalf}})) < 1e-3f);
    CHECK(largest_error(write("sixteen.png", {.type = OIIO::TypeUInt16})) < 1e-5f);
    CHECK(largest_error(write("eight.png", {.type = OIIO::TypeUInt8})) < 0.0021f);
    CHECK(largest_error(write("float.tif", {})) == 0.0f);
}

TEST_CASE("whole numbers of an EXR are numbers, not fractions, in rows and in tiles") {
    for (const int tile : {0, 16}) {
        const std::string path = gnomon_tests::temporary_folder() + "/ids.exr";
        OIIO::ImageSpec spec(width, height, 2, OIIO::TypeFloat);
        spec.channelnames = {"V", "id"};
        spec.channelformats = {OIIO::TypeFloat, OIIO::TypeUInt32};
        spec.tile_width = spec.tile_height = tile;
        struct Sample {
            float visibility;
            std::uint32_t id;
        };
        std::vector<Sample> samples;
        for (std::uint32_t i = 0; i < width * height; ++i) samples.push_back({0.25f, i * 5000});
        const auto output = OIIO::ImageOutput::create(path);
        REQUIRE((output && output->open(path, spec)));
        REQUIRE(output->write_image(OIIO::TypeUnknown, samples.data()));
        REQUIRE(output->close());
        const ChannelImage image = read_image(path);
        bool right = true;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                right = right && image.find("V")->values(x, y) == 0.25f &&
                        image.find("id")->values(x, height - 1 - y) == static_cast<float>((y * width + x) * 5000);
        CHECK(right);
    }
}

TEST_CASE("a file of several images is refused with what to do about it") {
    const std::string path = write("parts.exr", {.images = 2});
    try {
        read_image(path);
        FAIL("it was read");
    } catch (const InputError& error) {
        CHECK(std::string(error.what()) ==
              "cannot read '" + path +
                  "': it holds several images; take out the one you mean, for example by oiiotool --subimage");
    }
}
