// gnomon truth: the technique 'truth' under a name of its own, with what long runs need.

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/long_run.h"
#include "bin/render_options.h"

namespace gnomon {
namespace {

struct TruthOptions : RenderOptions {
    ParameterText parameters;
    LongRunOptions long_run;
    std::vector<std::string> merge;
    bool no_shortcuts = false;
};

void add_parameters(CLI::App& command, TruthOptions& options) {
    for (const ParameterInfo& info : find_technique("truth").parameters) {
        std::string help = info.help;
        if (info.choices.empty()) help += fmt::format(" ({} to {})", info.minimum, info.maximum);
        std::string& value = options.parameters[info.name] = info.default_text;
        command.add_option("--" + info.name, value, help)
            ->type_name(info.choices.empty() ? "N" : fmt::format("{}", fmt::join(info.choices, "|")))
            ->capture_default_str();
    }
}

// The exact method takes no samples, and is one go over the whole image.
void check_exact(const CLI::App& command, const LongRunOptions& long_run) {
    for (const char* option : {"--samples", "--pattern", "--seed"})
        if (command.count(option) > 0)
            throw UsageError(fmt::format("{} does not go with --method exact, which takes no samples", option));
    for (const auto& [given, option] :
         {std::pair(long_run.resume, "--resume"), std::pair(long_run.keep_state, "--keep-state"),
          std::pair(!long_run.tiles.empty(), "--tiles")})
        if (given)
            throw UsageError(fmt::format(
                "{} does not go with --method exact, which neither keeps a state nor makes shares of an image",
                option));
}

void run(const CLI::App& command, TruthOptions& options) {
    if (!options.merge.empty()) {
        if (extension(options.output) != ".exr")
            throw UsageError(fmt::format("--output is '{}', but --merge writes an .exr", options.output));
        check_writable(options.output);
        return merge_shares(options.merge, options.output);
    }
    if (options.no_shortcuts) options.parameters["shortcuts"] = "off";
    std::string specification = "truth:";
    for (const auto& [name, value] : options.parameters) specification += name + "=" + value + ",";
    specification.pop_back();
    options.techniques = {specification};
    const LongRun long_run = read_long_run_options(options.long_run);
    if (long_run.share.parts > 1 && (can_hold_several(options.output) || extension(options.output) != ".exr"))
        throw UsageError(
            fmt::format("--output is '{}', but a share of an image is written as one .exr", options.output));
    const bool exact = options.parameters["method"] == "exact";
    if (exact) check_exact(command, options.long_run);
    RenderRequest request = read_render_options(options);
    if (!exact) request.long_run = long_run;
    run_render(request);
}

} // namespace

void add_truth_command(CLI::App& program) {
    const auto options = std::make_shared<TruthOptions>();
    CLI::App* command = program.add_subcommand("truth", "the ground truth: area-light visibility by ray tracing");
    add_parameters(*command, *options);
    command->add_flag("--no-shortcuts", options->no_shortcuts, "the same as --shortcuts off");
    command->add_option("-o,--output", options->output, "image file")->type_name("TRUTH.exr")->required();
    add_scene_options(*command, *options);
    add_image_options(*command, *options);
    add_long_run_options(*command, options->long_run);
    command->add_option("--merge", options->merge, "put the shares of an image together, and do nothing else")
        ->type_name("SHARE.exr...")
        ->group("Long runs");
    command->callback([command, options] { run(*command, *options); });
}

} // namespace gnomon
