#include "tests/eval/report_page.h"

#include <catch2/catch.hpp>

#include "tests/support.h"

namespace gnomon_tests {

using nlohmann::json;

const std::string page_ready = "document.documentElement.dataset.ready === 'yes'";

const std::string& rendered_folder() {
    static const std::string folder = [] {
        const std::string made = temporary_folder();
        const auto run = run_gnomon({"render", "builtin:fence", "-t", "sm", "-t", "pcf:size=512", "-t", "pcf",
                                     "--reference", "truth:samples=64", "--size", "320x180", "-o", made + "/",
                                     "--report", made + "/report.html", "--quiet"});
        REQUIRE(run.errors == "");
        REQUIRE(run.exit_code == 0);
        return made;
    }();
    return folder;
}

Point middle_of(Browser& browser, const std::string& selector) {
    const json box =
        browser.evaluate("(() => { const e = document.querySelector(" + json(selector).dump() +
                         "); e.scrollIntoView({behavior: 'instant', block: 'center'}); const b = "
                         "e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()");
    return {box[0], box[1]};
}

void click_on(Browser& browser, const std::string& selector) {
    const Point at = middle_of(browser, selector);
    browser.click(at.x, at.y);
}

void press_letter(Browser& browser, char letter) {
    const int upper = letter - 'a' + 'A';
    browser.key(std::string(1, letter), std::string("Key") + static_cast<char>(upper), upper);
}

Panel::Panel(Browser& browser) {
    middle_of(browser, "#view");
    const json box = browser.evaluate("(() => { const b = document.getElementById('view').getBoundingClientRect(); "
                                      "return [b.x, b.y, b.width, b.height]; })()");
    x = box[0], y = box[1], width = box[2], height = box[3];
    scale = std::min(width / 320.0, height / 180.0);
}

std::array<int, 3> color_at(Browser& browser, const Panel& panel, Point at) {
    const json color = browser.evaluate("(() => { const copy = new OffscreenCanvas(1, 1).getContext('2d'); "
                                        "copy.drawImage(document.getElementById('view'), " +
                                        std::to_string(static_cast<int>(at.x - panel.x)) + ", " +
                                        std::to_string(static_cast<int>(at.y - panel.y)) +
                                        ", 1, 1, 0, 0, 1, 1); return [...copy.getImageData(0, 0, 1, 1).data]; })()");
    return {color[0], color[1], color[2]};
}

json read_out(Browser& browser, const std::string& pixel) {
    browser.wait_for("document.querySelector('#readout dd').textContent === " + json(pixel).dump());
    return browser.evaluate("Object.fromEntries([...document.querySelectorAll('#readout div')].map(row => "
                            "[row.children[0].textContent, row.children[1].textContent]))");
}

std::string pixel_name(int column, int row) { return std::to_string(column) + ", " + std::to_string(row); }

json texts(Browser& browser, const std::string& selector) {
    return browser.evaluate("[...document.querySelectorAll(" + json(selector).dump() +
                            ")].map(one => one.textContent)");
}

} // namespace gnomon_tests
