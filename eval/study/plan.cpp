// Blocks multiplied out: rows in the order of the file, and the cells and truths that they need, each once.

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "eval/metrics.h"
#include "eval/study/file.h"
#include "eval/study/identity.h"
#include "eval/study/questions.h"

namespace gnomon {
namespace {

using nlohmann::ordered_json;

constexpr double most_rows = 1e6;

class Planner {
public:
    Planner(const StudyProgram& program, StudyPlan& plan) : program_(program), plan_(plan) {}

    // Heads of the rows that scenes would have which are not there.
    const std::vector<ordered_json>& absent() const { return absent_; }

    void add(const StudyBlock& block) {
        for (const NamedScene& scene : block.scenes) {
            if (!scene.missing.empty()) note_skipped(scene);
            for (const NamedOptions& camera : block.cameras)
                for (const NamedOptions& light : block.lights)
                    for (const std::string& size : block.sizes) {
                        const ordered_json head = {{"block", block.name},
                                                   {"scene", scene.name},
                                                   {"camera", camera.name},
                                                   {"light", light.name},
                                                   {"size", size}};
                        if (scene.missing.empty())
                            add_view(block, {scene.scene, camera.options, light.options, size, block.primary},
                                     scene.identity, head);
                        else
                            add_absent(block, head);
                    }
        }
    }

private:
    void note_skipped(const NamedScene& scene) {
        if (std::none_of(plan_.skipped.begin(), plan_.skipped.end(),
                         [&](const SkippedScene& other) { return other.name == scene.name; }))
            plan_.skipped.push_back({scene.name, scene.missing});
    }

    void add_absent(const StudyBlock& block, const ordered_json& head) {
        for (const StudyVariant& truth : block.truths)
            for (const StudyVariant& technique : block.techniques)
                absent_.push_back(row_head("", "", head, technique, truth));
    }

    void add_view(const StudyBlock& block, const StudyView& view, const ordered_json& scene, const ordered_json& head) {
        for (const StudyVariant& truth : block.truths) {
            const size_t truth_index = add_truth(view, scene, truth.choice);
            for (const StudyVariant& technique : block.techniques) {
                const size_t cell = add_cell(block, view, scene, technique.choice, truth_index);
                plan_.rows.push_back(
                    {cell, row_head(plan_.cells[cell].hash, plan_.truths[truth_index].hash, head, technique, truth)});
            }
        }
    }

    size_t add_truth(const StudyView& view, const ordered_json& scene, const StudyChoice& choice) {
        ordered_json identity = truth_cell_identity(program_.version, scene, view, choice);
        const std::string hash = identity_hash(identity);
        const auto [place, added] = truths_.emplace(hash, plan_.truths.size());
        if (added) plan_.truths.push_back({hash, std::move(identity), view, choice});
        return place->second;
    }

    size_t add_cell(const StudyBlock& block, const StudyView& view, const ordered_json& scene,
                    const StudyChoice& technique, size_t truth) {
        ordered_json identity =
            cell_identity(program_.version, scene, view, technique, plan_.truths[truth].choice, block.metrics);
        const std::string hash = identity_hash(identity);
        const auto [place, added] = cells_.emplace(hash, plan_.cells.size());
        if (added) plan_.cells.push_back({hash, std::move(identity), view, technique, truth, block.metrics});
        return place->second;
    }

    static ordered_json row_head(const std::string& cell, const std::string& truth_hash, const ordered_json& view,
                                 const StudyVariant& technique, const StudyVariant& truth) {
        ordered_json head = {{"cell", cell}};
        head.update(view);
        head["technique"] = technique.choice.id;
        head["parameters"] = technique.choice.parameters;
        head["varied"] = technique.varied;
        for (const auto& item : truth.varied.items()) head["varied"]["reference." + item.key()] = item.value();
        head["reference"] = {{"technique", truth.choice.id},
                             {"parameters", truth.choice.parameters},
                             {"file", "truths/" + truth_hash + ".exr"}};
        return head;
    }

    const StudyProgram& program_;
    StudyPlan& plan_;
    std::map<std::string, size_t> cells_, truths_;
    std::vector<ordered_json> absent_;
};

double rows_of(const StudyBlock& block) {
    double rows = 1;
    for (const size_t count : {block.scenes.size(), block.cameras.size(), block.lights.size(), block.sizes.size(),
                               block.truths.size(), block.techniques.size()})
        rows *= static_cast<double>(count);
    return rows;
}

// Fails where a table or a claim asks for what no row has, be its scene there or not.
void check_questions(const StudyFile& file, const std::string& path, const StudyProgram& program, const StudyPlan& plan,
                     const std::vector<ordered_json>& absent) {
    StudyVocabulary vocabulary;
    for (const Metric& metric : metrics()) vocabulary.values.push_back(metric.id);
    vocabulary.values.insert(vocabulary.values.end(), program.counters.begin(), program.counters.end());
    for (const char* id : {"pixels", "masked", "missing", "seconds", "peak_bytes"}) vocabulary.values.emplace_back(id);
    for (const StudyTechnique& technique : program.techniques) vocabulary.techniques.push_back(technique.id);
    for (const PlannedRow& row : plan.rows) vocabulary.rows.push_back(study_record(row.head, nullptr, nullptr));
    for (const ordered_json& head : absent) vocabulary.rows.push_back(study_record(head, nullptr, nullptr));
    read_questions(JsonReader(file.questions, path), &vocabulary);
}

} // namespace

StudyPlan read_study(const std::string& path, const StudyProgram& program) {
    const StudyFile file = read_study_file(path, program);
    double rows = 0;
    for (const StudyBlock& block : file.blocks) rows += rows_of(block);
    if (rows > most_rows)
        throw InputError(
            fmt::format("{}: the study has {:.0f} rows, but {:.0f} is the limit; split it", path, rows, most_rows));
    StudyPlan plan;
    plan.name = file.name;
    Planner planner(program, plan);
    for (const StudyBlock& block : file.blocks) planner.add(block);
    plan.questions = file.questions;
    check_questions(file, path, program, plan, planner.absent());
    if (plan.rows.empty())
        throw InputError(fmt::format("{}: none of its scenes is there; the first that is missing: '{}'", path,
                                     plan.skipped[0].missing));
    return plan;
}

} // namespace gnomon
