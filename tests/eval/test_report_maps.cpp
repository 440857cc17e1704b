// The error maps on the report's page are those that the program draws.

#include <catch2/catch.hpp>

#include <cmath>

#include "core/image_file.h"
#include "eval/error_map.h"
#include "eval/flip.h"
#include "eval/metric/classes.h"
#include "eval/report/embed.h"
#include "tests/eval/base64.h"
#include "tests/eval/report_page.h"

using namespace gnomon;
using namespace gnomon_tests;
using nlohmann::json;

namespace {

// What the report compares for one of its techniques, as stored beside the page.
struct Compared {
    Image<float> test, reference;
    Image<std::uint8_t> mask;

    explicit Compared(const std::string& name)
        : test(read_image(rendered_folder() + "/" + name + ".exr").find("V")->values),
          reference(read_image(rendered_folder() + "/truth.exr").find("V")->values), mask(320, 180) {
        const ChannelImage layers = read_image(rendered_folder() + "/truth.exr");
        const Image<float>& facing = layers.find("M")->values;
        for (size_t i = 0; i < mask.size(); ++i) mask.values()[i] = facing.values()[i] > 0.0f;
    }
    Image<float> flip() const { return flip_map({{&test, &test, &test}, {&reference, &reference, &reference}, mask}); }
    Image<vec3> picture(ErrorMapKind kind) const {
        const ErrorMapOptions options{kind, 0.0f, false, ""};
        return kind == ErrorMapKind::Flip ? draw_error_values(flip(), reference, mask, options)
                                          : draw_error_map(test, reference, mask, options);
    }
};

// A layer of an entry as the page paints it: bytes of red, green, blue and opacity, the top row first.
std::string painted(Browser& browser, int entry, const std::string& layer) {
    return decoded_base64(browser.evaluate(
        "(async () => { const entry = entries[" + std::to_string(entry) + "], range = is_error_layer('" + layer +
        "') ? nice_range(await largest_error(entry)) : 1, canvas = await layer_image(entry, '" + layer +
        "', range); const bytes = canvas.getContext('2d').getImageData(0, 0, 320, 180).data; let text = ''; "
        "for (const byte of bytes) text += String.fromCharCode(byte); return btoa(text); })()"));
}

struct Difference {
    int largest = 0;
    size_t colors = 0; // different ones in the program's map
};

Difference difference(const std::string& bytes, const Image<vec3>& map) {
    Difference found;
    std::vector<int> colors;
    for (int y = 0; y < 180; ++y)
        for (int x = 0; x < 320; ++x)
            for (int c = 0; c < 3; ++c) {
                const int shown = static_cast<unsigned char>(bytes[static_cast<size_t>(((179 - y) * 320 + x) * 4 + c)]);
                const auto drawn = static_cast<int>(std::lround(map(x, y)[c] * 255.0f));
                found.largest = std::max(found.largest, std::abs(shown - drawn));
                if (c == 0) colors.push_back(drawn);
            }
    std::sort(colors.begin(), colors.end());
    found.colors = static_cast<size_t>(std::unique(colors.begin(), colors.end()) - colors.begin());
    return found;
}

} // namespace

TEST_CASE("browser: FLIP, false-colour and other maps are painted as the program draws them", "[browser]") {
    const std::string program = chromium_path();
    if (program.empty()) return;
    Browser browser(program);
    browser.open(rendered_folder() + "/report.html", page_ready);
    const std::pair<int, const char*> entries[] = {{1, "sm"}, {2, "pcf"}, {3, "pcf-2"}}; // after the truth
    const std::pair<const char*, ErrorMapKind> layers[] = {{"signed", ErrorMapKind::Signed},
                                                           {"magnitude", ErrorMapKind::Magnitude},
                                                           {"false-color", ErrorMapKind::FalseColor},
                                                           {"flip", ErrorMapKind::Flip}};
    for (const auto& [entry, name] : entries) {
        const Compared images(name);
        for (const auto& [layer, kind] : layers) {
            INFO(layer << " of " << name);
            const Difference found = difference(painted(browser, entry, layer), images.picture(kind));
            CHECK(found.colors > 10);
            CHECK(found.largest <= 1); // values are stored in steps: where a colour is rounded, that may turn the scale
        }
    }
    CHECK(browser.complaints() == std::vector<std::string>{});
}

TEST_CASE("browser: the read-out tells FLIP where it is shown, and the bar its range", "[browser]") {
    const std::string program = chromium_path();
    if (program.empty()) return;
    Browser browser(program);
    browser.open(rendered_folder() + "/report.html", page_ready);
    const Compared images("sm");
    const Image<float> flip = images.flip();
    int column = 0, row = 0; // the pixel left of the border where the difference is most visible
    double expected = 0.0;
    for (int y = 0; y < 180; ++y)
        for (int x = 0; x < 155; ++x)
            if (double{flip(x, y)} > expected) column = x, row = 179 - y, expected = double{flip(x, y)};
    REQUIRE(expected > 0.3);
    const Panel panel(browser);
    const Point at = panel.of(column, row);
    const auto flip_shown = [&] {
        const std::string line = read_out(browser, pixel_name(column, row))["shadow map"];
        const size_t word = line.find("FLIP ");
        return word == std::string::npos ? -1.0 : std::stod(line.substr(word + 5));
    };
    browser.move(at.x, at.y);
    CHECK(flip_shown() == -1.0);
    and_wait(browser, [&] { press_letter(browser, 'p'); });
    CHECK(std::abs(flip_shown() - expected) < 0.5 / flip_levels + 0.0005 + 1e-6);
    CHECK(texts(browser, "#legend .ends span") == json{"0", "0.5", "1"});
    CHECK(browser.evaluate("document.getElementById('range-field').hidden") == true);
    const vec3 color = images.picture(ErrorMapKind::Flip)(column, 179 - row);
    const std::array<int, 3> shown = color_at(browser, panel, at);
    for (int c = 0; c < 3; ++c) CHECK(std::abs(shown[static_cast<size_t>(c)] - std::lround(color[c] * 255.0f)) <= 1);

    // Flipping past the reference keeps the map, which is black there; false colours have a range to choose.
    and_wait(browser, [&] { browser.key("1", "Digit1", '1'); });
    CHECK(color_at(browser, panel, at) == std::array<int, 3>{0, 0, 4});
    and_wait(browser, [&] { press_letter(browser, 'c'); });
    CHECK(browser.evaluate("document.getElementById('range-field').hidden") == true); // both sides are the reference
    and_wait(browser, [&] { browser.key("2", "Digit2", '2'); });
    and_wait(browser, [&] { press_letter(browser, 'c'); });
    CHECK(browser.evaluate("document.getElementById('range-field').hidden") == false);
    CHECK(texts(browser, "#legend .ends span")[0] == "0");
    CHECK(browser.complaints() == std::vector<std::string>{});
}

TEST_CASE("browser: leaks are judged and explained by the thresholds of the metrics", "[browser]") {
    const std::string program = chromium_path();
    if (program.empty()) return;
    Browser browser(program);
    browser.open(rendered_folder() + "/report.html", page_ready);
    CHECK(texts(browser, "#leak-above") == json{"0.05"});
    CHECK(texts(browser, "#false-shadow-below") == json{"0.95"});
    const json counted = browser.evaluate(
        "(async () => { const [values, truth] = await compared(entries[1]), t = report.thresholds; "
        "return [...values.keys()].filter(i => truth[i] <= t.umbra_up_to && values[i] > t.leak_above || "
        "truth[i] >= t.lit_from && values[i] < t.false_shadow_below).length; })()");
    const Compared images("sm");
    const Image<float> wrong = error_values(ErrorMapKind::Overlay, images.test, images.reference);
    const auto expected = std::count_if(wrong.values().begin(), wrong.values().end(), [](float v) { return v != 0; });
    CHECK(expected > 0);
    CHECK(counted == expected);
    CHECK(browser.complaints() == std::vector<std::string>{});
}
