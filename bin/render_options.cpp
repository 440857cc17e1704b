#include "bin/render_options.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/text.h"
#include "core/error.h"
#include "core/progress.h"

namespace gnomon {
namespace {

struct AovName {
    const char* name;
    bool Aovs::*member;
};
constexpr AovName aov_names[] = {
    {"Z", &Aovs::depth},           {"P", &Aovs::position},    {"N", &Aovs::geometric_normal},
    {"Ns", &Aovs::shading_normal}, {"albedo", &Aovs::albedo}, {"id", &Aovs::id},
};

Aovs read_aovs(const std::string& text) {
    Aovs aovs;
    if (text.empty()) return aovs;
    std::vector<std::string> names = {"all"};
    for (const AovName& row : aov_names) names.emplace_back(row.name);
    for (const std::string& word : split(text, ',')) {
        const size_t choice = parse_choice(word, "--aov", names);
        for (size_t i = 0; i < std::size(aov_names); ++i)
            if (choice == 0 || choice == i + 1) aovs.*aov_names[i].member = true;
    }
    return aovs;
}

vec3 read_ambient(const std::string& text) {
    const vec3 value = text.find(',') == std::string::npos
                           ? vec3(static_cast<float>(parse_real(text, "--ambient", 0, 1e30)))
                           : parse_vec3(text, "--ambient");
    if (value.x < 0 || value.y < 0 || value.z < 0)
        throw UsageError(fmt::format("--ambient is '{}', but must not be negative", text));
    return value;
}

std::vector<TechniqueRequest> read_techniques(const std::vector<std::string>& specifications) {
    std::vector<TechniqueRequest> requests;
    for (const std::string& specification : specifications)
        if (specification == "all")
            for (const Entry& entry : techniques()) requests.push_back({&entry, {}, true});
        else
            requests.push_back(read_technique(specification));
    return requests;
}

void check_files(const RenderRequest& request) {
    std::vector<std::string> ids;
    for (const TechniqueRequest& technique : request.techniques) ids.push_back(technique.entry->info.id);
    const std::vector<OutputFiles> plan = plan_outputs(request.output, ids);
    check_writable(plan);
    if (!request.stats.empty() && request.stats != "-") check_writable_beside(plan, request.stats);
    if (request.report.empty()) return;
    if (extension(request.report) != ".html")
        throw UsageError(fmt::format("--report is '{}', but a report is written as .html", request.report));
    check_writable_beside(plan, request.report);
}

} // namespace

void add_image_options(CLI::App& command, RenderOptions& options) {
    const auto text = [&](const char* name, std::string& value, const char* type, const char* help) {
        return command.add_option(name, value, help)->type_name(type)->group("Image");
    };
    const std::string sides = fmt::format("width and height in pixels, each 1 to {}", max_image_side);
    text("--size", options.size, "WxH", sides.c_str())->capture_default_str();
    text("--primary", options.primary, "raster|ray", "how the camera's G-buffer is made")->capture_default_str();
    text("--exposure", options.exposure, "auto|STOPS",
         "of the PNG; auto maps the 99th percentile of the unshadowed image's luminance to 0.9")
        ->capture_default_str();
    text("--ambient", options.ambient, "E|R,G,B", "irradiance added everywhere, W/m2, 0 or more")
        ->capture_default_str();
    text("--aov", options.aov, "all|LIST", "images of the G-buffer to add to the EXR: Z,P,N,Ns,albedo,id");
    command.add_flag("--debug-images", options.debug_images, "add what techniques show of their insides as EXR layers")
        ->group("Image");
    command.add_option("--threads", options.threads, "0 to 1024; 0 is all cores; results do not depend on it")
        ->type_name("N")
        ->capture_default_str();
    command.add_option("--stats", options.stats, "counters, memory and times as JSON; - is standard output")
        ->type_name("FILE.json|-");
    command.add_option("--progress", options.progress, "progress on standard error; auto: where it is a terminal")
        ->type_name("auto|on|off")
        ->capture_default_str();
}

bool read_progress(const std::string& text, bool quiet) {
    const size_t choice = parse_choice(text, "--progress", {"auto", "on", "off"});
    return !quiet && (choice == 1 || (choice == 0 && standard_error_is_terminal()));
}

Primary parse_primary(const std::string& text, const std::string& what) {
    return parse_choice(text, what, {"raster", "ray"}) == 0 ? Primary::Raster : Primary::Ray;
}

TechniqueRequest read_technique(const std::string& specification) {
    const Specification parsed = parse_specification(specification);
    const Entry& entry = find_technique(parsed.name);
    entry.make(parsed.parameters); // for its errors
    return {&entry, parsed.parameters, false};
}

RenderRequest read_render_options(const RenderOptions& options) {
    RenderRequest request;
    request.size = parse_size(options.size, "--size");
    request.threads = parse_integer(options.threads, "--threads", 0, 1024);
    request.primary = parse_primary(options.primary, "--primary");
    request.aovs = read_aovs(options.aov);
    request.debug_images = options.debug_images;
    if (options.exposure != "auto")
        request.exposure_stops = static_cast<float>(parse_real(options.exposure, "--exposure (stops)", -60, 60));
    request.ambient = read_ambient(options.ambient);
    request.progress = read_progress(options.progress, options.quiet);
    request.scene = read_scene_options(options);
    request.techniques = read_techniques(options.techniques);
    if (!options.reference.empty()) {
        if (options.report.empty()) throw UsageError("--reference goes with --report");
        request.reference = read_technique(options.reference);
    }
    request.output = options.output;
    request.stats = options.stats;
    request.report = options.report;
    request.command_line = options.command_line;
    check_files(request);
    return request;
}

} // namespace gnomon
