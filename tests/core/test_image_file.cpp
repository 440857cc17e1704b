#include <catch2/catch.hpp>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/image_file.h"
#include "core/parallel.h"
#include "tests/support.h"

using namespace gnomon;
namespace fs = std::filesystem;

namespace {

// Every pixel differs, so that a flip, a swap of channels or a wrong stride shows.
Image<float> numbered(int width, int height, float offset) {
    Image<float> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) image(x, y) = offset + static_cast<float>(y * width + x) / 7.0f;
    return image;
}

Image<vec3> colors(int width, int height) {
    Image<vec3> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            image(x, y) = vec3(static_cast<float>((x * 7 + y) % 256), static_cast<float>((y * 5) % 256),
                               static_cast<float>((x + y * 3) % 256)) /
                          255.0f;
    return image;
}

ChannelImage sample_image() {
    ChannelImage image;
    image.add_color("", colors(37, 83), true);
    image.add("lamp.V", numbered(37, 83, 0.0f));
    image.add_vector("N", colors(37, 83));
    image.add("A.weights", numbered(37, 83, -3.0f), true);
    mat4 matrix(1.0f);
    matrix[3] = vec4(1, 2, 3, 1);
    image.attributes = {{"gnomon:scene", std::string("builtin:half-plane:slope=0.25")},
                        {"gnomon:technique", std::string("pcf")},
                        {"renderTimeSeconds", 1.5f},
                        {"samplesPerPixel", 1024},
                        {"worldToCamera", matrix},
                        {"worldToNDC", matrix}};
    return image;
}

std::string error_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

bool is_one_line_about(const std::string& message, const std::string& path) {
    return message.find(path) != std::string::npos && message.find('\n') == std::string::npos;
}

size_t files_in(const std::string& folder) {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

} // namespace

TEST_CASE("an EXR gives back every channel and attribute") {
    const std::string path = gnomon_tests::temporary_folder() + "/image.exr";
    const ChannelImage written = sample_image();
    write_exr(path, written);
    const ChannelImage read = read_image(path);
    REQUIRE(read.width == 37);
    REQUIRE(read.height == 83);
    REQUIRE(read.channels.size() == written.channels.size());
    for (const Channel& channel : written.channels) {
        INFO(channel.name);
        const Channel* found = read.find(channel.name);
        REQUIRE(found);
        CHECK(found->half == channel.half);
        float largest_error = 0.0f;
        for (size_t i = 0; i < channel.values.size(); ++i) {
            const float value = channel.values.values()[i];
            largest_error =
                std::max(largest_error, std::abs(found->values.values()[i] - value) / (1.0f + std::abs(value)));
        }
        CHECK(largest_error <= (channel.half ? 0x1p-11f : 0.0f));
    }
    for (const auto& [name, value] : written.attributes) {
        INFO(name);
        REQUIRE(read.attributes.count(name) == 1);
        CHECK(read.attributes.at(name) == value);
    }
}

TEST_CASE("values that are not finite survive an EXR") {
    const std::string path = gnomon_tests::temporary_folder() + "/image.exr";
    ChannelImage image;
    image.add("V", Image<float>(3, 1));
    image.channels[0].values(0, 0) = std::nanf("");
    image.channels[0].values(1, 0) = infinity;
    image.channels[0].values(2, 0) = -0.0f;
    write_exr(path, image);
    const Image<float> read = read_image(path).channels[0].values;
    CHECK(std::isnan(read(0, 0)));
    CHECK(read(1, 0) == infinity);
    CHECK(std::signbit(read(2, 0)));
}

TEST_CASE("the same image gives the same bytes, for any number of threads, and without a date") {
    const std::string folder = gnomon_tests::temporary_folder();
    write_exr(folder + "/a.exr", sample_image());
    write_png(folder + "/a.png", colors(300, 200), {{"gnomon:scene", "room"}});
    const std::string exr = read_file(folder + "/a.exr"), png = read_file(folder + "/a.png");
    for (const int threads : {1, 2, 7})
        with_threads(threads, [&] {
            write_exr(folder + "/b.exr", sample_image());
            write_png(folder + "/b.png", colors(300, 200), {{"gnomon:scene", "room"}});
            CHECK(read_file(folder + "/b.exr") == exr);
            CHECK(read_file(folder + "/b.png") == png);
        });
    for (const char* word : {"capDate", "DateTime", "Software", "HostComputer", "tIME"}) {
        INFO(word);
        CHECK(exr.find(word) == std::string::npos);
        CHECK(png.find(word) == std::string::npos);
    }
}

TEST_CASE("a PNG gives back 8-bit values and its text") {
    const std::string path = gnomon_tests::temporary_folder() + "/image.png";
    Image<vec3> image = colors(300, 200);
    image(0, 0) = vec3(-1.0f, 2.0f, std::nanf(""));
    image(1, 0) = vec3(0.5f / 255.0f, 0.49f / 255.0f, 254.5f / 255.0f);
    write_png(path, image, {{"gnomon:technique", "pcf"}});
    const ChannelImage read = read_image(path);
    CHECK(std::get<std::string>(read.attributes.at("gnomon:technique")) == "pcf");
    REQUIRE(read.channels.size() == 3);
    const auto code = [&](size_t channel, int x, int y) { return read.channels[channel].values(x, y) * 255.0f; };
    CHECK(code(0, 0, 0) == 0.0f);
    CHECK(code(1, 0, 0) == 255.0f);
    CHECK(code(2, 0, 0) == 0.0f);
    CHECK(code(0, 1, 0) == 1.0f);
    CHECK(code(1, 1, 0) == 0.0f);
    CHECK(code(2, 1, 0) == 255.0f);
    for (const int y : {0, 63, 64, 199})
        for (size_t c = 0; c < 3; ++c)
            CHECK(std::lround(code(c, 123, y)) == std::lround(image(123, y)[static_cast<int>(c)] * 255.0f));
}

TEST_CASE("a PNG encoded in memory is the file") {
    const std::string path = gnomon_tests::temporary_folder() + "/memory.png";
    const Image<vec3> image = colors(70, 90);
    write_text_file(path, encode_png(image));
    const ChannelImage read = read_image(path);
    Image<std::uint8_t> gray(70, 90);
    for (size_t i = 0; i < gray.size(); ++i) {
        gray.values()[i] = static_cast<std::uint8_t>(i * 7);
        for (size_t c = 0; c < 3; ++c)
            REQUIRE(read.channels[c].values.values()[i] == Approx(image.values()[i][static_cast<int>(c)]));
    }
    write_text_file(path, encode_png(gray));
    const ChannelImage read_gray = read_image(path);
    REQUIRE(read_gray.channels.size() == 1);
    for (size_t i = 0; i < gray.size(); ++i)
        REQUIRE(std::lround(read_gray.channels[0].values.values()[i] * 255.0f) == gray.values()[i]);
}

TEST_CASE("the bottom row in memory is the last row of a file") {
    // A PPM is plain text order: its first triple is the top left pixel.
    const std::string path = gnomon_tests::temporary_folder() + "/two.ppm";
    std::ofstream(path, std::ios::binary) << "P6\n1 2\n255\n" << std::string("\xff\0\0\0\0\xff", 6);
    const ChannelImage image = read_image(path);
    CHECK(image.find("R")->values(0, 1) == 1.0f); // red on top
    CHECK(image.find("B")->values(0, 0) == 1.0f);

    const std::string png = gnomon_tests::temporary_folder() + "/two.png";
    Image<vec3> both(1, 2);
    both(0, 1) = vec3(1, 0, 0);
    write_png(png, both);
    CHECK(read_image(png).find("R")->values(0, 1) == 1.0f);
}

TEST_CASE("broken images are one-line errors that name the file") {
    const std::string folder = gnomon_tests::temporary_folder();
    write_exr(folder + "/whole.exr", sample_image());
    write_png(folder + "/whole.png", colors(64, 64));
    for (const std::string extension : {"exr", "png"}) {
        const std::string whole = read_file(folder + "/whole." + extension), path = folder + "/cut." + extension;
        for (size_t eighth = 0; eighth < 8; ++eighth) {
            write_text_file(path, std::string_view(whole).substr(0, whole.size() * eighth / 8));
            INFO(extension << " cut to " << eighth << "/8");
            CHECK(is_one_line_about(error_of([&] { read_image(path); }), path));
        }
    }
    write_text_file(folder + "/not.exr", "this is not an image\n");
    CHECK(is_one_line_about(error_of([&] { read_image(folder + "/not.exr"); }), folder + "/not.exr"));
    CHECK(is_one_line_about(error_of([&] { read_image(folder); }), folder));
    CHECK(error_of([] { read_image("nowhere.exr"); }) == "cannot read 'nowhere.exr': there is no such file");
}

TEST_CASE("an image whose bytes are damaged is read or refused, never a crash") {
    const std::string folder = gnomon_tests::temporary_folder();
    write_exr(folder + "/whole.exr", sample_image());
    write_png(folder + "/whole.png", colors(64, 64));
    for (const std::string extension : {"exr", "png"}) {
        const std::string whole = read_file(folder + "/whole." + extension), path = folder + "/damaged." + extension;
        for (size_t i = 0; i < std::min<size_t>(whole.size(), 400); i += 3) {
            std::string damaged = whole;
            damaged[i] = static_cast<char>(damaged[i] ^ 0x55);
            write_text_file(path, damaged);
            try {
                read_image(path);
            } catch (const InputError& error) {
                CHECK(is_one_line_about(error.what(), path));
            }
        }
    }
}

TEST_CASE("a header that promises more than its file can hold is refused before the memory is taken") {
    const std::string path = gnomon_tests::temporary_folder() + "/huge.ppm";
    std::ofstream(path, std::ios::binary) << "P6\n32768 32768\n255\nxyz";
    CHECK(error_of([&] { read_image(path); }).find("more than it can hold") != std::string::npos);
    std::ofstream(path, std::ios::binary) << "P6\n40000 2\n255\nxyz";
    CHECK(error_of([&] { read_image(path); }).find("each side may be at most 32768 pixels") != std::string::npos);
}

TEST_CASE("a file that cannot be written is an error, and leaves nothing behind") {
    const std::string folder = gnomon_tests::temporary_folder();
    CHECK(error_of([&] { write_exr(folder + "/none/a.exr", sample_image()); }) ==
          "cannot write '" + folder + "/none/a.exr': there is no folder '" + folder + "/none'");
    fs::create_directory(folder + "/taken.png");
    CHECK(error_of([&] { write_png(folder + "/taken.png", colors(2, 2)); }) ==
          "cannot write '" + folder + "/taken.png': it is a folder");
    CHECK(is_one_line_about(error_of([&] { write_exr("/proc/a.exr", sample_image()); }), "/proc/a.exr"));
    CHECK(is_one_line_about(error_of([&] { write_exr(folder + "/empty.exr", {}); }), folder + "/empty.exr"));
    CHECK(files_in(folder) == 1);
    if (fs::exists("/dev/full"))
        CHECK(is_one_line_about(error_of([] { write_text_file("/dev/full", "x"); }), "/dev/full"));
}

TEST_CASE("a failed write leaves the old file as it was") {
    const std::string folder = gnomon_tests::temporary_folder(), path = folder + "/kept.txt";
    write_text_file(path, "old");
    const auto fail = [](const std::string& temporary_path) {
        std::ofstream(temporary_path) << "half of the n";
        throw InputError("no");
    };
    CHECK_THROWS_AS(write_atomically(path, fail), InputError);
    CHECK(read_file(path) == "old");
    write_text_file(path, "new");
    CHECK(read_file(path) == "new");
    CHECK(files_in(folder) == 1);
}

TEST_CASE("links and devices are written through, not replaced") {
    const std::string folder = gnomon_tests::temporary_folder();
    write_text_file(folder + "/real.txt", "old");
    fs::create_symlink("real.txt", folder + "/link.txt");
    write_text_file(folder + "/link.txt", "new");
    CHECK(fs::is_symlink(folder + "/link.txt"));
    CHECK(read_file(folder + "/real.txt") == "new");
    write_text_file("/dev/null", "gone");
    CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("sRGB is the transfer function of IEC 61966-2-1") {
    CHECK(srgb_from_linear(0.0f) == 0.0f);
    CHECK(srgb_from_linear(1.0f) == Approx(1.0f));
    CHECK(srgb_from_linear(0.5f) == Approx(0.735357f));
    CHECK(srgb_from_linear(0.001f) == Approx(0.01292f));
    for (int i = 0; i <= 255; ++i) {
        const float code = static_cast<float>(i) / 255.0f;
        CHECK(std::lround(srgb_from_linear(linear_from_srgb(code)) * 255.0f) == i);
    }
}
