#include "eval/report/study_report.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "core/error.h"
#include "core/image_file.h"
#include "eval/report/study_cells.h"
#include "eval/study/findings.h"

namespace gnomon {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// A page under way.
struct StudyPage {
    const std::string& folder;
    const StudyReportOptions& options;
    std::string prefix;                 // of links: from the page's folder to the study's, "" or with a slash
    std::vector<StudyCell> cells;       // cells[i] is data.entries[i]; references follow
    std::vector<StudyReference> truths; // of each view
    std::map<std::string, TechniqueWords> words;
    ReportData data;
    size_t unreadable = 0; // images
};

template <class T> int index_of(std::vector<T>& known, const T& one) {
    const auto found = std::find(known.begin(), known.end(), one);
    if (found == known.end()) known.push_back(one);
    return static_cast<int>(std::find(known.begin(), known.end(), one) - known.begin());
}

const TechniqueWords& words_of(StudyPage& page, const std::string& id) {
    const auto [found, is_new] = page.words.try_emplace(id);
    if (is_new) found->second = page.options.describe(id);
    for (const auto& [name, unit] : found->second.units) page.data.parameter_units.emplace(name, unit);
    return found->second;
}

// Cells are of one view where they show the same and are measured against the same reference.
int view_of(StudyPage& page, std::map<std::vector<std::string>, int>& known, const StudyCell& cell) {
    const StudyReference& truth = cell.reference;
    const auto [found, is_new] =
        known.try_emplace({cell.scene, cell.camera, cell.light, cell.size, truth.technique,
                           truth.parameters.dump(-1, ' ', false, Json::error_handler_t::replace), truth.file},
                          static_cast<int>(page.data.views.size()));
    if (is_new) {
        page.data.views.push_back({cell.scene, cell.camera, cell.light, cell.size, "", {}});
        page.truths.push_back(truth);
    }
    return found->second;
}

// A view's reference in words: the technique, and the parameters that not all references share.
std::string truth_words(const StudyPage& page, const StudyReference& truth) {
    std::string text = truth.technique;
    for (const auto& item : truth.parameters.items()) {
        const bool shared = std::all_of(page.truths.begin(), page.truths.end(), [&](const StudyReference& other) {
            return other.technique != truth.technique ||
                   (other.parameters.contains(item.key()) && other.parameters[item.key()] == item.value());
        });
        if (!shared)
            text +=
                fmt::format(" {} {}", item.key(), item.value().dump(-1, ' ', false, Json::error_handler_t::replace));
    }
    return text;
}

ReportEntry entry_of(StudyPage& page, const StudyCell& cell, int block, int view) {
    const TechniqueWords& words = words_of(page, cell.technique);
    ReportEntry entry;
    entry.block = block, entry.view = view;
    entry.id = cell.technique, entry.title = words.title, entry.kind = words.kind, entry.paper = words.paper;
    entry.parameters = cell.parameters, entry.varied = cell.varied, entry.counters = cell.counters;
    entry.seconds = cell.seconds, entry.peak_bytes = cell.peak_bytes;
    if (!cell.visibility.empty()) entry.links = {page.prefix + cell.visibility};
    entry.visibility_metrics = cell.metrics;
    entry.cell = cell.cell, entry.status = cell.status, entry.message = cell.message;
    return entry;
}

ReportEntry reference_of(StudyPage& page, int view) {
    const StudyReference& truth = page.truths[static_cast<size_t>(view)];
    const TechniqueWords& words = words_of(page, truth.technique);
    ReportEntry entry;
    entry.view = view, entry.is_reference = true;
    entry.id = truth.technique, entry.title = words.title, entry.kind = words.kind, entry.paper = words.paper;
    entry.parameters = truth.parameters;
    if (!truth.file.empty()) entry.links = {page.prefix + truth.file};
    return entry;
}

void fill_entries(StudyPage& page) {
    std::map<std::vector<std::string>, int> views;
    page.data.blocks.clear();
    for (const StudyCell& cell : page.cells) {
        const int block = index_of(page.data.blocks, cell.block.empty() ? std::string("Results") : cell.block);
        const int view = view_of(page, views, cell);
        page.data.entries.push_back(entry_of(page, cell, block, view));
    }
    for (size_t view = 0; view < page.truths.size(); ++view) {
        page.data.views[view].truth = truth_words(page, page.truths[view]);
        if (!page.truths[view].technique.empty())
            page.data.entries.push_back(reference_of(page, static_cast<int>(view)));
    }
}

double rank_of(const StudyCell& cell) {
    for (const auto& [name, value] : cell.metrics)
        if (name == "rmse") return value;
    return std::numeric_limits<double>::infinity();
}

bool is_pictured(const StudyCell& cell) { return cell.status == "ok" && !cell.visibility.empty(); }

// The cells whose images are wanted, most wanted first: of each view one technique's best after the other, so that all
// views get some of a small budget, then the rest in their order.
std::vector<size_t> wanted_cells(const StudyPage& page) {
    std::map<int, std::map<std::string, size_t>> best; // view, technique
    std::set<std::string> shared;                      // several rows may be of one cell: the first has its image
    std::vector<bool> candidates(page.cells.size());
    for (size_t i = 0; i < page.cells.size(); ++i)
        candidates[i] = is_pictured(page.cells[i]) && shared.insert(page.cells[i].cell).second;
    for (size_t i = 0; i < page.cells.size(); ++i) {
        if (!candidates[i]) continue;
        const auto [found, is_new] = best[page.data.entries[i].view].try_emplace(page.cells[i].technique, i);
        if (!is_new && rank_of(page.cells[i]) < rank_of(page.cells[found->second])) found->second = i;
    }
    std::vector<size_t> order;
    std::set<size_t> taken;
    for (bool any = true; any;) {
        any = false;
        for (auto& [view, techniques] : best) {
            if (techniques.empty()) continue;
            any = true;
            order.push_back(techniques.begin()->second), taken.insert(order.back());
            techniques.erase(techniques.begin());
        }
    }
    for (size_t i = 0; i < page.cells.size(); ++i)
        if (candidates[i] && !taken.contains(i)) order.push_back(i);
    return order;
}

bool ends_with_channel(const std::string& name, const std::string& channel) {
    return name == channel || name.ends_with("." + channel);
}

// The mean of the lights' visibilities; empty where there is none.
Image<float> mean_visibility(const ChannelImage& image) {
    Image<float> mean;
    float count = 0.0f;
    for (const Channel& channel : image.channels) {
        if (!ends_with_channel(channel.name, "V")) continue;
        if (mean.empty()) mean = Image<float>(image.width, image.height);
        for (size_t i = 0; i < mean.size(); ++i) mean.values()[i] += channel.values.values()[i];
        ++count;
    }
    for (float& value : mean.values()) value /= count;
    return mean;
}

// Receivers that face some light; empty where the image does not say.
Image<std::uint8_t> facing_mask(const ChannelImage& image) {
    Image<std::uint8_t> mask;
    for (const Channel& channel : image.channels) {
        if (!ends_with_channel(channel.name, "M")) continue;
        if (mask.empty()) mask = Image<std::uint8_t>(image.width, image.height);
        for (size_t i = 0; i < mask.size(); ++i)
            if (channel.values.values()[i] > 0.0f) mask.values()[i] = 1;
    }
    return mask;
}

// Gives an entry its image; false where it is not there or does not fit its view, which is a note and no failure.
bool load_image(StudyPage& page, ReportEntry& entry, const std::string& file) {
    ReportView& view = page.data.views[static_cast<size_t>(entry.view)];
    try {
        const ChannelImage image = read_image(page.folder + "/" + file);
        Image<float> visibility = mean_visibility(image);
        Image<std::uint8_t> mask = facing_mask(image);
        if (visibility.empty() || fmt::format("{}x{}", image.width, image.height) != view.size)
            throw InputError("not this view's");
        entry.visibility = std::move(visibility);
        if (entry.is_reference || view.mask.empty()) view.mask = std::move(mask);
        return true;
    } catch (const InputError&) {
        ++page.unreadable;
        return false;
    }
}

// Visibility takes from a tenth of a byte to more than one a pixel. The page's own budget holds to the byte; this one
// keeps a large study from reading more images than could ever fit.
constexpr size_t pixels_per_byte = 3;

void load_images(StudyPage& page) {
    const size_t most_pixels = page.options.image_budget * pixels_per_byte;
    size_t pixels = 0;
    std::set<int> with_reference;
    const auto load = [&](ReportEntry& entry, const std::string& file) {
        if (pixels > most_pixels || file.empty() || !load_image(page, entry, file)) return;
        pixels += entry.visibility.size();
    };
    int rank = 0;
    for (const size_t i : wanted_cells(page)) {
        if (pixels > most_pixels) break;
        ReportEntry& entry = page.data.entries[i];
        if (with_reference.insert(entry.view).second)
            for (size_t j = page.cells.size(); j < page.data.entries.size(); ++j)
                if (page.data.entries[j].view == entry.view)
                    load(page.data.entries[j], page.truths[static_cast<size_t>(entry.view)].file);
        entry.image_rank = rank++;
        load(entry, page.cells[i].visibility);
    }
}

void fill_words(StudyPage& page) {
    ReportData& data = page.data;
    std::set<std::string> cells, failed, techniques;
    for (const StudyCell& cell : page.cells) {
        cells.insert(cell.cell), techniques.insert(cell.technique);
        if (cell.status == "failed") failed.insert(cell.cell);
    }
    data.facts = {{"Cells", failed.empty() ? std::to_string(cells.size())
                                           : fmt::format("{}, {} of them failed", cells.size(), failed.size())},
                  {"Blocks", std::to_string(data.blocks.size())},
                  {"Techniques", std::to_string(techniques.size())},
                  {"Views", std::to_string(data.views.size())}};
    std::set<std::string> pictured, candidates;
    for (size_t i = 0; i < page.cells.size(); ++i) {
        if (is_pictured(page.cells[i])) candidates.insert(page.cells[i].cell);
        if (!data.entries[i].visibility.empty()) pictured.insert(page.cells[i].cell);
    }
    if (pictured.size() < candidates.size())
        data.notes.push_back(fmt::format("Images of {} of {} cells are on this page: of each technique and view first "
                                         "the cell with the lowest RMSE.",
                                         pictured.size(), candidates.size()));
    if (page.unreadable > 0)
        data.notes.push_back(fmt::format("{} images were missing, broken or of another size.", page.unreadable));
    std::error_code ignored;
    for (const char* name : {"study.json", "results.jsonl", "results.csv", "timings.jsonl", "claims.json"})
        if (fs::exists(fs::path(page.folder) / name, ignored)) data.links.push_back(page.prefix + name);
}

// Tables in a paper's arrangement and claims, where the study asks for any; scenes that were not there.
void fill_findings(StudyPage& page) {
    std::error_code ignored;
    if (!fs::is_regular_file(fs::path(page.folder) / study_plan_file, ignored)) return;
    const StudyStore store(page.folder);
    const StudyFindings findings = read_findings(store, read_study_plan(store));
    for (const SkippedScene& scene : findings.skipped)
        page.data.notes.push_back(
            fmt::format("The scene '{}' was skipped: {} is not there.", scene.name, scene.missing));
    if (!findings.questions.tables.empty() || !findings.questions.claims.empty())
        page.data.findings = findings_json(findings);
}

} // namespace

ReportData study_report(const std::string& folder, const std::string& page_path, const StudyReportOptions& options) {
    StudyPage page{folder, options, "", read_study_cells(folder), {}, {}, {}, 0};
    const fs::path study = fs::absolute(folder).lexically_normal();
    const fs::path relative = study.lexically_relative(fs::absolute(page_path).lexically_normal().parent_path());
    page.prefix = relative == "." || relative == "" ? "" : (relative / "").generic_string();
    page.data.kind = ReportData::Kind::Study;
    const fs::path name = study.has_filename() ? study.filename() : study.parent_path().filename();
    page.data.title = options.title.empty() ? name.string() : options.title;
    page.data.image_budget = options.image_budget;
    fill_entries(page);
    if (options.image_budget > 0) load_images(page);
    fill_words(page);
    fill_findings(page);
    return std::move(page.data);
}

} // namespace gnomon
