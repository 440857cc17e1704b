#include <catch2/catch.hpp>

#include <cmath>
#include <set>

#include "core/error.h"
#include "core/parallel.h"
#include "eval/bitmap_font.h"
#include "eval/color_map.h"
#include "eval/error_map.h"

using namespace gnomon;

namespace {

const Image<std::uint8_t> everywhere;

vec3 color_of(float test, float reference, ErrorMapOptions options) {
    options.color_bar = false;
    return draw_error_map(Image<float>(1, 1, test), Image<float>(1, 1, reference), everywhere, options)(0, 0);
}

vec3 rgb(int hex) { return vec3(hex >> 16, hex >> 8 & 255, hex & 255) / 255.0f; }

bool near(vec3 a, vec3 b) { return glm::length(a - b) < 1e-5f; }

} // namespace

TEST_CASE("the signed map is blue under, white at zero and red over") {
    const ErrorMapOptions options{ErrorMapKind::Signed, 0.5f, false, ""};
    CHECK(near(color_of(0.3f, 0.3f, options), vec3(1.0f)));
    CHECK(near(color_of(0.0f, 0.5f, options), rgb(0x08306b)));
    CHECK(near(color_of(0.5f, 0.0f, options), rgb(0x67001f)));
    CHECK(near(color_of(1.0f, 0.0f, options), rgb(0x67001f))); // beyond the range
    CHECK(near(color_of(0.4f, 0.5f, options), rgb(0xd1e5f0))); // a fifth of the range is one anchor
    CHECK(near(color_of(0.5f, 0.4f, options), rgb(0xfddbc7)));
}

TEST_CASE("the magnitude map is magma") {
    const ErrorMapOptions options{ErrorMapKind::Magnitude, 1.0f, false, ""};
    CHECK(near(color_of(0.5f, 0.5f, options), rgb(0x000004)));
    CHECK(near(color_of(0.0f, 1.0f, options), rgb(0xfcfdbf)));
    CHECK(near(color_of(1.0f, 0.0f, options), rgb(0xfcfdbf)));
    CHECK(near(color_of(0.2f, 0.0f, options), rgb(0x3b0f70))); // 51/255 is an anchor
    CHECK(glm::length(map_color(magma(), 128.0f / 255.0f) - rgb(0xb73779)) < 0.012f);
}

TEST_CASE("pixels outside the mask and missing ones have colours of their own") {
    Image<float> test(3, 1, 0.5f);
    const Image<float> reference(3, 1, 0.5f);
    Image<std::uint8_t> mask(3, 1, 1);
    mask(0, 0) = 0;
    test(1, 0) = std::nanf("");
    const Image<vec3> map = draw_error_map(test, reference, mask, {ErrorMapKind::Signed, 0.0f, false, ""});
    CHECK(map(0, 0) == masked_out_color);
    CHECK(map(1, 0) == missing_color);
    CHECK(map(2, 0) == vec3(1.0f));
}

TEST_CASE("the automatic range is the next round number") {
    CHECK(nice_range(0.0f) == 1.0f);
    CHECK(nice_range(infinity) == 1.0f);
    CHECK(nice_range(1.0f) == 1.0f);
    CHECK(nice_range(0.73f) == 1.0f);
    CHECK(nice_range(0.3f) == 0.5f);
    CHECK(nice_range(0.21f) == 0.25f);
    CHECK(nice_range(0.1f) == 0.1f);
    CHECK(nice_range(0.0011f) == 0.002f);
    CHECK(nice_range(137.0f) == 200.0f);
    // A difference of 0.4 takes the range 0.5.
    const Image<vec3> map = draw_error_map(Image<float>(1, 1, 0.4f), Image<float>(1, 1, 0.0f), everywhere,
                                           {ErrorMapKind::Magnitude, 0.0f, false, ""});
    CHECK(near(map(0, 0), map_color(magma(), 0.8f)));
}

TEST_CASE("the colour bar stands below the picture and does not touch it") {
    const Image<float> test(300, 100, 0.75f), reference(300, 100, 0.5f);
    const Image<vec3> map = draw_error_map(test, reference, everywhere, {ErrorMapKind::Signed, 1.0f, true, "pcf"});
    CHECK(map.width() == 300);
    REQUIRE(map.height() == 136);
    for (const int y : {36, 80, 135}) CHECK(near(map(150, y), map_color(blue_white_red(), 0.625f)));
    const int bar = 16;
    CHECK(glm::length(map(6, bar) - rgb(0x08306b)) < 0.02f);
    CHECK(glm::length(map(150, bar) - vec3(1.0f)) < 0.02f);
    CHECK(glm::length(map(293, bar) - rgb(0x67001f)) < 0.02f);
    // Narrow pictures are widened, so that the labels stay apart.
    CHECK(draw_error_map(Image<float>(8, 8), Image<float>(8, 8), everywhere).width() > 100);
}

TEST_CASE("every letter of the font differs from every other and stays in its cell") {
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.,-+:%/()=_<>|?";
    std::set<std::string> shapes;
    for (const char letter : letters) {
        Image<vec3> cell(glyph_advance, glyph_height + 1, vec3(0.0f));
        draw_text(cell, 0, 0, std::string(1, letter), vec3(1.0f), 1);
        std::string shape;
        for (const vec3& value : cell.values()) shape += value.x > 0.0f ? '#' : '.';
        shapes.insert(shape);
        for (int y = 0; y < glyph_height; ++y) CHECK(cell(glyph_advance - 1, y).x == 0.0f);
    }
    CHECK(shapes.size() == letters.size());
    Image<vec3> small(4, 4);
    draw_text(small, -3, -3, "clipped", vec3(1.0f), 2); // must not write outside
    CHECK(text_width("abc", 2) == 34);
}

TEST_CASE("images of different sizes have no error map") {
    CHECK_THROWS_AS(draw_error_map(Image<float>(2, 2), Image<float>(2, 3), everywhere), InputError);
}

TEST_CASE("an error map has the same bits for any number of threads") {
    Image<float> test(211, 173), reference(211, 173, 0.4f);
    for (size_t i = 0; i < test.size(); ++i) test.values()[i] = static_cast<float>(i % 97) / 97.0f;
    Image<vec3> one;
    with_threads(1, [&] { one = draw_error_map(test, reference, everywhere); });
    with_threads(7, [&] {
        const Image<vec3> many = draw_error_map(test, reference, everywhere);
        CHECK(std::equal(many.values().begin(), many.values().end(), one.values().begin()));
    });
}

TEST_CASE("the overlay shows leaks and false shadows, on the reference") {
    const ErrorMapOptions options{ErrorMapKind::Overlay, 1.0f, false, ""};
    CHECK(near(color_of(1.0f, 0.0f, options), rgb(0xb00810))); // a leak
    CHECK(near(color_of(0.0f, 1.0f, options), rgb(0x0a1f9c))); // a false shadow
    CHECK(near(color_of(0.05f, 0.0f, options), vec3(0.25f)));  // no leak yet: the reference's dark grey
    CHECK(near(color_of(0.95f, 1.0f, options), vec3(0.85f)));  // no false shadow yet: its light grey
    CHECK(near(color_of(0.0f, 0.5f, options), vec3(0.55f)));   // of the penumbra it says nothing
    const Image<float> values =
        error_values(ErrorMapKind::Overlay, Image<float>(1, 1, 0.25f), Image<float>(1, 1, 0.0f));
    CHECK(values(0, 0) == 0.25f);
}

TEST_CASE("false colours run from blue over green to red") {
    const ErrorMapOptions options{ErrorMapKind::FalseColor, 1.0f, false, ""};
    CHECK(near(color_of(0.5f, 0.5f, options), rgb(0x0000ff)));
    CHECK(near(color_of(1.0f, 0.5f, options), rgb(0x00ff00)));
    CHECK(near(color_of(0.0f, 1.0f, options), rgb(0xff0000)));
}

TEST_CASE("a FLIP map runs through magma from nothing to one") {
    Image<float> map(3, 1, 0.0f);
    map(1, 0) = 1.0f, map(2, 0) = std::nanf("");
    const Image<vec3> picture = draw_error_values(map, map, everywhere, {ErrorMapKind::Flip, 0.0f, false, ""});
    CHECK(near(picture(0, 0), rgb(0x000004)));
    CHECK(near(picture(1, 0), rgb(0xfcfdbf)));
    CHECK(picture(2, 0) == missing_color);
    for (int kind = 0; kind < error_map_kinds; ++kind)
        CHECK_FALSE(std::string(error_map_kind_name(static_cast<ErrorMapKind>(kind))).empty());
}
