// gnomon compare: two images, all the numbers.

#include <algorithm>
#include <cmath>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/error_map_file.h"
#include "bin/outputs.h"
#include "bin/stats.h"
#include "bin/text.h"
#include "core/error.h"
#include "core/parallel.h"
#include "eval/compare.h"

namespace gnomon {
namespace {

// As written by the user.
struct CompareCommandOptions {
    std::string test, reference;
    std::string metrics = "all", channels, json, map, map_kind = "signed", threads = "0";
    std::vector<std::string> fail_above, fail_below;
    bool no_mask = false;
};

struct Bound {
    std::string metric;
    double value = 0;
    bool above = true; // crossed where the metric is above
};

std::vector<std::string> metric_names() {
    std::vector<std::string> names;
    for (const Metric& metric : metrics()) names.push_back(metric.id);
    return names;
}

void check_metric(const std::string& id) {
    if (id != "all" && !find_metric(id))
        throw UsageError(fmt::format("there is no metric '{}'{} (gnomon list metrics shows them)", id,
                                     did_you_mean(id, metric_names())));
}

void read_bounds(const std::vector<std::string>& texts, bool above, std::vector<Bound>& bounds) {
    const std::string option = above ? "--fail-above" : "--fail-below";
    for (const std::string& text : texts) {
        const size_t equals = text.find('=');
        if (equals == std::string::npos)
            throw UsageError(fmt::format("{} is '{}', but must be METRIC=NUMBER, such as rmse=0.05", option, text));
        const std::string metric = text.substr(0, equals);
        if (!find_metric(metric)) check_metric(metric == "all" ? "'all'" : metric);
        bounds.push_back({metric, parse_real(text.substr(equals + 1), option + " " + metric, -1e30, 1e30), above});
    }
}

std::string value_text(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : "infinite"; }

void print_table(const Comparison& comparison, const std::vector<std::string>& shown) {
    std::vector<std::vector<std::string>> rows;
    for (const auto& [id, value] : comparison.metrics)
        if (shown.empty() || std::find(shown.begin(), shown.end(), id) != shown.end())
            rows.push_back({id, value_text(value), find_metric(id)->title});
    print(fmt::format("{} against {}\n{} of {} pixels, channels {}{}\n\n", comparison.test, comparison.reference,
                      comparison.masked, comparison.pixels, fmt::join(comparison.channels, ", "),
                      comparison.missing ? fmt::format(", {} not finite and left out", comparison.missing) : "") +
          aligned(rows));
}

void check_bounds(const Comparison& comparison, const std::vector<Bound>& bounds) {
    std::string crossed;
    for (const Bound& bound : bounds) {
        const auto found = std::find_if(comparison.metrics.begin(), comparison.metrics.end(),
                                        [&](const auto& row) { return row.first == bound.metric; });
        if (found == comparison.metrics.end())
            throw InputError(fmt::format("the bound on '{}' cannot be tested: it does not apply to '{}' and '{}'",
                                         bound.metric, comparison.test, comparison.reference));
        if (bound.above ? found->second > bound.value : found->second < bound.value)
            crossed += fmt::format("{}{} is {}, {} the bound {}", crossed.empty() ? "" : "; ", bound.metric,
                                   value_text(found->second), bound.above ? "above" : "below", bound.value);
    }
    if (!crossed.empty()) throw Error(ExitCode::BoundCrossed, crossed);
}

void check_targets(const CompareCommandOptions& options) {
    if (!options.json.empty() && options.json != "-") check_writable(options.json);
    if (options.map.empty()) return;
    if (extension(options.map) != ".png")
        throw UsageError(fmt::format("--map is '{}', but error maps are written as .png", options.map));
    check_writable(options.map);
}

void run_compare(const CompareCommandOptions& options) {
    CompareOptions request;
    request.test_name = options.test, request.reference_name = options.reference;
    std::vector<std::string> shown;
    for (const std::string& id : split(options.metrics, ',')) {
        check_metric(id);
        shown.push_back(id);
    }
    if (std::find(shown.begin(), shown.end(), "all") != shown.end()) shown.clear();
    std::vector<Bound> bounds;
    read_bounds(options.fail_above, true, bounds);
    read_bounds(options.fail_below, false, bounds);
    request.metrics = shown;
    if (!shown.empty())
        for (const Bound& bound : bounds) request.metrics.push_back(bound.metric);
    if (!options.channels.empty()) request.channels = split(options.channels, ',');
    if (options.no_mask) request.mask_source = MaskSource::None;
    const size_t kind = parse_choice(options.map_kind, "--map-kind", {"signed", "magnitude"});
    check_targets(options);

    const ChannelImage test = read_image(options.test), reference = read_image(options.reference);
    const Comparison comparison = compare(test, reference, request);
    if (!options.json.empty()) write_json(options.json, comparison_json(comparison));
    if (!options.map.empty())
        write_error_map(options.map, test, reference, comparison.channels, !options.no_mask,
                        kind == 0 ? ErrorMapKind::Signed : ErrorMapKind::Magnitude);
    if (options.json != "-") print_table(comparison, shown);
    check_bounds(comparison, bounds);
}

} // namespace

void add_compare_command(CLI::App& program) {
    const auto options = std::make_shared<CompareCommandOptions>();
    CLI::App* command = program.add_subcommand("compare", "measure an image against a reference");
    command->add_option("test", options->test, "the image to measure")->type_name("TEST")->required();
    command->add_option("reference", options->reference, "what it should be")->type_name("REFERENCE")->required();
    command->add_option("--metrics", options->metrics, "which numbers; `gnomon list metrics` shows them")
        ->type_name("all|LIST")
        ->capture_default_str();
    command
        ->add_option("--channels", options->channels,
                     "which channels (default: visibility where both have it, else R,G,B, else Y)")
        ->type_name("LIST");
    command->add_flag("--no-mask", options->no_mask,
                      "measure all pixels, not only those that face the light (channel M)");
    command->add_option("--json", options->json, "the numbers as JSON; - is standard output")->type_name("FILE.json|-");
    command->add_option("--map", options->map, "a picture of where the error is")->type_name("FILE.png");
    command->add_option("--map-kind", options->map_kind, "blue under and red over, or the size of the error only")
        ->type_name("signed|magnitude")
        ->capture_default_str();
    command->add_option("--fail-above", options->fail_above, "exit 1 where the metric is above; may be repeated")
        ->type_name("METRIC=NUMBER")
        ->allow_extra_args(false);
    command->add_option("--fail-below", options->fail_below, "exit 1 where the metric is below; may be repeated")
        ->type_name("METRIC=NUMBER")
        ->allow_extra_args(false);
    command->add_option("--threads", options->threads, "0 to 1024; 0 is all cores; results do not depend on it")
        ->type_name("N")
        ->capture_default_str();
    command->callback([options] {
        with_threads(parse_integer(options->threads, "--threads", 0, 1024), [&] { run_compare(*options); });
    });
}

} // namespace gnomon
