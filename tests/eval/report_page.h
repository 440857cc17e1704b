#pragma once
// What tests of the report's page share: a report of a small scene, and a reader's eyes and hands on it.

#include <algorithm>
#include <array>
#include <string>

#include "tests/eval/browser.h"

namespace gnomon_tests {

// True once the page has drawn everything.
extern const std::string page_ready;

// Four techniques of a small scene (320 x 180) with their EXR files and report.html, rendered once for all tests of
// this process: the truth, `sm`, and `pcf` with 512 texels and with 1024 (pcf-2.exr).
const std::string& rendered_folder();

// In CSS pixels of the window.
struct Point {
    double x, y;
};

// Where an element's middle is, after it has been brought into the window.
Point middle_of(Browser& browser, const std::string& selector);
void click_on(Browser& browser, const std::string& selector);

// Does something that changes the images, and waits until they are there.
template <class Act> void and_wait(Browser& browser, const Act& act) {
    const nlohmann::json before = browser.evaluate("document.getElementById('stage').dataset.shown");
    act();
    browser.wait_for("document.getElementById('stage').dataset.shown !== " + before.dump());
}

// Presses a letter's key.
void press_letter(Browser& browser, char letter);

// The canvas on the page, and the image of 320 x 180 that it shows fitted into it.
struct Panel {
    double x, y, width, height, scale;

    explicit Panel(Browser& browser);
    // The middle of an image pixel, counted from the top left.
    Point of(int column, int row) const {
        return {x + width / 2 + (column + 0.5 - 160.0) * scale, y + height / 2 + (row + 0.5 - 90.0) * scale};
    }
};

// What the panel is painted at a point of the window: red, green, blue, of 255.
std::array<int, 3> color_at(Browser& browser, const Panel& panel, Point at);

// The lines of the read-out for the pixel that it is waited for: {name: text}.
nlohmann::json read_out(Browser& browser, const std::string& pixel);
std::string pixel_name(int column, int row); // as the read-out writes it

// The texts of all elements that match.
nlohmann::json texts(Browser& browser, const std::string& selector);

} // namespace gnomon_tests
