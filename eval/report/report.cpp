#include "eval/report/report.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "core/atomic_file.h"
#include "core/error.h"
#include "eval/color_map.h"
#include "eval/flip.h"
#include "eval/metric/classes.h"
#include "eval/metrics.h"
#include "eval/report/embed.h"
#include "eval/report/template.h"

namespace gnomon {
namespace {

using Json = nlohmann::ordered_json;

Json metric_values(const std::vector<std::pair<std::string, double>>& values) {
    Json json = Json::object();
    for (const auto& [id, value] : values)
        if (!std::isnan(value)) json[id] = std::isfinite(value) ? Json(value) : Json("infinite");
    return json;
}

Json entry_json(const ReportEntry& entry, const EmbeddedImages& images) {
    return {
        {"block", entry.block},
        {"view", entry.view},
        {"id", entry.id},
        {"title", entry.title},
        {"kind", entry.kind},
        {"paper", entry.paper},
        {"parameters", entry.parameters},
        {"varied", entry.varied},
        {"passes", entry.passes},
        {"counters", entry.counters},
        {"seconds", entry.seconds},
        {"peak_bytes", entry.peak_bytes},
        {"links", entry.links},
        {"metrics",
         {{"visibility", metric_values(entry.visibility_metrics)}, {"shaded", metric_values(entry.shaded_metrics)}}},
        {"cell", entry.cell},
        {"status", entry.status},
        {"message", entry.message},
        {"shaded", images.shaded},
        {"visibility", images.visibility.png},
        {"levels", images.visibility.levels},
        {"range", {images.visibility.low, images.visibility.high}},
        {"flip", images.flip.png},
        {"flip_levels", images.flip.levels}};
}

// The metrics that some entry has, in the order in which they are listed everywhere; after them those that this program
// does not know, of which nothing but the name can be said.
Json metric_table(const ReportData& data) {
    std::set<std::string> present;
    for (const ReportEntry& entry : data.entries)
        for (const auto* values : {&entry.visibility_metrics, &entry.shaded_metrics})
            for (const auto& value : *values) present.insert(value.first);
    Json rows = Json::array();
    for (const Metric& metric : metrics())
        if (present.erase(metric.id) > 0)
            rows.push_back({{"id", metric.id},
                            {"title", metric.title},
                            {"formula", metric.formula},
                            {"range", metric.range},
                            {"blind_to", metric.blind_to},
                            {"lower_is_better", metric.lower_is_better}});
    for (const std::string& id : present)
        rows.push_back({{"id", id},
                        {"title", id},
                        {"formula", ""},
                        {"range", ""},
                        {"blind_to", ""},
                        {"lower_is_better", nullptr}});
    return rows;
}

// The size of each view's images; throws where they differ.
std::vector<std::pair<int, int>> view_sizes(const ReportData& data) {
    std::vector<std::pair<int, int>> sizes(data.views.size());
    const auto check = [&](const auto& image, size_t view, const std::string& what) {
        if (image.empty()) return;
        const std::pair<int, int> own{image.width(), image.height()};
        std::pair<int, int>& size = sizes[view];
        if (size.first == 0) size = own;
        if (own != size)
            throw UsageError(fmt::format("a report shows images of one size, but {} is {}x{} beside {}x{}", what,
                                         own.first, own.second, size.first, size.second));
    };
    for (const ReportEntry& entry : data.entries) {
        const auto view = static_cast<size_t>(entry.view);
        if (entry.view < 0 || view >= sizes.size() || entry.block < 0 ||
            static_cast<size_t>(entry.block) >= data.blocks.size())
            throw UsageError(fmt::format("the report's entry '{}' is in no view or block of it", entry.id));
        check(entry.shaded, view, fmt::format("the shaded image of '{}'", entry.id));
        check(entry.visibility, view, fmt::format("the visibility of '{}'", entry.id));
    }
    for (size_t view = 0; view < sizes.size(); ++view) check(data.views[view].mask, view, "the mask");
    return sizes;
}

std::vector<ReportEntry>::const_iterator reference_of(const ReportData& data, int view) {
    return std::find_if(data.entries.begin(), data.entries.end(),
                        [&](const ReportEntry& entry) { return entry.is_reference && entry.view == view; });
}

Json views_json(const ReportData& data) {
    const std::vector<std::pair<int, int>> sizes = view_sizes(data);
    Json views = Json::array();
    for (size_t i = 0; i < data.views.size(); ++i) {
        const ReportView& view = data.views[i];
        const auto reference = reference_of(data, static_cast<int>(i));
        views.push_back({{"scene", view.scene},
                         {"camera", view.camera},
                         {"light", view.light},
                         {"size", view.size},
                         {"truth", view.truth},
                         {"width", sizes[i].first},
                         {"height", sizes[i].second},
                         {"reference", reference == data.entries.end() ? -1 : reference - data.entries.begin()},
                         {"mask", view.mask.empty() ? "" : embed_mask(view.mask)}});
    }
    return views;
}

// What the reader should know of images that the page could not hold as they are.
std::vector<std::string> embedding_notes(const EmbeddedSet& set) {
    std::vector<std::string> notes;
    if (set.shaded_step > 1)
        notes.push_back(fmt::format("To keep this page small, shaded images are stored at 1/{} of their width and "
                                    "height; the files have all of them.",
                                    set.shaded_step));
    if (!set.flip) notes.push_back("To keep this page small, it has no FLIP maps; `gnomon compare` makes them.");
    if (set.levels < finest_levels)
        notes.push_back(fmt::format(
            "To keep this page small, visibility is stored in {} levels; the files have all of it.", set.levels));
    if (set.left_out > 0)
        notes.push_back(
            fmt::format("The images of {} entries did not fit this page; the files have them.", set.left_out));
    return notes;
}

// FLIP of each entry's visibility as grey light, as `compare --map-kind flip` has it; empty where there is nothing to
// compare.
std::vector<Image<float>> flip_maps(const ReportData& data) {
    std::vector<Image<float>> maps(data.entries.size());
    for (size_t i = 0; i < maps.size(); ++i) {
        const ReportEntry& entry = data.entries[i];
        const auto reference = reference_of(data, entry.view);
        if (reference == data.entries.end() || entry.is_reference || entry.visibility.empty() ||
            reference->visibility.empty())
            continue;
        const Image<float>*test = &entry.visibility, *truth = &reference->visibility;
        maps[i] =
            flip_map({{test, test, test}, {truth, truth, truth}, data.views[static_cast<size_t>(entry.view)].mask});
    }
    return maps;
}

// What the page needs to draw error maps as eval/error_map.h does.
Json color_maps() {
    return {{"signed", blue_white_red()}, {"magnitude", magma()}, {"false-color", blue_green_red()}, {"flip", magma()}};
}

Json thresholds() {
    return {{"umbra_up_to", umbra_up_to},
            {"lit_from", lit_from},
            {"leak_above", leak_above},
            {"false_shadow_below", false_shadow_below}};
}

Json report_json(const ReportData& data) {
    Json views = views_json(data); // checks what the images are to be
    const std::vector<Image<float>> flips = flip_maps(data);
    std::vector<ImagesToEmbed> wanted;
    for (size_t i = 0; i < data.entries.size(); ++i) {
        const ReportEntry& entry = data.entries[i];
        wanted.push_back({&entry.shaded, &entry.visibility, entry.is_reference ? 0 : 1 + entry.image_rank, &flips[i]});
    }
    const EmbeddedSet embedded = embed_images(wanted, data.image_budget);
    Json entries = Json::array();
    for (size_t i = 0; i < data.entries.size(); ++i) entries.push_back(entry_json(data.entries[i], embedded.images[i]));
    std::vector<std::string> notes = data.notes;
    for (std::string& note : embedding_notes(embedded)) notes.push_back(std::move(note));
    return {{"title", data.title},
            {"kind", data.kind == ReportData::Kind::Study ? "study" : "render"},
            {"facts", data.facts},
            {"notes", notes},
            {"command_lines", data.command_lines},
            {"links", data.links},
            {"parameter_units", data.parameter_units},
            {"blocks", data.blocks},
            {"color_maps", color_maps()},
            {"thresholds", thresholds()},
            {"findings", data.findings},
            {"metrics", metric_table(data)},
            {"views", std::move(views)},
            {"entries", std::move(entries)}};
}

void replace_once(std::string& text, std::string_view mark, std::string_view replacement) {
    const size_t at = text.find(mark);
    assert(at != std::string::npos);
    text.replace(at, mark.size(), replacement);
}

std::string escape_html(const std::string& text) {
    std::string escaped;
    for (const char letter : text) {
        if (letter == '&')
            escaped += "&amp;";
        else if (letter == '<')
            escaped += "&lt;";
        else if (letter == '>')
            escaped += "&gt;";
        else
            escaped += letter;
    }
    return escaped;
}

// JSON inside a script element: no text in it can end the element.
std::string script_safe(const Json& json) {
    std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    std::string safe;
    safe.reserve(text.size());
    for (const char letter : text) {
        if (letter == '<')
            safe += "\\u003c";
        else
            safe += letter;
    }
    return safe;
}

} // namespace

void name_differences(ReportData& data) {
    for (ReportEntry& entry : data.entries)
        for (const auto& item : entry.parameters.items()) {
            const auto differs = [&](const ReportEntry& other) {
                return other.id == entry.id && other.view == entry.view && other.parameters.contains(item.key()) &&
                       other.parameters[item.key()] != item.value();
            };
            if (std::any_of(data.entries.begin(), data.entries.end(), differs)) entry.varied[item.key()] = item.value();
        }
}

std::string report_page(const ReportData& data) {
    std::string page(report_html);
    replace_once(page, "{{style}}", report_style);
    replace_once(page, "{{script}}", report_script);
    replace_once(page, "{{data}}", script_safe(report_json(data)));
    replace_once(page, "{{title}}",
                 escape_html(data.title)); // its mark is the page's first: no text can stand in for it
    return page;
}

void write_report(const std::string& path, const ReportData& data) { write_text_file(path, report_page(data)); }

} // namespace gnomon
