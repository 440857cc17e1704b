#pragma once
// A report: one HTML file that shows what techniques made of one or more views, how far each is from the reference and
// what it cost. Everything is inside the file (images too); it opens from disk, asks nothing of the network and holds
// no date, so that the same data gives the same bytes. Names and messages may be any text: none can leave its place.

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/image.h"
#include "core/math.h"

namespace gnomon {

// A scene from one camera under one light, and the receivers that count there. Its images are all of one size.
struct ReportView {
    std::string scene, camera, light, size, truth; // "1280x720"; truth: what tells its reference from another view's
    Image<std::uint8_t> mask;                      // receivers that face the light: 1 in, 0 out; may be empty
};

// What one technique made of a view.
struct ReportEntry {
    int block = 0, view = 0; // indices into ReportData
    bool is_reference = false;
    std::string id, title, kind, paper; // kind: "hard", "filtered", "soft", "accurate", …
    nlohmann::ordered_json parameters = nlohmann::ordered_json::object(); // {name: value}
    nlohmann::ordered_json varied = nlohmann::ordered_json::object(); // those that tell it from others of its technique
    Image<vec3> shaded;                                               // display-referred sRGB; may be empty
    Image<float> visibility;                                          // may be empty
    int image_rank = 0; // where not all images fit the page, the highest are left out first, references last
    nlohmann::ordered_json passes =
        nlohmann::ordered_json::array(); // as in `render --stats`: [{"name", "draws", …, "seconds"}]
    nlohmann::ordered_json counters;     // instead of passes, their sums: {"draws", …}; null for none
    double seconds = 0.0;
    std::int64_t peak_bytes = 0;
    std::vector<std::string> links; // files beside the report, by names relative to it
    std::vector<std::pair<std::string, double>> visibility_metrics, shaded_metrics; // against the reference
    std::string cell, status = "ok", message; // of a study: hash; "failed" with its message
};

struct ReportData {
    enum class Kind { Render, Study } kind = Kind::Render;
    std::string title;
    std::vector<std::pair<std::string, std::string>> facts; // shown under the title
    std::vector<std::string> notes;                         // sentences under the facts
    std::vector<std::string> command_lines;                 // that made the images
    std::vector<std::string> links;                         // files of the whole, relative to the page
    std::map<std::string, std::string> parameter_units;     // of varied parameters: {"size": "texels"}
    std::vector<std::string> blocks = {""};                 // each gets a table and plots of its own
    std::vector<ReportView> views;
    std::vector<ReportEntry> entries;       // at most one reference a view
    nlohmann::ordered_json findings;        // of a study: tables and claims as findings_json makes them; null for none
    size_t image_budget = size_t{24} << 20; // bytes of the page that images may take
};

// Fills `varied` of every entry with the parameters in which the entries of its technique and view differ.
void name_differences(ReportData& data);

// The page as text. Where images would take more than their budget, shaded ones are made smaller, then visibility is
// stored in fewer levels, then images are left out; a note on the page says so. Throws UsageError
// where the images of a view are not of one size, and where an entry names no block or view of the report's.
std::string report_page(const ReportData& data);

// Writes it whole or not at all. Throws InputError where the file cannot be written.
void write_report(const std::string& path, const ReportData& data);

} // namespace gnomon
