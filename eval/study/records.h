#pragma once
// What a study found, row by row, as its tables and claims ask for it: rows are told apart by keys, and have values.
//
// Keys are "block", "scene", "camera", "light", "size", "technique", "parameters.NAME", "reference.technique" and
// "reference.parameters.NAME"; and "pass", of which a row has several. Values are metrics, counters, "pixels",
// "masked", "missing", "seconds" and "peak_bytes"; of passes, counters and "seconds".

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gnomon {

struct StudyPass {
    std::string name;
    std::map<std::string, double> values;
};

struct StudyRecord {
    std::string cell;                        // rows of several blocks may share one
    std::map<std::string, std::string> keys; // as text: "1024", "true", "pcf"
    std::map<std::string, double> values;    // none where the cell failed
    std::vector<StudyPass> passes;
    bool failed = false;
};

// `head` is a row of study.json, `result` and `timing` what the store has of its cell (null for none).
StudyRecord study_record(const nlohmann::ordered_json& head, const nlohmann::ordered_json& result,
                         const nlohmann::ordered_json& timing);

// The rows whose keys are among those given; "pass" chooses passes, not rows. A row that lacks a key is not chosen.
using StudySelection = std::map<std::string, std::vector<std::string>>;
bool is_selected(const StudyRecord& record, const StudySelection& selection);

// "rmse", or two of them: "over-under", "texels_fetched/masked".
struct StudyQuantity {
    std::string first, second;
    char operation = 0; // + - /, 0 for one value
    std::string text() const { return operation ? first + operation + second : first; }
};

// Nothing where the row has no such value. With `passes`, what these passes have together; then a divisor, which
// passes may lack, is the row's.
std::optional<double> value_of(const StudyRecord& record, const StudyQuantity& quantity,
                               const std::vector<std::string>* passes = nullptr);

// "mean", "min", "max", "median", "sum" of at least one value.
double aggregate_of(const std::string& how, std::vector<double> values);
const std::vector<std::string>& aggregate_names();

// The exponent p of y = c x^p by least squares on logarithms: x and y above 0. Nothing where all x are the same.
std::optional<double> power_of(const std::vector<std::pair<double, double>>& points);

} // namespace gnomon
