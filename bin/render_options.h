#pragma once
// What render and truth have in common: which images of the scene are made, how they are shaded and which files they go
// to.

#include <optional>
#include <string>
#include <vector>

#include "bin/long_run.h"
#include "bin/options.h"
#include "bin/outputs.h"
#include "techniques/technique.h"

namespace gnomon {

// As written by the user; empty where not given.
struct RenderOptions : SceneOptions {
    std::vector<std::string> techniques; // ID[:key=value,...] or "all"
    std::string output;
    std::string size = "1280x720", threads = "0", primary = "raster";
    std::string aov, exposure = "auto", ambient = "0";
    bool debug_images = false;
    std::string stats, report, reference;
    std::string command_line; // as the report shows it
    std::string progress = "auto";
};
void add_image_options(CLI::App& command, RenderOptions& options); // all but techniques, report and reference

// Images of the G-buffer that can be added to the EXR.
struct Aovs {
    bool depth = false, position = false, geometric_normal = false, shading_normal = false, albedo = false, id = false;
};

struct TechniqueRequest {
    const Entry* entry = nullptr;
    ParameterText parameters;
    bool from_all = false; // left out without an error where it does not support the light
};
// Throws UsageError for an unknown technique or parameter, or a value out of range.
TechniqueRequest read_technique(const std::string& specification);
Primary parse_primary(const std::string& text, const std::string& what);
bool read_progress(const std::string& text, bool quiet); // of --progress: whether to draw it

struct RenderRequest {
    SceneRequest scene;
    std::vector<TechniqueRequest> techniques;
    std::string output;
    ivec2 size{1280, 720};
    int threads = 0;
    Primary primary = Primary::Raster;
    Aovs aovs;
    bool debug_images = false;
    std::optional<float> exposure_stops; // none: chosen from the unshadowed image
    vec3 ambient{0.0f};                  // W/m²
    std::string stats, report, command_line;
    std::optional<TechniqueRequest> reference;
    bool progress = false;
    std::optional<LongRun> long_run; // gnomon truth
};
// Reads everything that can be read without touching a file but for trying out where results go. Throws UsageError,
// InputError.
RenderRequest read_render_options(const RenderOptions& options);

// Renders and writes all that is asked for.
void run_render(const RenderRequest& request);

} // namespace gnomon
