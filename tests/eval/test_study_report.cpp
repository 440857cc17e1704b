#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/image_file.h"
#include "eval/report/study_report.h"
#include "tests/eval/browser.h"
#include "tests/support.h"

using namespace gnomon;
using gnomon_tests::Browser;
using nlohmann::json;

namespace {

void write_visibility(const std::string& path, float value) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    ChannelImage image{64, 48, {}, {}};
    Image<float> visibility(64, 48, value);
    for (int x = 0; x < 64; ++x) visibility(x, 7) = static_cast<float>(x) / 64.0f;
    image.add("V", visibility);
    image.add("M", Image<float>(64, 48, 1.0f));
    write_exr(path, image);
}

json cell_json(const std::string& cell, const std::string& block, const std::string& scene,
               const std::string& technique, const json& varied, double rmse) {
    json parameters = {{"bias", 4}};
    parameters.update(varied);
    return {{"cell", cell},
            {"block", block},
            {"scene", scene},
            {"camera", "front"},
            {"light", "lamp"},
            {"size", "64x48"},
            {"technique", technique},
            {"parameters", parameters},
            {"varied", varied},
            {"reference",
             {{"technique", "truth"}, {"parameters", {{"samples", 1024}}}, {"file", "truths/" + scene + ".exr"}}},
            {"status", "ok"},
            {"message", ""},
            {"metrics", {{"rmse", rmse}, {"psnr", nullptr}, {"new_metric", 3.5}}},
            {"counters", {{"draws", 2}, {"texels_fetched", 1000}, {"fragments_covered", 5000}}},
            {"files", {{"visibility", "cells/" + cell + ".exr"}}}};
}

// Two scenes, three techniques (one without a shadow map), three sizes; a block of its own for the truth; a failed
// cell.
std::string sample_study() {
    const std::string folder = gnomon_tests::temporary_folder() + "/shadows";
    std::filesystem::create_directories(folder);
    std::string results, timings;
    int count = 0;
    const auto add = [&](const json& cell, float visibility) {
        results += cell.dump() + "\n";
        timings += json{{"cell", cell["cell"]}, {"seconds", 0.5 + count++}, {"peak_bytes", 4096}}.dump() + "\n";
        write_visibility(folder + "/" + cell["files"]["visibility"].get<std::string>(), visibility);
    };
    for (const std::string scene : {"fence", "hall"}) {
        write_visibility(folder + "/truths/" + scene + ".exr", 0.5f);
        for (const int size : {512, 1024, 2048})
            for (const std::string technique : {"sm", "pcf"})
                add(cell_json(scene + technique + std::to_string(size), "maps", scene, technique, {{"size", size}},
                              (technique == "sm" ? 100.0 : 50.0) / size),
                    technique == "sm" ? 0.75f : 0.625f);
        add(cell_json(scene + "sv", "maps", scene, "sv-zfail", json::object(), 0.125), 0.25f);
        for (const int samples : {4, 16, 64})
            add(cell_json(scene + "truth" + std::to_string(samples), "convergence", scene, "truth",
                          {{"samples", samples}}, 0.4 / std::sqrt(samples)),
                0.5f);
    }
    json failed = cell_json("bad", "maps", "fence", "sm", {{"size", 4096}}, 0.0);
    failed["status"] = "failed", failed["message"] = "out of memory", failed["files"] = json::object(),
    failed["metrics"] = json::object();
    write_text_file(folder + "/results.jsonl", results + failed.dump() + "\n");
    write_text_file(folder + "/timings.jsonl", timings);
    return folder;
}

void append(const std::string& folder, const std::string& text) {
    write_text_file(folder + "/results.jsonl", read_file(folder + "/results.jsonl") + text);
}

std::string complaint(const std::string& folder) {
    try {
        study_report(folder, folder + "/report.html");
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

} // namespace

TEST_CASE("a study's folder becomes blocks, views and entries") {
    const std::string folder = sample_study();
    StudyReportOptions options;
    options.describe = [](const std::string& id) {
        return TechniqueWords{"Title of " + id, "hard", "", {{"size", "texels"}}};
    };
    const ReportData data = study_report(folder, folder + "/../report.html", options);
    CHECK(data.title == "shadows");
    CHECK(data.blocks == std::vector<std::string>{"maps", "convergence"});
    REQUIRE(data.views.size() == 2);
    CHECK(data.views[1].scene == "hall");
    CHECK(data.views[0].mask.size() == 64 * 48);
    REQUIRE(data.entries.size() == 21 + 2);
    const ReportEntry& entry = data.entries[1];
    CHECK(entry.cell == "fencepcf512");
    CHECK(entry.title == "Title of pcf");
    CHECK(entry.varied == nlohmann::ordered_json{{"size", 512}});
    CHECK(entry.parameters["bias"] == 4);
    CHECK(entry.seconds == 1.5);
    CHECK(entry.peak_bytes == 4096);
    CHECK(entry.counters["texels_fetched"] == 1000);
    CHECK(entry.links == std::vector<std::string>{"shadows/cells/fencepcf512.exr"});
    CHECK(entry.visibility(10, 7) == 10.0f / 64.0f);
    CHECK(entry.visibility(10, 8) == 0.625f);
    CHECK(data.entries[20].status == "failed");
    CHECK(data.entries[20].message == "out of memory");
    CHECK(data.entries[21].is_reference);
    CHECK(data.entries[21].visibility(3, 3) == 0.5f);
    CHECK(data.parameter_units.at("size") == "texels");
    CHECK(data.links == std::vector<std::string>{"shadows/results.jsonl", "shadows/timings.jsonl"});
    CHECK(data.notes.empty());
    CHECK(report_page(data) == report_page(study_report(folder, folder + "/../report.html", options)));
}

TEST_CASE(
    "a study's report tells references apart, takes the last line about a cell and leaves out one without an end") {
    const std::string folder = sample_study();
    json again = cell_json("fencesm512", "maps", "fence", "sm", {{"size", 512}}, 0.0625);
    json shared = cell_json("fencesm512", "one size", "fence", "sm", {{"reference.samples", 1024}}, 0.0625);
    json other = cell_json("other", "maps", "fence", "sm", {{"size", 512}}, 0.5);
    other["reference"]["parameters"]["samples"] = 64, other["files"] = nullptr;
    append(folder, again.dump() + "\n\n" + other.dump() + "\n" + shared.dump() + "\n{\"cell\": \"half");
    const ReportData data = study_report(folder, folder + "/report.html");
    REQUIRE(data.entries.size() == 23 + 3);
    CHECK(data.entries[22].block == 2); // a row of its own, without a second copy of its cell's image
    CHECK(data.entries[22].varied.empty());
    CHECK(data.entries[22].seconds == 0.5);
    CHECK(data.entries[22].visibility.empty());
    CHECK(data.facts[0].second == "22, 1 of them failed");
    CHECK(data.entries[0].visibility_metrics[2] == std::pair<std::string, double>{"rmse", 0.0625});
    CHECK(data.entries[0].visibility_metrics[1].second ==
          static_cast<double>(infinity)); // null, as `compare --json` writes it
    REQUIRE(data.views.size() == 3);
    CHECK(data.views[0].truth == "truth samples 1024");
    CHECK(data.views[2].truth == "truth samples 64");
    CHECK(data.links[0] == "results.jsonl");
}

TEST_CASE(
    "a study's report shows as many images as its budget allows, each view's reference and techniques' best first") {
    const std::string folder = sample_study();
    StudyReportOptions options;
    options.image_budget = 64 * 48 * 5 / 3; // five images and what exceeds them
    const ReportData data = study_report(folder, folder + "/report.html", options);
    std::vector<std::string> shown;
    for (const ReportEntry& entry : data.entries)
        if (!entry.visibility.empty()) shown.push_back(entry.is_reference ? "reference" : entry.cell);
    CHECK(shown == std::vector<std::string>{"fencesm2048", "fencepcf2048", "hallsm2048", "hallpcf2048", "reference",
                                            "reference"});
    REQUIRE(data.notes.size() == 1);
    CHECK(data.notes[0].find("Images of 4 of 20 cells are on this page") == 0);
    options.image_budget = 0;
    for (const ReportEntry& entry : study_report(folder, folder + "/report.html", options).entries)
        CHECK(entry.visibility.empty());
}

TEST_CASE("a study's report does without images that are missing, broken or of another size") {
    const std::string folder = sample_study();
    std::filesystem::remove(folder + "/cells/fencesm512.exr");
    write_text_file(folder + "/cells/fencesm1024.exr", "no image");
    ChannelImage small{8, 8, {}, {}};
    small.add("V", Image<float>(8, 8));
    write_exr(folder + "/cells/fencesm2048.exr", small);
    const ReportData data = study_report(folder, folder + "/report.html");
    CHECK(data.entries[0].visibility.empty());
    REQUIRE(data.notes.size() == 2);
    CHECK(data.notes[1] == "3 images were missing, broken or of another size.");
}

TEST_CASE("a study's report names the file and the line that it cannot read") {
    CHECK(complaint("/nowhere").find("/nowhere/results.jsonl") != std::string::npos);
    const std::string folder = sample_study();
    const std::string good = read_file(folder + "/results.jsonl"), name = folder + "/results.jsonl:22";
    const auto with = [&](const json& line) {
        write_text_file(folder + "/results.jsonl", good + line.dump() + "\n");
        return complaint(folder);
    };
    json cell = cell_json("x", "maps", "fence", "sm", {{"size", 512}}, 0.5);
    CHECK(with(cell) == "");
    CHECK(with(7).find(name) == 0);
    CHECK(with({{"technique", "sm"}}).find(name) == 0);
    cell["status"] = "perhaps";
    CHECK(with(cell) == name + ": status must be 'ok' or 'failed'");
    cell["status"] = "ok";
    cell["metrics"]["rmse"] = "small";
    CHECK(with(cell) == name + ": metrics.rmse must be a number or null");
    cell["metrics"] = json::object();
    for (const char* outside : {"/etc/passwd", "../secret.exr", "cells/../../secret.exr"}) {
        cell["files"]["visibility"] = outside;
        CHECK(with(cell) == name + ": files.visibility must name a file inside the folder");
    }
    write_text_file(folder + "/results.jsonl", good + "{\"cell\": }\n");
    CHECK(complaint(folder).find(name) == 0);
}

TEST_CASE("study report writes the page of a folder") {
    const std::string folder = sample_study(), page = folder + "/report.html";
    const auto run = gnomon_tests::run_gnomon({"study", "report", folder, "-o", page, "--title", "All shadows"});
    CHECK(run.errors == "");
    CHECK(run.exit_code == 0);
    const std::string text = read_file(page);
    CHECK(text.find("<title>All shadows</title>") != std::string::npos);
    CHECK(text.find("percentage-closer filtering") != std::string::npos); // pcf's title
    CHECK(gnomon_tests::run_gnomon({"study", "report", folder, "-o", folder + "/report.txt"}).exit_code == 2);
    CHECK(gnomon_tests::run_gnomon({"study", "report", folder + "/none", "-o", page}).exit_code == 3);
    CHECK(gnomon_tests::run_gnomon({"study", "report", folder, "-o", "/nowhere/report.html"}).exit_code == 3);
}

TEST_CASE("browser: a study's report arranges its blocks as a paper's tables", "[browser]") {
    const std::string program = gnomon_tests::chromium_path();
    if (program.empty()) return;
    const std::string folder = sample_study(), page = folder + "/report.html";
    write_report(page, study_report(folder, page));
    Browser browser(program);
    browser.open(page, "document.documentElement.dataset.ready === 'yes'");
    const auto texts = [&](const std::string& selector) {
        return browser.evaluate("[...document.querySelectorAll(" + json(selector).dump() +
                                ")].map(one => one.textContent)");
    };
    CHECK(texts("h2").size() == 2 + 2 + 4); // images and techniques, cells and words, two blocks with plots
    CHECK(texts("#errors .over-columns") == json{"RMSE by size"});
    CHECK(texts("#errors thead tr:nth-child(2) button") == json{"512", "1024", "2048", "4096"});
    CHECK(texts("#errors .group") == json{"fence", "hall"});
    CHECK(texts("#errors tbody:nth-of-type(2) .name") == json{"sm", "pcf", "sv-zfail"});
    CHECK(texts("#errors tbody:nth-of-type(2) tr:nth-child(3) td > :first-child") ==
          json{"0.0977", "0.0488", "0.0244", "–"});
    CHECK(texts("#errors tbody:nth-of-type(1) .failed") == json{"failed"});
    CHECK(browser.evaluate("document.querySelector('#errors tbody tr:last-child td').colSpan") ==
          4); // depends on no size
    CHECK(texts("#errors-2 thead tr:nth-child(2) button") == json{"4", "16", "64"});
    CHECK(browser.evaluate("document.querySelectorAll('#cost svg[role=group]').length") == 4); // two plots of two views
    CHECK(browser.evaluate("document.querySelectorAll('#cost-2 .guide').length") == 2);
    CHECK(texts("#cells tbody tr").size() == 21);

    // By metrics and by views.
    const std::string choose = "(id => { const box = document.querySelector('#errors .heading select'); box.value = "
                               "id; box.dispatchEvent(new Event('change')); })";
    browser.evaluate(choose + "('view scene')");
    CHECK(texts("#errors thead tr:nth-child(2) button") == json{"fence", "hall"});
    browser.evaluate(choose + "('metrics')");
    CHECK(texts("#errors thead button")[1] == "RMSE");
    CHECK(texts("#errors tbody:nth-of-type(2) tr").size() == 1 + 7);

    // A cell's number opens its image, in its view.
    browser.evaluate(choose + "('by size')");
    browser.evaluate(
        "document.querySelector('#errors tbody:nth-of-type(2) tr:nth-child(3) td:nth-child(4) button').click()");
    browser.wait_for("document.querySelector('#readout div:nth-child(2) dt').textContent === 'pcf (size 2048)'");
    CHECK(browser.evaluate("document.querySelector('#view-choice select').selectedOptions[0].textContent") == "hall");
    CHECK(browser.complaints() == std::vector<std::string>{});
}
