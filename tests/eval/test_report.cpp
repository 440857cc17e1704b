#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/image_file.h"
#include "core/parallel.h"
#include "core/random.h"
#include "eval/report/embed.h"
#include "eval/report/report.h"
#include "tests/eval/base64.h"
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
    data.title = "A test & more";
    data.facts = {{"Scene", "builtin:room"}};
    data.command_lines = {"gnomon render builtin:room -t pcf"};
    data.views = {{"builtin:room", "front", "lamp", "32x18", "", Image<std::uint8_t>(32, 18, 1)}};
    data.entries = {sample_entry("pcf", 0.25f), sample_entry("truth", 0.5f)};
    data.entries[1].is_reference = true;
    return data;
}

nlohmann::json embedded(const std::string& page) {
    const std::string mark = "<script type=\"application/json\" id=\"report\">";
    const size_t begin = page.find(mark) + mark.size();
    return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

ChannelImage decoded_image(const std::string& base64) {
    const std::string path = gnomon_tests::temporary_folder() + "/embedded.png";
    write_text_file(path, gnomon_tests::decoded_base64(base64));
    return read_image(path);
}

} // namespace

TEST_CASE("a report holds what it was given") {
    const nlohmann::json data = embedded(report_page(sample_report()));
    CHECK(data["title"] == "A test & more");
    CHECK(data["facts"][0] == nlohmann::json{"Scene", "builtin:room"});
    REQUIRE(data["views"].size() == 1);
    CHECK(data["views"][0]["scene"] == "builtin:room");
    CHECK(data["views"][0]["reference"] == 1);
    CHECK(data["views"][0]["width"] == 32);
    CHECK(data["views"][0]["height"] == 18);
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
    data.views[0].scene = "</script><script>alert(2)</script> {{style}}";
    data.entries[1].message = "</script><script>alert(3)</script>";
    data.entries[0].title = "\xff\xfe not UTF-8";
    const std::string page = report_page(data);
    CHECK(page.find("alert(1)</script>") == std::string::npos);
    CHECK(page.find("alert(2)</script>") == std::string::npos);
    CHECK(page.find("alert(3)</script>") == std::string::npos);
    CHECK(embedded(page)["title"] == data.title);
    CHECK(embedded(page)["views"][0]["scene"] == data.views[0].scene);
}

namespace {

// The code of pixel x, y counted from the bottom.
struct Codes {
    explicit Codes(const nlohmann::json& entry) : planes(decoded_image(entry["visibility"])) {
        low = entry["range"][0], high = entry["range"][1], levels = entry["levels"];
    }
    int operator()(int x, int y) const {
        const Image<float>& bytes = planes.channels[0].values;
        return static_cast<int>(std::lround(bytes(x, y + planes.height / 2) * 255.0f) * 256 +
                                std::lround(bytes(x, y) * 255.0f));
    }
    double value(int x, int y) const { return low + (*this)(x, y) * (high - low) / levels; }
    ChannelImage planes;
    double low, high;
    int levels;
};

} // namespace

TEST_CASE("embedded visibility is exact to its steps") {
    ReportData data = sample_report();
    Image<float>& visibility = data.entries[0].visibility;
    for (size_t i = 0; i < visibility.size(); ++i)
        visibility.values()[i] = static_cast<float>(i) / static_cast<float>(visibility.size() - 1);
    visibility(3, 4) = std::nanf("");
    visibility(4, 4) = infinity;
    visibility(5, 4) = -infinity;
    visibility(6, 4) = 1023.0f / 1024.0f;
    const Codes code(embedded(report_page(data))["entries"][0]);
    REQUIRE(code.planes.width == 32);
    REQUIRE(code.planes.height == 36);
    CHECK(code.low == 0.0);
    CHECK(code.high == 1.0);
    CHECK(code.levels == finest_levels);
    for (int y = 0; y < 18; ++y)
        for (int x = 0; x < 32; ++x)
            if (y != 4) CHECK(std::abs(code.value(x, y) - double{visibility(x, y)}) < 0.5001 / finest_levels);
    CHECK(code(3, 4) == finest_levels + 3);
    CHECK(code(4, 4) == finest_levels + 2);
    CHECK(code(5, 4) == finest_levels + 1);
    CHECK(code.value(6, 4) == 1023.0 / 1024.0);
}

TEST_CASE("embedded visibility beyond 0 and 1 widens the range") {
    ReportData data = sample_report();
    Image<float>& visibility = data.entries[0].visibility;
    visibility(1, 1) = -0.5f;
    visibility(2, 1) = 1.75f;
    const Codes code(embedded(report_page(data))["entries"][0]);
    CHECK(code.low == -0.5);
    CHECK(code.high == 1.75);
    CHECK(code.value(1, 1) == -0.5);
    CHECK(code.value(2, 1) == 1.75);
    CHECK(std::abs(code.value(3, 3) - 0.25) < 0.5001 * 2.25 / finest_levels);
}

TEST_CASE("entries of one technique are told apart by what differs") {
    ReportData data = sample_report();
    data.entries.push_back(sample_entry("pcf", 0.75f));
    data.entries[2].parameters["size"] = 2048;
    name_differences(data);
    CHECK(data.entries[0].varied == nlohmann::ordered_json{{"size", 1024}});
    CHECK(data.entries[1].varied.empty());
    CHECK(data.entries[2].varied == nlohmann::ordered_json{{"size", 2048}});
}

TEST_CASE("the same data gives the same report, for any number of threads") {
    const std::string page = report_page(sample_report());
    for (const int threads : {1, 2, 7}) with_threads(threads, [&] { CHECK(report_page(sample_report()) == page); });
    const std::string path = gnomon_tests::temporary_folder() + "/report.html";
    write_report(path, sample_report());
    CHECK(read_file(path) == page);
}

TEST_CASE("a report needs images of one size in a view, and entries in one of its views") {
    ReportData data = sample_report();
    data.entries[1].visibility = Image<float>(31, 18);
    CHECK_THROWS_WITH(report_page(data),
                      "a report shows images of one size, but the visibility of 'truth' is 31x18 beside 32x18");
    data = sample_report();
    data.entries[0].view = 1;
    CHECK_THROWS_AS(report_page(data), UsageError);
    CHECK_THROWS_AS(write_report("/nowhere/report.html", sample_report()), InputError);
}

TEST_CASE("a report may lack images, a mask, a reference or entries") {
    ReportData data = sample_report();
    data.views[0].mask = {};
    data.entries[1].is_reference = false;
    data.entries[0].shaded = {};
    data.entries[1].visibility = {};
    const nlohmann::json json = embedded(report_page(data));
    CHECK(json["views"][0]["reference"] == -1);
    CHECK(json["views"][0]["mask"] == "");
    CHECK(json["entries"][0]["shaded"] == "");
    CHECK(embedded(report_page({}))["entries"].empty());
}

namespace {

// `count` techniques at 1280 x 720: a wide penumbra of 1024 rays on a textured ground, with `noise` in its place by
// that share, which no PNG can shorten.
ReportData large_report(int count, float noise) {
    ReportEntry entry = sample_entry("truth", 0.0f);
    entry.visibility = Image<float>(1280, 720);
    entry.shaded = Image<vec3>(1280, 720);
    for (int y = 0; y < 720; ++y)
        for (int x = 0; x < 1280; ++x) {
            const float u = static_cast<float>(x - 640) / 400.0f, v = static_cast<float>(y - 360) / 300.0f;
            const float smooth = std::min(std::max(std::hypot(u, v) - 0.3f, 0.0f), 1.0f);
            const float random = to_unit(hash(static_cast<std::uint32_t>(y * 1280 + x)));
            entry.visibility(x, y) = std::round((smooth * (1.0f - noise) + random * noise) * 1024.0f) / 1024.0f;
            const float ground = 0.5f + 0.1f * std::sin(u * 40.0f) * std::sin(v * 40.0f) + 0.3f * random * noise;
            entry.shaded(x, y) = vec3(ground, ground * 0.9f, ground * 0.8f) * (0.2f + 0.8f * entry.visibility(x, y));
        }
    ReportData data = sample_report();
    data.views[0].mask = {};
    data.entries.assign(static_cast<size_t>(count), entry);
    data.entries[0].is_reference = true;
    for (float& value : data.entries[0].visibility.values()) value *= value; // the others are all wrong, visibly
    return data;
}

} // namespace

TEST_CASE("twenty techniques at 1280 x 720 stay below 25 MiB with all that there is to say") {
    // Five of them, and their share.
    const std::string page = report_page(large_report(5, 0.0f));
    INFO((page.size() >> 10) << " KiB");
    CHECK(page.size() < (25u << 20) * 5 / 20);
    const nlohmann::json data = embedded(page);
    CHECK(data["notes"].empty());
    for (const nlohmann::json& entry : data["entries"]) {
        CHECK(entry["levels"] == finest_levels);
        CHECK((entry["flip"] == "") == (entry == data["entries"][0]));
    }
}

TEST_CASE("nothing but noise stays within the budget too, and the page says what it left out") {
    // Three of twenty techniques, and their share.
    ReportData data = large_report(3, 1.0f);
    data.image_budget = data.image_budget * 3 / 20;
    const std::string page = report_page(data);
    INFO((page.size() >> 10) << " KiB");
    CHECK(page.size() < (25u << 20) * 3 / 20);
    CHECK_FALSE(embedded(page)["notes"].empty());
    CHECK(embedded(page)["entries"][0]["visibility"] != ""); // the reference stays
}

TEST_CASE("images that do not fit are made coarser, then left out by rank") {
    Image<float> noise(64, 64);
    for (size_t i = 0; i < noise.size(); ++i) noise.values()[i] = to_unit(hash(static_cast<std::uint32_t>(i)));
    std::vector<ImagesToEmbed> entries = {{nullptr, &noise, 2}, {nullptr, &noise, 0}, {nullptr, &noise, 1}};
    const EmbeddedSet all = embed_images(entries, size_t{1} << 20);
    CHECK(all.levels == finest_levels);
    CHECK(all.bytes == 3 * all.images[0].visibility.png.size());
    const EmbeddedSet coarse = embed_images(entries, all.bytes - 1);
    CHECK(coarse.levels == 4096);
    CHECK(coarse.left_out == 0);
    const EmbeddedSet few = embed_images(entries, 7000);
    CHECK(few.bytes <= 7000);
    CHECK(few.left_out == 2);
    CHECK(few.images[0].left_out);
    CHECK_FALSE(few.images[1].left_out);
    CHECK(embed_images(entries, 0).left_out == 3);

    // FLIP maps go first.
    entries[0].flip = &noise;
    const EmbeddedSet with_flip = embed_images(entries, size_t{1} << 20);
    CHECK(with_flip.flip);
    CHECK(with_flip.bytes == all.bytes + with_flip.images[0].flip.png.size());
    const EmbeddedSet without = embed_images(entries, with_flip.bytes - 1);
    CHECK_FALSE(without.flip);
    CHECK(without.images[0].flip.png.empty());
    CHECK(without.levels == finest_levels);
    CHECK(without.bytes == all.bytes);
}

TEST_CASE("an image made smaller is the mean of what it stands for") {
    Image<vec3> image(3, 2, vec3(0.0f));
    image(0, 0) = image(1, 0) = image(0, 1) = vec3(1.0f), image(2, 1) = vec3(1.0f);
    const ChannelImage half = decoded_image(embed_shaded(image, 2));
    REQUIRE(half.width == 2);
    REQUIRE(half.height == 1);
    CHECK(half.channels[0].values(0, 0) == Approx(191.0 / 255.0)); // 3/4, rounded
    CHECK(half.channels[0].values(1, 0) == Approx(128.0 / 255.0));
}
