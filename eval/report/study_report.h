#pragma once
// The report of a study: reads the folder that `gnomon study run` fills and makes a page of it. Each block of the study
// gets a table arranged like a paper's (rows techniques, columns the varied parameter), plots, and images of chosen
// cells.
//
// FOLDER/results.jsonl, one cell a line: {"cell", "block", "scene", "camera", "light", "size", "technique",
// "parameters", "varied", "reference": {"technique", "parameters", "file"}, "status", "message", "metrics", "counters",
// "files": {"visibility"}}; FOLDER/timings.jsonl, if it is there: {"cell", "seconds", "peak_bytes"}. Of several lines
// about one row the last counts; rows of several blocks may share a cell. File names are relative to the folder and stay inside it.

#include <functional>
#include <map>
#include <string>

#include "eval/report/report.h"

namespace gnomon {

// What the page says of a technique besides its id.
struct TechniqueWords {
    std::string title, kind, paper;
    std::map<std::string, std::string> units; // of its parameters
};

struct StudyReportOptions {
    std::string title;               // "": the folder's name
    size_t image_budget = 16u << 20; // bytes of the page that images may take; 0: none
    std::function<TechniqueWords(const std::string& id)> describe = [](const std::string& id) {
        return TechniqueWords{id, "", "", {}};
    };
};

// What write_report takes; links are relative to the folder of `page`. Images are those of each view's reference and,
// as long as the budget lasts, of each technique's cell with the lowest RMSE, then of the others; an image that is not
// there or broken is a note on the page. Throws InputError naming file and line where the results cannot be read.
ReportData study_report(const std::string& folder, const std::string& page, const StudyReportOptions& options = {});

} // namespace gnomon
