#pragma once
// Claims held against what a study found.

#include <string>
#include <vector>

#include "eval/study/questions.h"

namespace gnomon {

// In part: some checks hold, some do not or could not be made. NotMeasured: none could be made.
enum class Verdict { Holds, InPart, Fails, NotMeasured };
const char* verdict_text(Verdict verdict); // "holds", "holds in part", "does not hold", "not measured"

// A check for one combination of the texts of its `per`.
struct CheckedGroup {
    std::string name; // "scene fence, parameters.size 512"; "" without `per`
    double left = 0, right = 0, bound = 0;
    size_t left_rows = 0, right_rows = 0; // cells that took part
    bool holds = false;
};

struct CheckResult {
    std::string formula; // what was compared, in words
    std::string measured;
    Verdict verdict = Verdict::NotMeasured;
    std::vector<CheckedGroup> groups;
};

struct ClaimResult {
    Verdict verdict = Verdict::NotMeasured;
    std::vector<CheckResult> checks;
};

ClaimResult judge(const StudyClaim& claim, const StudyLabels& labels, const std::vector<StudyRecord>& records);

// claims.json: {"study", "claims": [{"id", "text", "source", "verdict", "note", "checks": [{"text", "formula",
// "verdict", "measured", "groups": [{"name", "left", "right", "bound", "holds"}]}]}]}
nlohmann::ordered_json claims_json(const StudyQuestions& questions, const std::vector<StudyRecord>& records);

} // namespace gnomon
