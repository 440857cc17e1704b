// gnomon render: any number of techniques on one scene.

#include <memory>

#include <CLI/CLI.hpp>

#include "bin/commands.h"
#include "bin/render_options.h"

namespace gnomon {

void add_render_command(CLI::App& program, const std::string& command_line) {
    const auto options = std::make_shared<RenderOptions>();
    options->command_line = command_line;
    CLI::App* command = program.add_subcommand("render", "render a scene with one or more shadow techniques");
    command
        ->add_option("-t,--technique", options->techniques,
                     "a technique with its parameters, or 'all' that support the lights; may be repeated")
        ->type_name("ID[:key=value,...]")
        ->allow_extra_args(false)
        ->required();
    command
        ->add_option(
            "-o,--output", options->output,
            "image file, or for several techniques a folder (made if missing; ID.exr and ID.png go into it) or "
            "a name with {id} in it")
        ->type_name("OUT.exr|OUT.png|FOLDER")
        ->required();
    add_scene_options(*command, *options);
    add_image_options(*command, *options);
    command->add_option("--report", options->report, "measure every technique against the reference, as one page")
        ->type_name("FILE.html");
    command
        ->add_option("--reference", options->reference,
                     "what --report measures against (default: truth for area lights, raytraced for others)")
        ->type_name("ID[:key=value,...]");
    command->callback([options] { run_render(read_render_options(*options)); });
}

} // namespace gnomon
