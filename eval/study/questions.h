#pragma once
// What a study file asks of its results: tables in a paper's arrangement, and claims that hold or do not.
// docs/studies.md describes the keys. They are kept in study.json as they were written, and read again from there.

#include <optional>
#include <string>
#include <vector>

#include "core/json_reader.h"
#include "eval/study/records.h"

namespace gnomon {

// What a study calls things: key ("technique") → text ("pcf") → label ("PCF").
using StudyLabels = std::map<std::string, std::map<std::string, std::string>>;

// A table: a row for each combination of the row keys' texts, a column for each of the column keys'.
struct StudyTable {
    std::string name, title, source, note;
    StudySelection where;
    std::vector<std::string> rows, columns;
    std::vector<StudyQuantity> values; // one such table for each
    std::string aggregate = "mean";    // of what stands in one place
    StudySelection baseline;           // row keys with one text each: values are shown relative to that row besides
    StudyLabels labels;
};

// One side of a comparison: a value, of rows that are chosen, as one number.
struct ClaimSide {
    StudyQuantity value;
    StudySelection where;
    std::string aggregate = "mean";
    std::string power_key; // instead: the exponent with which the value grows with this key
};

// What stands for a claim: a comparison of results, or a test of the program with what it was seen to measure.
struct ClaimCheck {
    std::string text; // in words; may be empty
    ClaimSide left;
    std::string relation;          // < <= > >= =
    double factor = 1, offset = 0; // the bound is factor × right + offset, of a constant the offset alone
    std::optional<ClaimSide> right;
    double margin = 0;                               // of =
    std::vector<std::string> per;                    // once for each combination of these keys' texts
    std::string test_file, test_name, test_measured; // of a test
    bool test_holds = false;
    bool is_test() const { return !test_file.empty(); }
};

struct StudyClaim {
    std::string id, text, source, note;
    std::vector<ClaimCheck> checks;
};

struct StudyQuestions {
    std::string description;
    std::vector<std::string> notes;
    StudyLabels labels;
    std::vector<StudyTable> tables;
    std::vector<StudyClaim> claims;
};

std::string label_of(const StudyLabels& labels, const std::string& key, const std::string& text);
// What readers call a key: "size" of parameters.size; the picture's is "image".
std::string key_title(const std::string& key);

// What may be asked for; nothing is checked where it is left out, as for a folder that another version made.
struct StudyVocabulary {
    std::vector<std::string> values, techniques; // ids
    std::vector<StudyRecord> rows;               // of the plan, with those that absent scenes would have
};

// The keys of a study file, or of study.json, that are questions.
const JsonReader::Keys& question_keys();

// Throws InputError with the place of what is not as it should be; of a selection, also where it chooses no row.
StudyQuestions read_questions(const JsonReader& document, const StudyVocabulary* vocabulary);

} // namespace gnomon
