#pragma once
// A study's folder read back: what was asked, what came out.

#include "eval/study/questions.h"
#include "eval/study/store.h"

namespace gnomon {

inline constexpr const char* study_plan_file = "study.json";
inline constexpr int study_plan_format = 1;

struct StudyFindings {
    std::string name;
    StudyQuestions questions;
    std::vector<StudyRecord> records; // of the rows whose cells are there
    std::vector<SkippedScene> skipped;
    size_t missing = 0; // rows whose cells are not there
};

// study.json, checked as far as its rows name their cells. Throws InputError where the folder holds no study.
nlohmann::ordered_json read_study_plan(const StudyStore& store);

StudyFindings read_findings(const StudyStore& store, const nlohmann::ordered_json& plan);

// The text of claims.json. The same bytes on every run, unless a check is of times or of the program's memory.
std::string claims_document(const StudyFindings& findings);

// A page of Markdown, headings from the second level on: tables in their arrangement, then claims, then notes.
std::string findings_markdown(const StudyFindings& findings);

// The tables as lines "table,quantity,row,column,value,relative", with a line of these names before them.
std::string tables_csv(const StudyFindings& findings);

// What the report shows: {"tables": [{"name", "title", "source", "note", "parts": [{"title", "keys", "columns",
// "rows": [{"labels", "texts"}]}]}], "claims", "skipped", "notes"}.
nlohmann::ordered_json findings_json(const StudyFindings& findings);

} // namespace gnomon
