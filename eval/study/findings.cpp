#include "eval/study/findings.h"

#include <filesystem>

#include <fmt/format.h>

#include "eval/study/pivot.h"
#include "eval/study/verdict.h"

namespace gnomon {

using nlohmann::ordered_json;

ordered_json read_study_plan(const StudyStore& store) {
    const std::string file = store.folder() + "/" + study_plan_file;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored))
        throw InputError(fmt::format("'{}' holds no study: gnomon study run makes one", store.folder()));
    const nlohmann::json parsed = parse_json(store.text(study_plan_file), file);
    const JsonReader document(parsed, file);
    document.at("format").integer(study_plan_format, study_plan_format);
    for (size_t i = 0; i < document.at("rows").size(); ++i) document.at("rows")[i].at("cell").text();
    return ordered_json::parse(store.text(study_plan_file));
}

StudyFindings read_findings(const StudyStore& store, const ordered_json& plan) {
    StudyFindings findings;
    const nlohmann::json document = plan;
    const std::string file = store.folder() + "/" + study_plan_file;
    const JsonReader reader(document, file);
    findings.name = reader.has("study") ? reader.at("study").text() : "study";
    findings.questions = read_questions(reader, nullptr);
    if (reader.has("skipped"))
        for (size_t i = 0; i < reader.at("skipped").size(); ++i)
            findings.skipped.push_back(
                {reader.at("skipped")[i].at("scene").text(), reader.at("skipped")[i].at("missing").text()});
    for (const ordered_json& head : plan["rows"]) {
        const std::string hash = head["cell"];
        const std::optional<ordered_json> result = store.result(hash);
        if (result)
            findings.records.push_back(study_record(head, *result, store.timing(hash)));
        else
            ++findings.missing;
    }
    return findings;
}

std::string claims_document(const StudyFindings& findings) {
    const ordered_json document = {{"study", findings.name},
                                   {"claims", claims_json(findings.questions, findings.records)}};
    return document.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

ordered_json findings_json(const StudyFindings& findings) {
    ordered_json tables = ordered_json::array();
    for (const StudyTable& table : findings.questions.tables) {
        ordered_json parts = ordered_json::array();
        for (const StudyPivot& pivot : make_pivots(table, findings.records)) {
            ordered_json rows = ordered_json::array();
            for (size_t row = 0; row < pivot.rows.size(); ++row) {
                ordered_json texts = ordered_json::array();
                for (const StudyPlace& place : pivot.places[row]) texts.push_back(place_text(pivot.quantity, place));
                rows.push_back({{"labels", pivot.rows[row]}, {"texts", std::move(texts)}});
            }
            parts.push_back({{"title", quantity_title(pivot.quantity)},
                             {"keys", pivot.row_keys},
                             {"columns", pivot.columns},
                             {"rows", std::move(rows)}});
        }
        tables.push_back({{"name", table.name},
                          {"title", table.title},
                          {"source", table.source},
                          {"note", table.note},
                          {"parts", std::move(parts)}});
    }
    ordered_json skipped = ordered_json::array();
    for (const SkippedScene& scene : findings.skipped)
        skipped.push_back({{"scene", scene.name}, {"missing", scene.missing}});
    return {{"tables", std::move(tables)},
            {"claims", claims_json(findings.questions, findings.records)},
            {"skipped", std::move(skipped)},
            {"notes", findings.questions.notes}};
}

} // namespace gnomon
