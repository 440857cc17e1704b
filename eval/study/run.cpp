// From a plan to a full folder: what is there is left alone, what is missing is computed cell by cell.

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <new>
#include <set>

#include <fmt/format.h>

#include "core/progress.h"
#include "eval/compare.h"
#include "eval/study/findings.h"
#include "eval/study/store.h"
#include "eval/study/tables.h"

namespace gnomon {
namespace {

using nlohmann::ordered_json;

// What is known of a cell, where it is there and what it should be.
std::optional<ordered_json> known_result(const StudyStore& store, const PlannedCell& cell) {
    std::optional<ordered_json> result = store.result(cell.hash);
    if (result && (*result)["identity"].dump() != cell.identity.dump())
        throw InputError(
            fmt::format("the cell '{}/cells/{}' is another than this study's; remove it", store.folder(), cell.hash));
    return result;
}

bool failed(const ordered_json& result) { return result["status"] != "ok"; }

// One sentence without the folder of the scene, so that it is the same wherever the study lies.
std::string portable(std::string message, const StudyView& view) {
    const std::string folder = std::filesystem::path(view.scene).parent_path().string() + "/";
    for (size_t at; folder != "/" && (at = message.find(folder)) != std::string::npos;)
        message.erase(at, folder.size());
    return one_line(message);
}

// What went wrong in `work`, or nothing. Only what the cell itself is to blame for may happen in it.
std::optional<std::string> failure_of(const std::function<void()>& work) {
    try {
        work();
    } catch (const std::bad_alloc&) {
        return "out of memory";
    } catch (const std::exception& error) {
        return error.what();
    }
    return {};
}

class Runner {
public:
    Runner(const StudyPlan& plan, const StudyProgram& program, StudyStore& store)
        : plan_(plan), program_(program), store_(store) {}

    // False where another run is busy with the cell's truth and `wait` is not set.
    bool compute(const PlannedCell& cell, bool wait) {
        if (!prepare_truth(plan_.truths[cell.truth], wait)) return false;
        ordered_json result = {{"identity", cell.identity}};
        StudyImage made;
        std::optional<std::string> failure = truth_failure_;
        if (!failure) failure = failure_of([&] { made = measure(cell, result); });
        if (failure) {
            result = {{"identity", cell.identity}, {"status", "failed"}, {"message", portable(*failure, cell.view)}};
            store_.put_cell(cell.hash, std::move(result), ordered_json::object(), nullptr);
        } else {
            const ordered_json timing = {
                {"seconds", made.seconds}, {"peak_bytes", made.peak_bytes}, {"passes", made.pass_seconds}};
            store_.put_cell(cell.hash, std::move(result), timing, &made.image);
        }
        return true;
    }

private:
    StudyImage measure(const PlannedCell& cell, ordered_json& result) {
        StudyImage made = program_.render(cell.view, cell.technique, "");
        CompareOptions options;
        options.test_name = "visibility.exr", options.reference_name = "the truth", options.metrics = cell.metrics;
        const ordered_json compared = comparison_json(compare(made.image, truth_, options));
        result["status"] = "ok";
        for (const char* key : {"metrics", "pixels", "masked", "missing"}) result[key] = compared[key];
        result["counters"] = made.counters;
        result["passes"] = made.passes;
        return made;
    }

    // Afterwards the truth is in memory, or truth_failure_ says why there is none. Cells of one truth follow each
    // other.
    bool prepare_truth(const PlannedTruth& truth, bool wait) {
        if (truth_hash_ == truth.hash) return true;
        std::optional<ChannelImage> image = store_.truth(truth.hash);
        std::optional<std::string> failure;
        if (const auto before = failed_truths_.find(truth.hash); before != failed_truths_.end())
            failure = before->second;
        if (!image && !failure) {
            const TruthClaim claim = store_.claim_truth(truth.hash, wait);
            if (!claim.held() && !wait) return false;
            image = store_.truth(truth.hash); // another run may just have put it there
            if (!image) failure = make_truth(truth, claim.held() ? store_.truth_state(truth.hash) : "", image);
        }
        truth_hash_ = truth.hash;
        truth_failure_ = failure;
        if (image) truth_ = std::move(*image);
        return true;
    }

    std::optional<std::string> make_truth(const PlannedTruth& truth, const std::string& state,
                                          std::optional<ChannelImage>& image) {
        const std::optional<std::string> why =
            failure_of([&] { image = program_.render(truth.view, truth.choice, state).image; });
        if (!why) {
            store_.put_truth(truth.hash, *image);
            return {};
        }
        return failed_truths_[truth.hash] = "the truth: " + *why;
    }

    const StudyPlan& plan_;
    const StudyProgram& program_;
    StudyStore& store_;
    std::string truth_hash_;
    ChannelImage truth_;
    std::optional<std::string> truth_failure_;
    std::map<std::string, std::string> failed_truths_; // hash → why
};

std::vector<const PlannedCell*> cells_to_do(const StudyPlan& plan, const StudyStore& store, const StudyRun& run,
                                            StudySummary& summary) {
    std::vector<const PlannedCell*> to_do;
    summary.cells = plan.cells.size();
    for (size_t i = 0; i < plan.cells.size(); ++i) {
        if (!run.share.has(i)) continue;
        ++summary.share;
        const std::optional<ordered_json> result = known_result(store, plan.cells[i]);
        if (result && !(run.retry_failed && failed(*result)))
            ++summary.there;
        else
            to_do.push_back(&plan.cells[i]);
    }
    return to_do;
}

void compute_all(const std::vector<const PlannedCell*>& to_do, size_t there, Runner& runner, const StudyRun& run) {
    if (to_do.empty()) return;
    Progress progress(fmt::format("{} of {} cells to do", to_do.size(), to_do.size() + there),
                      static_cast<std::int64_t>(to_do.size()), run.progress);
    // Cells whose truth another run is busy with come last: meanwhile there is other work.
    std::vector<const PlannedCell*> later;
    for (const PlannedCell* cell : to_do)
        if (runner.compute(*cell, false))
            progress.advance();
        else
            later.push_back(cell);
    for (const PlannedCell* cell : later) {
        runner.compute(*cell, true);
        progress.advance();
    }
}

ordered_json plan_json(const StudyPlan& plan) {
    ordered_json rows = ordered_json::array();
    for (const PlannedRow& row : plan.rows) rows.push_back(row.head);
    ordered_json skipped = ordered_json::array();
    for (const SkippedScene& scene : plan.skipped)
        skipped.push_back({{"scene", scene.name}, {"missing", scene.missing}});
    ordered_json document = {{"format", study_plan_format}, {"study", plan.name}, {"skipped", std::move(skipped)}};
    for (const auto& item : plan.questions.items()) document[item.key()] = item.value();
    document["rows"] = std::move(rows);
    return document;
}

// Writes the tables of the rows that have results, and what becomes of claims. Counts the cells, and those that are
// missing.
void write_tables(StudyStore& store, const ordered_json& plan, bool partial, StudySummary& summary) {
    std::map<std::string, std::optional<ordered_json>> results;
    std::vector<ordered_json> lines, timings;
    for (const ordered_json& head : plan["rows"]) {
        const std::string hash = head["cell"];
        const auto [place, added] = results.try_emplace(hash);
        if (added) place->second = store.result(hash);
        if (added && !place->second) ++summary.missing;
        if (!place->second) continue;
        lines.push_back(result_line(head, *place->second));
        timings.push_back(timing_line(head, store.timing(hash)));
    }
    summary.cells = results.size();
    if (summary.missing > 0 && !partial) return;
    store.put_text("results.jsonl", json_lines(lines));
    store.put_text("results.csv", csv(lines));
    store.put_text("timings.jsonl", json_lines(timings));
    store.put_text("timings.csv", csv(timings));
    std::error_code ignored;
    if (plan.contains("claims"))
        store.put_text("claims.json", claims_document(read_findings(store, plan)));
    else // of an earlier version of the study
        std::filesystem::remove(store.folder() + "/claims.json", ignored);
}

void count_failures(const StudyStore& store, const std::vector<std::string>& hashes, StudySummary& summary) {
    for (const std::string& hash : hashes) {
        const std::optional<ordered_json> result = store.result(hash);
        if (!result || !failed(*result)) continue;
        if (summary.failed++ == 0) summary.first_failure = (*result)["message"];
    }
}

} // namespace

StudySummary run_study(const StudyPlan& plan, const StudyProgram& program, const std::string& folder,
                       const StudyRun& run) {
    StudyStore store(folder);
    store.remove_abandoned();
    StudySummary summary;
    const std::vector<const PlannedCell*> to_do = cells_to_do(plan, store, run, summary);
    const ordered_json written = plan_json(plan);
    store.put_text(study_plan_file, written.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n");
    Runner runner(plan, program, store);
    compute_all(to_do, summary.there, runner, run);
    summary.computed = to_do.size();
    for (const PlannedTruth& truth : plan.truths) store.tidy(truth.hash);
    std::vector<std::string> own;
    for (size_t i = 0; i < plan.cells.size(); ++i)
        if (run.share.has(i)) own.push_back(plan.cells[i].hash);
    count_failures(store, own, summary);
    write_tables(store, written, false, summary);
    return summary;
}

StudySummary collect_study(const std::string& folder, bool partial) {
    StudyStore store(folder);
    StudySummary summary;
    const ordered_json plan = read_study_plan(store);
    write_tables(store, plan, partial, summary);
    if (summary.missing > 0 && !partial)
        throw InputError(fmt::format("{} of {} cells are missing in '{}'; gnomon study run computes them, --partial "
                                     "writes the tables without them",
                                     summary.missing, summary.cells, folder));
    std::vector<std::string> hashes;
    std::set<std::string> seen;
    for (const ordered_json& head : plan["rows"])
        if (seen.insert(head["cell"]).second) hashes.push_back(head["cell"]);
    count_failures(store, hashes, summary);
    return summary;
}

std::string list_study(const StudyPlan& plan, const std::string& folder) {
    const StudyStore store(folder);
    std::vector<std::string> states;
    for (const PlannedCell& cell : plan.cells) {
        const std::optional<ordered_json> result = known_result(store, cell);
        states.push_back(!result ? "to do" : failed(*result) ? "failed" : "there");
    }
    std::string text;
    for (const PlannedRow& row : plan.rows) {
        const auto word = [&](const char* key) { return row.head[key].get<std::string>(); };
        std::string varied;
        for (const auto& item : row.head["varied"].items())
            varied += fmt::format("{}{}={}", varied.empty() ? ":" : ",", item.key(), item.value().dump());
        text += fmt::format("{:<6}  {}  {}  {}  {}  {}  {}  {}{}\n", states[row.cell], word("cell"), word("block"),
                            word("scene"), word("camera"), word("light"), word("size"), word("technique"), varied);
    }
    return text;
}

} // namespace gnomon
