#pragma once
// The lines of a study's results, checked. Each is a row of a table; rows of several blocks may share a cell.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace gnomon {

struct StudyReference {
    std::string technique, file; // file: relative to the folder, "" for none
    nlohmann::ordered_json parameters = nlohmann::ordered_json::object();
};

struct StudyCell {
    std::string cell, block, scene, camera, light, size, technique, status, message;
    nlohmann::ordered_json parameters = nlohmann::ordered_json::object(), varied = nlohmann::ordered_json::object();
    StudyReference reference;
    std::vector<std::pair<std::string, double>> metrics; // null in the file is infinity, as `compare --json` writes it
    nlohmann::ordered_json counters;                     // null for none
    std::string visibility;                              // relative to the folder, "" for none
    double seconds = 0.0;
    std::int64_t peak_bytes = 0;
};

// The rows of `folder` in the order of their first lines. A last line without its end, which a run that was killed
// leaves, does not count. Throws InputError with file and line for what is not as study_report.h says.
std::vector<StudyCell> read_study_cells(const std::string& folder);

} // namespace gnomon
