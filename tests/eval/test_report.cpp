#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/image_file.h"
#include "core/parallel.h"
#include "eval/report/report.h"
#include "tests/support.h"

using namespace gnomon;

namespace {

ReportEntry sample_entry(const std::string& id, float visibility) {
    ReportEntry entry;
    entry.id = id, entry.title = "Technique " + id, entry.kind = "soft",
    entry.paper = "Someone 2001, On <shadows> & light";
    entry.parameters = {{"size", 1024}, {"filter", "gaussian"}};
    entry.shaded = Image<vec3>(32, 18, vec3(visibility));
    entry.visibility = Image<float>(32, 18, visibility);
    entry.passes = {{{"name", "depth map"}, {"draws", 2}, {"fragments_shaded", 12345}, {"seconds", 0.25}}};
    entry.seconds = 0.5, entry.peak_bytes = 4 << 20;
    entry.links = {id + ".exr"};
    entry.visibility_metrics = {{"rmse", 0.125}, {"psnr", static_cast<double>(infinity)}, {"leak", std::nan("")}};
    entry.shaded_metrics = {{"rmse", 0.0625}};
    return entry;
}

ReportData sample_report() {
    ReportData data;
    data.title = "A test & more", data.scene = "builtin:room", data.camera = "front", data.light = "lamp";
    data.command_lines = {"gnomon render builtin:room -t pcf"};
    data.reference_id = "truth";
    data.entries = {sample_entry("pcf", 0.25f), sample_entry("truth", 0.5f)};
    data.mask = Image<std::uint8_t>(32, 18, 1);
    return data;
}

nlohmann::json embedded(const std::string& page) {
    const std::string mark = "<script type=\"application/json\" id=\"report\">";
    const size_t begin = page.find(mark) + mark.size();
    return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

std::string decoded(const std::string& base64) {
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned bits = 0;
    int count = 0;
    for (const char letter : base64) {
        if (letter == '=') break;
        bits = bits << 6 | static_cast<unsigned>(letters.find(letter));
        if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255);
    }
    return bytes;
}

ChannelImage decoded_image(const std::string& base64) {
    const std::string path = gnomon_tests::temporary_folder() + "/embedded.png";
    write_text_file(path, decoded(base64));
    return read_image(path);
}

} // namespace

TEST_CASE("a report holds what it was given") {
    const nlohmann::json data = embedded(report_page(sample_report()));
    CHECK(data["title"] == "A test & more");
    CHECK(data["scene"] == "builtin:room");
    CHECK(data["reference"] == 1);
    CHECK(data["width"] == 32);
    CHECK(data["height"] == 18);
    CHECK(data["command_lines"][0] == "gnomon render builtin:room -t pcf");
    REQUIRE(data["entries"].size() == 2);
    const nlohmann::json& entry = data["entries"][0];
    CHECK(entry["id"] == "pcf");
    CHECK(entry["paper"] == "Someone 2001, On <shadows> & light");
    CHECK(entry["parameters"]["size"] == 1024);
    CHECK(entry["passes"][0]["fragments_shaded"] == 12345);
    CHECK(entry["seconds"] == 0.5);
    CHECK(entry["peak_bytes"] == 4 << 20);
    CHECK(entry["links"][0] == "pcf.exr");
    CHECK(entry["metrics"]["visibility"] ==
          nlohmann::json{{"rmse", 0.125}, {"psnr", "infinite"}}); // what is NaN is absent
    CHECK(entry["metrics"]["shaded"]["rmse"] == 0.0625);
    CHECK(data["metrics"][0]["id"] == "rmse");
    CHECK(data["metrics"][0]["lower_is_better"] == true);
}

TEST_CASE("a report loads nothing from outside") {
    const std::string page = report_page(sample_report());
    for (const char* word : {"http:", "https:", "//cdn", "@import", "fetch(", "XMLHttpRequest", "{{"}) {
        INFO(word);
        CHECK(page.find(word) == std::string::npos);
    }
    // Whatever an element names as its source is in the file; links are relative names of files.
    for (const std::string attribute : {" src=\"", " href=\""})
        for (size_t at = 0; (at = page.find(attribute, at)) != std::string::npos;) {
            at += attribute.size();
            CHECK((page.compare(at, 5, "data:") == 0 || page[at] == '#'));
        }
    CHECK(page.find("default-src 'none'") != std::string::npos);
    CHECK(page.rfind("<!doctype html>", 0) == 0);
}

TEST_CASE("no text can break out of the page") {
    ReportData data = sample_report();
    data.title = "{{data}} </title><script>alert(1)</script>";
    data.scene = "</script><script>alert(2)</script> {{style}}";
    data.entries[0].title = "\xff\xfe not UTF-8";
    const std::string page = report_page(data);
    CHECK(page.find("alert(1)</script>") == std::string::npos);
    CHECK(page.find("alert(2)</script>") == std::string::npos);
    CHECK(embedded(page)["title"] == data.title);
    CHECK(embedded(page)["scene"] == data.scene);
}

TEST_CASE("embedded visibility is exact to its steps") {
    ReportData data = sample_report();
    Image<float>& visibility = data.entries[0].visibility;
    for (size_t i = 0; i < visibility.size(); ++i)
        visibility.values()[i] = static_cast<float>(i) / static_cast<float>(visibility.size() - 1);
    visibility(3, 4) = std::nanf("");
    visibility(4, 4) = 1.5f;
    visibility(5, 4) = -0.5f;
    const ChannelImage planes = decoded_image(embedded(report_page(data))["entries"][0]["visibility"]);
    REQUIRE(planes.width == 32);
    REQUIRE(planes.height == 36);
    const Image<float>& codes = planes.channels[0].values;
    const auto code = [&](int x, int y) {
        return std::lround(codes(x, y + 18) * 255.0f) * 256 + std::lround(codes(x, y) * 255.0f);
    };
    for (int y = 0; y < 18; ++y)
        for (int x = 0; x < 32; ++x)
            if (y != 4)
                CHECK(std::abs(static_cast<double>(code(x, y)) / visibility_levels - double{visibility(x, y)}) <
                      0.5001 / visibility_levels);
    CHECK(code(3, 4) == visibility_levels + 1);
    CHECK(code(4, 4) == visibility_levels);
    CHECK(code(5, 4) == 0);
}

TEST_CASE("the same data gives the same report, for any number of threads") {
    const std::string page = report_page(sample_report());
    for (const int threads : {1, 2, 7}) with_threads(threads, [&] { CHECK(report_page(sample_report()) == page); });
    const std::string path = gnomon_tests::temporary_folder() + "/report.html";
    write_report(path, sample_report());
    CHECK(read_file(path) == page);
}

TEST_CASE("a report needs images of one size and a reference among its entries") {
    ReportData data = sample_report();
    data.entries[1].visibility = Image<float>(31, 18);
    CHECK_THROWS_WITH(report_page(data),
                      "a report shows images of one size, but the visibility of 'truth' is 31x18 beside 32x18");
    data = sample_report();
    data.reference_id = "thruth";
    CHECK_THROWS_AS(report_page(data), UsageError);
    CHECK_THROWS_AS(write_report("/nowhere/report.html", sample_report()), InputError);
}

TEST_CASE("a report may lack images, a mask, a reference or entries") {
    ReportData data = sample_report();
    data.mask = {};
    data.reference_id.clear();
    data.entries[0].shaded = {};
    data.entries[1].visibility = {};
    const nlohmann::json json = embedded(report_page(data));
    CHECK(json["reference"] == -1);
    CHECK(json["mask"] == "");
    CHECK(json["entries"][0]["shaded"] == "");
    CHECK(embedded(report_page({}))["entries"].empty());
}

TEST_CASE("twenty techniques at 1280 x 720 stay below 25 MiB") {
    // Two of them, and their share.
    ReportData data = sample_report();
    data.mask = {};
    data.entries.clear();
    for (int i = 0; i < 2; ++i) {
        ReportEntry entry = sample_entry(i == 0 ? std::string("truth") : std::to_string(i), 0.0f);
        entry.visibility = Image<float>(1280, 720);
        entry.shaded = Image<vec3>(1280, 720);
        for (int y = 0; y < 720; ++y)
            for (int x = 0; x < 1280; ++x) {
                // A wide penumbra of 1024 rays on a textured ground.
                const float u = static_cast<float>(x - 640) / 400.0f, v = static_cast<float>(y - 360) / 300.0f;
                const float smooth =
                    std::min(std::max(std::hypot(u, v) - 0.3f - 0.01f * static_cast<float>(i), 0.0f), 1.0f);
                entry.visibility(x, y) = std::round(smooth * 1024.0f) / 1024.0f;
                const float ground = 0.5f + 0.1f * std::sin(u * 40.0f) * std::sin(v * 40.0f);
                entry.shaded(x, y) =
                    vec3(ground, ground * 0.9f, ground * 0.8f) * (0.2f + 0.8f * entry.visibility(x, y));
            }
        data.entries.push_back(std::move(entry));
    }
    const std::string page = report_page(data);
    INFO((page.size() >> 20) << " MiB");
    CHECK(page.size() < (25u << 20) / 10);
}
