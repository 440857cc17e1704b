#pragma once
// A report: one HTML file that shows what several techniques made of one scene, how far each is from the reference and
// what it cost. Everything is inside the file (images too); it opens from disk, asks nothing of the network and holds
// no date, so that the same data gives the same bytes.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/image.h"
#include "core/math.h"

namespace gnomon {

// What one technique made of the scene.
struct ReportEntry {
    std::string id, title, kind, paper; // kind: "hard", "filtered", "soft", "accurate", …
    nlohmann::ordered_json parameters = nlohmann::ordered_json::object(); // {name: value}
    Image<vec3> shaded;                                                   // display-referred sRGB; may be empty
    Image<float> visibility;                                              // may be empty
    nlohmann::ordered_json passes =
        nlohmann::ordered_json::array(); // as in `render --stats`: [{"name", "draws", …, "seconds"}]
    double seconds = 0.0;
    std::int64_t peak_bytes = 0;
    std::vector<std::string> links; // files beside the report, by names relative to it
    std::vector<std::pair<std::string, double>> visibility_metrics,
        shaded_metrics; // against the reference; ids of metrics()
};

struct ReportData {
    std::string title, scene, camera, light;
    std::vector<std::string> command_lines; // that made the images
    std::string reference_id;               // the entry the others are compared with; "" for none
    std::vector<ReportEntry> entries;       // images all of one size
    Image<std::uint8_t> mask;               // receivers that face the light: 1 in, 0 out; may be empty
};

// Visibility is embedded as round(clamp(v, 0, 1) * visibility_levels), which the page reads out: exact to 1/131068. The
// code above it stands for a value that is not finite.
inline constexpr int visibility_levels = 65534;

// The page as text. Throws UsageError where the images are not of one size or `reference_id` is no entry's.
std::string report_page(const ReportData& data);

// Writes it whole or not at all. Throws InputError where the file cannot be written.
void write_report(const std::string& path, const ReportData& data);

} // namespace gnomon
