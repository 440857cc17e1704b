// gnomon compare: two images, or two sequences of them, all the numbers.

#include <algorithm>
#include <array>
#include <exception>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/bounds.h"
#include "bin/commands.h"
#include "bin/frames.h"
#include "bin/mask_options.h"
#include "bin/outputs.h"
#include "bin/stats.h"
#include "bin/text.h"
#include "core/error.h"
#include "core/parallel.h"
#include "eval/error_map.h"
#include "eval/sequence.h"

namespace gnomon {
namespace {

// As written by the user.
struct CompareCommandOptions {
    std::string test, reference;
    std::string metrics = "all", channels, json, map, map_kind = "signed", map_range = "auto", thresholds,
                threads = "0";
    std::vector<std::string> fail_above, fail_below, masks;
    bool visibility = false, no_mask = false;
};

struct CompareRequest {
    CompareOptions options;
    MaskRequest masks;
    std::vector<std::string> shown; // metrics; empty: all
    std::vector<Bound> bounds;
    ErrorMapOptions map;
};

std::vector<std::string> map_kinds() {
    std::vector<std::string> names;
    for (int kind = 0; kind < error_map_kinds; ++kind)
        names.emplace_back(error_map_kind_name(static_cast<ErrorMapKind>(kind)));
    return names;
}

void check_targets(const CompareCommandOptions& options) {
    if (!options.json.empty() && options.json != "-") check_writable(options.json);
    if (options.map.empty()) return;
    if (extension(options.map) != ".png" && extension(options.map) != ".exr")
        throw UsageError(fmt::format("--map is '{}', but error maps are written as .png or .exr", options.map));
    check_writable(options.map);
}

CompareRequest read_request(const CompareCommandOptions& options) {
    CompareRequest request;
    request.options.test_name = options.test, request.options.reference_name = options.reference;
    for (const std::string& id : split(options.metrics, ',')) {
        check_metric(id);
        request.shown.push_back(id);
    }
    if (std::find(request.shown.begin(), request.shown.end(), "all") != request.shown.end()) request.shown.clear();
    read_bounds(options.fail_above, true, request.bounds);
    read_bounds(options.fail_below, false, request.bounds);
    if (!options.thresholds.empty()) read_bounds_file(options.thresholds, request.bounds);
    request.options.metrics = request.shown;
    if (!request.shown.empty())
        for (const Bound& bound : request.bounds)
            if (find_metric(bound.metric)) request.options.metrics.push_back(bound.metric);
    if (!options.channels.empty()) request.options.channels = split(options.channels, ',');
    request.options.as_visibility = options.visibility;
    if (options.no_mask) request.options.mask_source = MaskSource::None;
    request.masks = read_masks(options.masks);
    request.options.only_penumbra = request.masks.penumbra;
    request.map.kind = static_cast<ErrorMapKind>(parse_choice(options.map_kind, "--map-kind", map_kinds()));
    if (options.map_range != "auto")
        request.map.range = static_cast<float>(parse_real(options.map_range, "--map-range", 1e-30, 1e30));
    check_targets(options);
    return request;
}

void print_table(const Comparison& comparison, const std::vector<std::string>& shown, size_t frames) {
    std::vector<std::vector<std::string>> rows;
    for (const auto& [id, value] : comparison.metrics)
        if (shown.empty() || std::find(shown.begin(), shown.end(), id) != shown.end())
            rows.push_back({id, value_text(value), find_metric(id)->title});
    print(fmt::format("{} against {}\n{}{} of {} pixels, channels {}{}\n\n", comparison.test, comparison.reference,
                      frames ? fmt::format("{} frames, ", frames) : "", comparison.masked, comparison.pixels,
                      fmt::join(comparison.channels, ", "),
                      comparison.missing ? fmt::format(", {} not finite and left out", comparison.missing) : "") +
          aligned(rows));
}

// The picture, or the numbers that it shows with the mask that they hold in.
void write_map(const std::string& path, const ChannelImage& test, const ChannelImage& reference,
               CompareRequest& request) {
    const ComparedValues compared = compared_values(test, reference, request.options);
    const ErrorMapKind kind = request.map.kind;
    auto [values, what] = kind == ErrorMapKind::Flip
                              ? compared_flip(test, reference, request.options)
                              : MapValues{error_values(kind, compared.test, compared.reference), compared.what};
    if (extension(path) == ".png") {
        request.map.title = what;
        return write_png(path, draw_error_values(values, compared.reference, compared.mask, request.map));
    }
    ChannelImage numbers;
    numbers.attributes = {{"gnomon:map", std::string(error_map_kind_name(kind))}};
    numbers.add(kind == ErrorMapKind::Flip ? "flip" : "error", std::move(values));
    Image<float> mask(test.width, test.height, 1.0f);
    if (!compared.mask.empty())
        for (size_t i = 0; i < mask.size(); ++i) mask.values()[i] = compared.mask.values()[i];
    numbers.add("M", std::move(mask));
    write_exr(path, numbers);
}

void report(const CompareCommandOptions& options, const CompareRequest& request, const Comparison& comparison,
            const nlohmann::ordered_json& json, size_t frames) {
    if (!options.json.empty()) write_json(options.json, json);
    if (options.json != "-") print_table(comparison, request.shown, frames);
    check_bounds(comparison, request.bounds);
}

// Both at once: decoding takes longer than most metrics. Where neither can be read, the error is the test's.
std::pair<ChannelImage, ChannelImage> read_images(const std::string& test, const std::string& reference) {
    std::array<ChannelImage, 2> images;
    std::array<std::exception_ptr, 2> errors;
    parallel_for(2, 1, [&](size_t i, size_t) {
        try {
            images[i] = read_image(i == 0 ? test : reference);
        } catch (...) {
            errors[i] = std::current_exception();
        }
    });
    for (const std::exception_ptr& error : errors)
        if (error) std::rethrow_exception(error);
    match_encodings(images[0], images[1]);
    return {std::move(images[0]), std::move(images[1])};
}

void compare_sequences(const CompareCommandOptions& options, const CompareRequest& request) {
    if (!options.map.empty()) throw UsageError("--map goes with two images, not with sequences of them");
    SequenceComparer comparer(request.options);
    for (const FramePair& frame : pair_frames(options.test, options.reference)) {
        const auto [test, reference] = read_images(frame.test, frame.reference);
        comparer.add(frame.name, frame.test, test, frame.reference, reference,
                     make_mask(request.masks, frame.test, test, frame.reference, reference));
    }
    const SequenceComparison sequence = comparer.finish();
    report(options, request, sequence.whole, sequence_json(sequence), sequence.frames.size());
}

void compare_images(const CompareCommandOptions& options, CompareRequest& request) {
    const auto [test, reference] = read_images(options.test, options.reference);
    request.options.mask = make_mask(request.masks, options.test, test, options.reference, reference);
    const Comparison comparison = compare(test, reference, request.options);
    if (!options.map.empty()) write_map(options.map, test, reference, request);
    report(options, request, comparison, comparison_json(comparison), 0);
}

void run_compare(const CompareCommandOptions& options) {
    CompareRequest request = read_request(options);
    if (is_sequence(options.test) || is_sequence(options.reference))
        compare_sequences(options, request);
    else
        compare_images(options, request);
}

void add_selection_options(CLI::App& command, CompareCommandOptions& options) {
    command.add_option("--metrics", options.metrics, "which numbers; `gnomon list metrics` shows them")
        ->type_name("all|LIST")
        ->capture_default_str();
    command
        .add_option("--channels", options.channels,
                    "which channels or layers, NAME or TEST_NAME=REFERENCE_NAME (default: visibility where both have "
                    "it, else R,G,B, else Y)")
        ->type_name("LIST");
    command.add_flag("--visibility", options.visibility,
                     "the channels are visibilities (1 lit, 0 umbra), whatever they are called");
    command.add_flag("--no-mask", options.no_mask,
                     "do not leave out what the images' channels M leave out: receivers that do not face the light");
    command
        .add_option(
            "--mask", options.masks,
            "measure only there; may be repeated: the reference's penumbra, a rectangle in pixels from the left "
            "and the top, ids of the layer id or another, an image from one half upwards")
        ->type_name("penumbra|rect:X,Y,W,H|id:[LAYER=]N,...|file:NAME")
        ->allow_extra_args(false);
}

void add_output_options(CLI::App& command, CompareCommandOptions& options) {
    command.add_option("--json", options.json, "the numbers as JSON; - is standard output")->type_name("FILE.json|-");
    command.add_option("--map", options.map, "where the error is: a picture, or the numbers")
        ->type_name("FILE.png|FILE.exr");
    command
        .add_option("--map-kind", options.map_kind,
                    "blue under and red over; size in magma; FLIP; leaks and false shadows over the reference; size in "
                    "the false colours of papers")
        ->type_name(fmt::format("{}", fmt::join(map_kinds(), "|")))
        ->capture_default_str();
    command.add_option("--map-range", options.map_range, "the error at the end of the colour bar")
        ->type_name("auto|NUMBER")
        ->capture_default_str();
}

void add_gate_options(CLI::App& command, CompareCommandOptions& options) {
    command.add_option("--fail-above", options.fail_above, "exit 1 where the metric is above; may be repeated")
        ->type_name("METRIC=NUMBER")
        ->allow_extra_args(false);
    command
        .add_option("--fail-below", options.fail_below,
                    "exit 1 where the metric is below, for those where higher is better; may be repeated")
        ->type_name("METRIC=NUMBER")
        ->allow_extra_args(false);
    command
        .add_option("--thresholds", options.thresholds,
                    "more of both from a file: {\"fail_above\": {\"rmse\": 0.05}, \"fail_below\": {\"ssim\": 0.9}}")
        ->type_name("FILE.json");
}

} // namespace

void add_compare_command(CLI::App& program) {
    const auto options = std::make_shared<CompareCommandOptions>();
    CLI::App* command = program.add_subcommand("compare", "measure images against references");
    command
        ->add_option("test", options->test,
                     "the image to measure; a sequence is a folder or a name with #### for the frame's number")
        ->type_name("TEST")
        ->required();
    command->add_option("reference", options->reference, "what it should be")->type_name("REFERENCE")->required();
    add_selection_options(*command, *options);
    add_output_options(*command, *options);
    add_gate_options(*command, *options);
    command->add_option("--threads", options->threads, "0 to 1024; 0 is all cores; results do not depend on it")
        ->type_name("N")
        ->capture_default_str();
    command->callback([options] {
        with_threads(parse_integer(options->threads, "--threads", 0, 1024), [&] { run_compare(*options); });
    });
}

} // namespace gnomon
