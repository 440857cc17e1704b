// The report as its readers meet it: a page from disk in headless Chromium, with mouse and keyboard.

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include "core/atomic_file.h"
#include "core/image_file.h"
#include "eval/report/report.h"
#include "tests/eval/report_page.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;
using nlohmann::json;

TEST_CASE("browser: a report loads from disk without complaint and reads out the values of the EXR files",
          "[browser]") {
    const std::string program = chromium_path();
    if (program.empty()) return;
    Browser browser(program);
    browser.open(rendered_folder() + "/report.html", page_ready);
    const Image<float> truth = read_image(rendered_folder() + "/truth.exr").find("V")->values;
    const char* files[] = {"truth", "sm", "pcf", "pcf-2"};
    const json names =
        browser.evaluate("[...document.querySelectorAll('#chips button')].map(chip => chip.lastChild.textContent)");
    REQUIRE(names.size() == 4);
    CHECK(names[2] == "percentage-closer filtering (size 512)");
    const std::pair<int, int> places[] = {{40, 121}, {97, 150}, {3, 88}, {155, 140}};
    const Panel panel(browser);
    for (int technique = 1; technique < 4; ++technique) {
        const std::string digit = std::to_string(technique + 1);
        and_wait(browser, [&] { browser.key(digit, "Digit" + digit, '1' + technique); });
        const Image<float> values = read_image(rendered_folder() + "/" + files[technique] + ".exr").find("V")->values;
        for (const auto& [column, row] : places) {
            const Point at = panel.of(column, row);
            browser.move(at.x, at.y);
            const json lines = read_out(browser, pixel_name(column, row));
            const double value = values(column, 179 - row), reference = truth(column, 179 - row);
            INFO(files[technique] << " at " << column << ", " << row << ": " << lines.dump());
            const std::string name = names[static_cast<size_t>(technique)], truth_name = names[0];
            CHECK(std::abs(std::stod(lines[name].get<std::string>()) - value) < 0.51 / 64512 + 0.6e-5);
            CHECK(std::abs(std::stod(lines[truth_name].get<std::string>()) - reference) < 0.51 / 64512 + 0.6e-5);
            // What is painted there: the left image, as it stands left of the border.
            const int painted = color_at(browser, panel, at)[0];
            CHECK(painted == std::lround(value * 255.0));
        }
    }
    CHECK(browser.complaints() == std::vector<std::string>{});
}

TEST_CASE("browser: the table sorts by the column that is clicked and marks best and worst", "[browser]") {
    const std::string program = chromium_path();
    if (program.empty()) return;
    Browser browser(program);
    browser.open(rendered_folder() + "/report.html", page_ready);
    const json titles = texts(browser, ".results thead th");
    const auto column = std::find(titles.begin(), titles.end(), "RMSE") - titles.begin() + 1;
    REQUIRE(static_cast<size_t>(column) <= titles.size());
    const std::string head = ".results thead th:nth-child(" + std::to_string(column) + ")",
                      cells = ".results tbody tr:not(.reference) td:nth-child(" + std::to_string(column) + ")";
    const auto values = [&] {
        std::vector<double> found;
        for (const json& text : texts(browser, cells + " > span")) found.push_back(std::stod(text.get<std::string>()));
        return found;
    };
    REQUIRE(values().size() == 3);
    click_on(browser, head + " button");
    CHECK(browser.evaluate("document.querySelector('" + head + "').getAttribute('aria-sort')") == "ascending");
    const std::vector<double> up = values();
    CHECK(std::is_sorted(up.begin(), up.end()));
    CHECK(up.front() < up.back());
    CHECK(std::stod(texts(browser, cells + ".best > span")[0].get<std::string>()) == up.front());
    CHECK(std::stod(texts(browser, cells + ".worst > span")[0].get<std::string>()) == up.back());
    // The focus stays where it was, so that Enter turns the order round.
    browser.key("Enter", "Enter", 13);
    CHECK(browser.evaluate("document.querySelector('" + head + "').getAttribute('aria-sort')") == "descending");
    CHECK(values() == std::vector<double>(up.rbegin(), up.rend()));
    CHECK(browser.evaluate("document.querySelector('.results tbody tr:last-child').className") == "reference");
    CHECK(browser.complaints() == std::vector<std::string>{});
}

TEST_CASE("browser: images wipe, zoom about the pointer and pan", "[browser]") {
    const std::string program = chromium_path();
    if (program.empty()) return;
    Browser browser(program);
    browser.open(rendered_folder() + "/report.html", page_ready);
    const Panel panel(browser);
    const Image<float> left = read_image(rendered_folder() + "/sm.exr").find("V")->values,
                       right = read_image(rendered_folder() + "/truth.exr").find("V")->values;
    const int column = 130, row = 150;
    const long left_gray = std::lround(left(column, 179 - row) * 255.0f),
               right_gray = std::lround(right(column, 179 - row) * 255.0f);
    REQUIRE(left_gray != right_gray);
    const Point at = panel.of(column, row);
    const auto painted = [&] { return color_at(browser, panel, at)[0]; };
    const auto border = [&] {
        return std::stod(
            browser.evaluate("document.getElementById('wipe').getAttribute('aria-valuenow')").get<std::string>());
    };
    CHECK(painted() == left_gray);
    const Point handle = middle_of(browser, "#wipe");
    browser.move(handle.x, handle.y), browser.press(handle.x, handle.y);
    browser.move(panel.x + panel.width * 0.25, handle.y), browser.release(panel.x + panel.width * 0.25, handle.y);
    CHECK(border() == Approx(25).margin(1));
    CHECK(painted() == right_gray);
    browser.evaluate("document.getElementById('wipe').focus()");
    browser.key("End", "End", 35);
    CHECK(border() == 100);
    CHECK(painted() == left_gray);

    // Under the pointer stays what was there; elsewhere things move apart.
    browser.move(at.x, at.y);
    read_out(browser, pixel_name(column, row));
    browser.wheel(at.x, at.y, -400);
    browser.move(at.x + 0.3 * panel.scale, at.y);
    read_out(browser, pixel_name(column, row));
    const double zoom = std::exp(400 * 0.0016);
    browser.move(at.x + 10.2 * panel.scale * zoom, at.y);
    read_out(browser, pixel_name(column + 10, row));

    // Dragging moves the image with the pointer.
    browser.move(at.x, at.y), browser.press(at.x, at.y);
    browser.move(at.x + 60, at.y - 30), browser.release(at.x + 60, at.y - 30);
    read_out(browser, pixel_name(column, row));
    browser.key("f", "KeyF", 'F');
    browser.move(at.x, at.y + 0.1);
    read_out(browser, pixel_name(column, row));

    // Side by side, both halves show one place.
    and_wait(browser, [&] { browser.key("w", "KeyW", 'W'); });
    const Panel halves(browser);
    browser.move(halves.x + halves.width / 4, halves.y + halves.height / 2);
    read_out(browser, "160, 90");
    browser.move(halves.x + halves.width * 3 / 4, halves.y + halves.height / 2 + 0.1);
    read_out(browser, "160, 90");
    CHECK(browser.complaints() == std::vector<std::string>{});
}

TEST_CASE("browser: a report works with the keyboard alone and shows where the focus is", "[browser]") {
    const std::string program = chromium_path();
    if (program.empty()) return;
    Browser browser(program);
    browser.open(rendered_folder() + "/report.html", page_ready);
    std::vector<std::string> seen;
    for (int i = 0; i < 150; ++i) {
        browser.key("Tab", "Tab", 9);
        const json now = browser.evaluate(
            "(() => { const e = document.activeElement, s = getComputedStyle(e), a = getComputedStyle(e, '::after'); "
            "const outlined = one => one.outlineStyle !== 'none' && parseFloat(one.outlineWidth) >= 2; "
            "return [e === document.body ? 'end' : e.id || e.closest('[id]')?.id || e.className, outlined(s) || "
            "outlined(a) || "
            "(e.matches('.dot') && parseFloat(s.strokeWidth) >= 2), "
            "e.getAttribute('aria-label') || e.textContent || e.labels?.[0]?.textContent || '']; })()");
        if (now[0] == "end") break;
        INFO("on " << now.dump());
        CHECK(now[1] == true);
        CHECK(now[2] != "");
        if (seen.empty() || seen.back() != now[0]) seen.push_back(now[0]);
    }
    // In the order of the page.
    size_t after = 0;
    for (const char* id : {"theme", "layers", "modes", "zoom-out", "chips", "view", "left-entry", "right-entry", "wipe",
                           "errors", "cost", "cards", "commands"}) {
        INFO(id);
        const auto found = std::find(seen.begin() + static_cast<std::ptrdiff_t>(after), seen.end(), id);
        REQUIRE(found != seen.end());
        after = static_cast<size_t>(found - seen.begin());
    }

    // The read-out moves by single pixels.
    browser.evaluate("document.getElementById('view').focus()");
    browser.key("ArrowRight", "ArrowRight", 39, 8);
    read_out(browser, "160, 90");
    browser.key("ArrowRight", "ArrowRight", 39, 8);
    browser.key("ArrowDown", "ArrowDown", 40, 8);
    const json lines = read_out(browser, "161, 91");
    const Image<float> values = read_image(rendered_folder() + "/sm.exr").find("V")->values;
    CHECK(std::abs(std::stod(lines["shadow map"].get<std::string>()) - double{values(161, 179 - 91)}) <
          0.51 / 64512 + 0.6e-5);

    // Every layer has its key, and the digits flip in place.
    const std::pair<char, std::string> layers[] = {{'e', "Signed error"}, {'m', "Magnitude"}, {'c', "False colours"},
                                                   {'p', "FLIP"},         {'l', "Leaks"},     {'s', "Shaded"},
                                                   {'v', "Visibility"}};
    for (const auto& layer : layers) {
        and_wait(browser, [&] { press_letter(browser, layer.first); });
        CHECK(browser.evaluate("document.getElementById('left-layer').selectedOptions[0].textContent") == layer.second);
    }
    and_wait(browser, [&] { browser.key("4", "Digit4", '4'); });
    CHECK(browser.evaluate("document.getElementById('chips').children[3].getAttribute('aria-pressed')") == "true");
    CHECK(read_out(browser, "161, 91").contains("percentage-closer filtering (size 1024)"));

    // In a plot arrows go from point to point, and Enter opens the image of one.
    browser.evaluate("document.querySelector('.plot .dot[tabindex=\"0\"]').focus()");
    const json first = browser.evaluate("document.activeElement.getAttribute('aria-label')");
    browser.key("ArrowRight", "ArrowRight", 39);
    CHECK(browser.evaluate("document.activeElement.getAttribute('aria-label')") != first);
    and_wait(browser, [&] { browser.key("Enter", "Enter", 13); });
    CHECK(browser.evaluate("document.activeElement.id") == "view");
    CHECK(browser.complaints() == std::vector<std::string>{});
}

namespace {

// The least contrast [WCAG 2.1, 1.4.3] of a kind of text on what it stands on.
double contrast(Browser& browser, const std::string& text, const std::string& ground) {
    return browser.evaluate("(() => { const style = getComputedStyle(document.documentElement); "
                            "const luminance = name => { const probe = document.createElement('i'); probe.style.color "
                            "= style.getPropertyValue(name); document.body.append(probe); "
                            "const rgb = getComputedStyle(probe).color.match(/[\\d.]+/g).slice(0, 3).map(v => v / "
                            "255).map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); probe.remove(); "
                            "return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }; "
                            "const [a, b] = [luminance('" +
                            text + "'), luminance('" + ground +
                            "')].sort((x, y) => y - x); return (a + 0.05) / (b + 0.05); })()");
}

// A4 across less its margins, at 96 dots an inch.
constexpr int paper_width = 1032;

double rightmost(Browser& browser) {
    return browser.evaluate("Math.max(...[...document.querySelectorAll('table, svg, canvas, figure')].map(one => "
                            "one.getBoundingClientRect().right))");
}

void check_contrasts(Browser& browser) {
    for (const char* text : {"--ink", "--soft", "--faint", "--accent", "--good", "--bad"})
        for (const char* ground : {"--paper", "--surface", "--raised"}) {
            INFO(text << " on " << ground);
            CHECK(contrast(browser, text, ground) >= 4.5);
        }
    for (int series = 0; series < 8; ++series) {
        INFO("series " << series);
        CHECK(contrast(browser, "--s" + std::to_string(series), "--surface") >= 3.0); // [WCAG 2.1, 1.4.11]
    }
}

} // namespace

TEST_CASE("browser: a report is readable in light, in dark and on paper", "[browser]") {
    const std::string program = chromium_path();
    if (program.empty()) return;
    Browser browser(program);
    browser.emulate("screen", "light");
    browser.open(rendered_folder() + "/report.html", page_ready);
    const std::string ground = "getComputedStyle(document.body).backgroundColor";
    CHECK(browser.evaluate(ground) == "rgb(246, 245, 242)");
    check_contrasts(browser);
    browser.emulate("screen", "dark");
    browser.wait_for("document.documentElement.dataset.theme === 'dark'");
    CHECK(browser.evaluate(ground) == "rgb(18, 19, 22)");
    check_contrasts(browser);
    click_on(browser, "#theme"); // the reader's choice stands above the system's
    CHECK(browser.evaluate("document.documentElement.dataset.theme") == "light");
    click_on(browser, "#theme");

    // Paper is white and has no buttons, and nothing is wider than it.
    browser.emulate("print", "dark");
    browser.resize(paper_width, 720);
    CHECK(browser.evaluate(ground) == "rgb(255, 255, 255)");
    check_contrasts(browser);
    for (const char* gone : {".top", ".toolbar", "#chips", ".skip"})
        CHECK(browser.evaluate(std::string("getComputedStyle(document.querySelector('") + gone + "')).display") ==
              "none");
    CHECK(rightmost(browser) <= paper_width + 0.5);
    const std::string pdf = browser.print();
    CHECK(pdf.rfind("%PDF-", 0) == 0);
    browser.emulate("screen", "light");
    browser.resize(1440, 900);
    const std::string folder = temporary_folder();
    write_text_file(folder + "/report.png", browser.screenshot());
    const ChannelImage picture = read_image(folder + "/report.png");
    CHECK(picture.width == 1440);
    CHECK(picture.height == 900);
    CHECK(browser.complaints() == std::vector<std::string>{});
}

TEST_CASE("browser: a table of many metrics fits on paper", "[browser]") {
    const std::string program = chromium_path();
    if (program.empty()) return;
    ReportData data;
    data.views.resize(1);
    for (int i = 0; i < 3; ++i) {
        ReportEntry entry;
        entry.id = std::to_string(i), entry.title = "percentage-closer filtering with a long name " + entry.id;
        for (int metric = 0; metric < 24; ++metric)
            entry.visibility_metrics.emplace_back("penumbra_width_error_" + std::to_string(metric), 0.125 * i);
        data.entries.push_back(entry);
    }
    const std::string page = temporary_folder() + "/report.html";
    write_report(page, data);
    Browser browser(program);
    browser.emulate("print", "light");
    browser.resize(paper_width, 720);
    browser.open(page, page_ready);
    CHECK(browser.evaluate("document.querySelectorAll('.results thead th').length") == 25);
    CHECK(rightmost(browser) <= paper_width + 0.5);
    CHECK(browser.evaluate("Math.max(...[...document.querySelectorAll('.results td')].map(one => one.scrollWidth - "
                           "one.clientWidth))") == 0);
    CHECK(browser.complaints() == std::vector<std::string>{});
}

TEST_CASE("browser: names are text, whatever they hold, and missing values are shown as missing", "[browser]") {
    const std::string program = chromium_path();
    if (program.empty()) return;
    const std::string hostile =
        "</script><img src=x onerror='window.broken = 1'>{{data}}<b>&amp;\"'`${window.broken = 1}";
    ReportData data;
    data.title = hostile;
    data.facts = {{hostile, hostile}};
    data.command_lines = {hostile}, data.notes = {hostile}, data.blocks = {hostile};
    data.views = {{hostile, hostile, hostile, "320x180", hostile, {}}, {"b", "", "", "320x180", "", {}}};
    for (const bool is_reference : {false, true}) {
        ReportEntry entry;
        entry.is_reference = is_reference;
        entry.id = entry.title = entry.kind = entry.paper = entry.message = hostile;
        entry.parameters = {{hostile, hostile}}, entry.varied = {{hostile, 5}};
        entry.visibility = Image<float>(320, 180, is_reference ? 0.5f : 1.25f);
        entry.visibility(160, 89) = std::nanf("");
        entry.title += is_reference ? " reference" : "";
        entry.passes = {{{"name", hostile}, {"draws", 2}, {"texels_fetched", 7}, {hostile, hostile}}};
        entry.links = {"javascript:window.broken = 1", "../a b#c?d%41.exr"};
        entry.visibility_metrics = {{"rmse", 0.5}, {hostile, 2.0}};
        data.entries.push_back(entry);
    }
    data.entries.push_back(data.entries[0]);
    data.entries[2].visibility_metrics = {{"rmse", 0.25}};
    const std::string folder = temporary_folder();
    for (const auto kind : {ReportData::Kind::Render, ReportData::Kind::Study}) {
        data.kind = kind;
        write_report(folder + "/report.html", data);
        Browser browser(program);
        browser.open(folder + "/report.html", page_ready);
        CHECK(browser.evaluate("typeof window.broken") == "undefined");
        CHECK(browser.evaluate("document.querySelectorAll('img').length") == 0);
        CHECK(browser.evaluate("document.getElementById('title').textContent") == hostile);
        const json links = browser.evaluate("[...document.querySelectorAll('.links a')].map(link => link.href)");
        CHECK(links[0] == "file://" + folder + "/javascript%3Awindow.broken%20%3D%201");
        CHECK(links[1] == "file://" + std::filesystem::path(folder).parent_path().string() + "/a%20b%23c%3Fd%2541.exr");
        const Panel panel(browser);
        const Point missing = panel.of(160, 90), above = panel.of(20, 20);
        browser.move(missing.x - panel.scale / 4, missing.y);
        CHECK(read_out(browser, "160, 90").dump().find("missing (NaN)") != std::string::npos);
        browser.move(above.x, above.y);
        CHECK(read_out(browser, "20, 20").dump().find("1.25000  +0.75000") != std::string::npos);
        CHECK(browser.complaints() == std::vector<std::string>{});
    }
}

TEST_CASE("browser: the picture of a report in the documentation", "[.report-image]") {
    // bin/demo makes the page; gnomon-tests "[.report-image]" the picture of it.
    const std::string page = GNOMON_SOURCE "/out/demo/report.html", program = chromium_path();
    if (program.empty()) return;
    REQUIRE(std::filesystem::exists(page));
    Browser browser(program);
    browser.emulate("screen", "light");
    browser.resize(1440, 1500);
    browser.open(page, page_ready);
    and_wait(browser, [&] {
        browser.evaluate("[...document.querySelectorAll('#chips button')].find(chip => chip.lastChild.textContent === "
                         "'percentage-closer soft shadows').click()");
    });
    browser.evaluate("window.scrollTo({top: 0, behavior: 'instant'})");
    const double bottom = // after the third row of the table
        browser.evaluate("document.querySelector('.results tbody tr:nth-child(3)').getBoundingClientRect().bottom");
    browser.resize(1440, static_cast<int>(bottom));
    const double top = browser.evaluate("document.getElementById('view').getBoundingClientRect().y");
    browser.move(860, top + 470);
    browser.wait_for("document.querySelector('#readout dd').textContent !== '–'");
    write_text_file(GNOMON_SOURCE "/docs/images/report.png", browser.screenshot());
}
