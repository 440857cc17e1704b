// gnomon export: any scene as binary glTF, with the camera and light of the command line where they are given.

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/options.h"
#include "bin/outputs.h"
#include "core/error.h"

namespace gnomon {
namespace {

void export_scene(const SceneOptions& options, const std::string& output) {
    const SceneRequest request = read_scene_options(options);
    if (extension(output) != ".glb")
        throw UsageError(fmt::format("--output is '{}', but scenes are exported as .glb", output));
    check_writable(output);
    Stage stage = load_stage(request);
    if (request.look_from || request.look_at || request.fov || !request.camera.empty())
        stage.scene.cameras = {stage.camera};
    stage.scene.lights = stage.lights;
    export_glb(stage.scene, output);
}

} // namespace

void add_export_command(CLI::App& program) {
    struct ExportOptions : SceneOptions {
        std::string output;
    };
    const auto options = std::make_shared<ExportOptions>();
    CLI::App* command = program.add_subcommand("export", "write a scene as binary glTF, with its lights and cameras");
    command->add_option("-o,--output", options->output, "the file to write")->type_name("SCENE.glb")->required();
    add_scene_options(*command, *options);
    command->callback([options] { export_scene(*options, options->output); });
}

} // namespace gnomon
