// gnomon truth: the technique 'truth' under a name of its own.

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/render_options.h"

namespace gnomon {

void add_truth_command(CLI::App& program) {
    struct TruthOptions : RenderOptions {
        ParameterText parameters;
    };
    const auto options = std::make_shared<TruthOptions>();
    CLI::App* command = program.add_subcommand("truth", "the ground truth: area-light visibility by ray tracing");
    for (const ParameterInfo& info : find_technique("truth").parameters) {
        std::string help = info.help;
        if (info.choices.empty()) help += fmt::format(" ({} to {})", info.minimum, info.maximum);
        std::string& value = options->parameters[info.name] = info.default_text;
        command->add_option("--" + info.name, value, help)
            ->type_name(info.choices.empty() ? "N" : fmt::format("{}", fmt::join(info.choices, "|")))
            ->capture_default_str();
    }
    command->add_option("-o,--output", options->output, "image file")->type_name("TRUTH.exr")->required();
    add_scene_options(*command, *options);
    add_image_options(*command, *options);
    command->callback([options] {
        std::string specification = "truth:";
        for (const auto& [name, value] : options->parameters) specification += name + "=" + value + ",";
        specification.pop_back();
        options->techniques = {specification};
        run_render(read_render_options(*options));
    });
}

} // namespace gnomon
