// Findings as text: Markdown for a page, CSV for programs.

#include <algorithm>

#include <fmt/format.h>

#include "eval/study/findings.h"
#include "eval/study/pivot.h"
#include "eval/study/tables.h"
#include "eval/study/verdict.h"

namespace gnomon {
namespace {

using nlohmann::ordered_json;

// Text inside a table's place: a bar would end it.
std::string inside(const std::string& text) {
    std::string safe;
    for (const char letter : one_line(text)) safe += letter == '|' ? std::string("\\|") : std::string(1, letter);
    return safe;
}

std::string line(const std::vector<std::string>& places) {
    std::string text = "|";
    for (const std::string& place : places) text += fmt::format(" {} |", inside(place));
    return text + "\n";
}

// A label that is the one above it is left out.
std::string pivot_markdown(const StudyPivot& pivot) {
    std::vector<std::string> head;
    for (const std::string& key : pivot.row_keys) head.push_back(key_title(key));
    std::string text, rule = "|";
    for (size_t i = 0; i < head.size(); ++i) rule += "---|";
    for (const std::string& column : pivot.columns) head.push_back(column), rule += "---:|";
    text += line(head) + rule + "\n";
    for (size_t row = 0; row < pivot.rows.size(); ++row) {
        std::vector<std::string> places = pivot.rows[row];
        if (row > 0)
            for (size_t i = 0; i + 1 < places.size() && pivot.rows[row - 1][i] == pivot.rows[row][i]; ++i)
                places[i].clear();
        for (const StudyPlace& place : pivot.places[row]) places.push_back(place_text(pivot.quantity, place));
        text += line(places);
    }
    return text;
}

std::string table_markdown(const StudyTable& table, const std::vector<StudyRecord>& records) {
    std::string text = fmt::format("### {}{}{}\n\n", table.name, table.title.empty() ? "" : ": ", table.title);
    if (!table.source.empty()) text += fmt::format("Source: {}.\n\n", table.source);
    if (!table.note.empty()) text += table.note + "\n\n";
    for (const StudyPivot& pivot : make_pivots(table, records)) {
        std::string title = quantity_title(pivot.quantity);
        if (!title.empty() && title[0] >= 'a' && title[0] <= 'z') title[0] = static_cast<char>(title[0] - 'a' + 'A');
        text += fmt::format("**{}**\n\n{}\n", title, pivot.rows.empty() ? "No rows.\n" : pivot_markdown(pivot));
    }
    return text;
}

std::string claims_markdown(const StudyFindings& findings) {
    std::string text = "| claim | check | measured | holds |\n|---|---|---|---|\n";
    for (const StudyClaim& claim : findings.questions.claims) {
        const ClaimResult result = judge(claim, findings.questions.labels, findings.records);
        std::string words = fmt::format("**{}** {}", claim.id, claim.text);
        if (!claim.source.empty()) words += fmt::format(" ({})", claim.source);
        if (!claim.note.empty()) words += fmt::format("<br>*{}*", claim.note);
        if (claim.checks.size() > 1) text += line({words, "", "", fmt::format("**{}**", verdict_text(result.verdict))});
        for (size_t i = 0; i < claim.checks.size(); ++i) {
            const CheckResult& check = result.checks[i];
            const std::string& told = claim.checks[i].text;
            const std::string verdict = verdict_text(check.verdict);
            text += line({claim.checks.size() > 1 ? "" : words,
                          told.empty() ? check.formula : fmt::format("{}: {}", told, check.formula), check.measured,
                          claim.checks.size() > 1 ? verdict : fmt::format("**{}**", verdict)});
        }
    }
    return text;
}

std::string summary_of(const StudyFindings& findings) {
    size_t failed = 0;
    for (const StudyRecord& record : findings.records) failed += record.failed;
    std::string text = fmt::format("{} rows", findings.records.size());
    if (failed > 0) text += fmt::format(", {} of them failed", failed);
    if (findings.missing > 0) text += fmt::format(", {} more are missing", findings.missing);
    for (const SkippedScene& scene : findings.skipped)
        text += fmt::format("; the scene '{}' was **skipped**, since {} is not there", scene.name, scene.missing);
    return text + ".\n\n";
}

} // namespace

std::string findings_markdown(const StudyFindings& findings) {
    const StudyQuestions& questions = findings.questions;
    std::string text = fmt::format("## {}\n\n", findings.name);
    if (!questions.description.empty()) text += questions.description + "\n\n";
    text += summary_of(findings);
    for (const StudyTable& table : questions.tables) text += table_markdown(table, findings.records);
    if (!questions.claims.empty()) text += "### Claims\n\n" + claims_markdown(findings) + "\n";
    if (!questions.notes.empty()) {
        text += "### Notes\n\n";
        for (const std::string& note : questions.notes) text += fmt::format("* {}\n", note);
        text += "\n";
    }
    text.pop_back();
    return text;
}

std::string tables_csv(const StudyFindings& findings) {
    std::string text = "table,quantity,row,column,value,relative\r\n";
    for (const StudyTable& table : findings.questions.tables)
        for (const StudyPivot& pivot : make_pivots(table, findings.records))
            for (size_t row = 0; row < pivot.rows.size(); ++row)
                for (size_t column = 0; column < pivot.columns.size(); ++column) {
                    const StudyPlace& place = pivot.places[row][column];
                    const auto number = [](const std::optional<double>& value) {
                        return value ? ordered_json(*value).dump() : std::string();
                    };
                    text += fmt::format("{},{},{},{},{},{}\r\n", csv_text(table.name), csv_text(pivot.quantity.text()),
                                        csv_text(fmt::format("{}", fmt::join(pivot.rows[row], " / "))),
                                        csv_text(pivot.columns[column]), place.failed ? "failed" : number(place.value),
                                        number(place.relative));
                }
    return text;
}

} // namespace gnomon
