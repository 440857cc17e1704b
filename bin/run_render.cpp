// From a request to files: load, G-buffer, then technique by technique, each written as soon as it is done.

#include <algorithm>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "bin/layers.h"
#include "bin/report.h"
#include "bin/shade.h"
#include "bin/stats.h"
#include "bin/text.h"
#include "core/digest.h"
#include "core/interrupt.h"
#include "core/parallel.h"
#include "core/progress.h"

namespace gnomon {
namespace {

// What all techniques of a run share.
struct Rendering {
    const RenderRequest& request;
    const Stage& stage;
    Frame& frame;
    RunStats& stats;
    Image<vec3> base;                    // radiance without direct light
    std::vector<Image<vec3>> unshadowed; // direct light, one image a light
    float exposure = 1;
    std::unique_ptr<TruthState> state; // of a long run
    std::string run_digest;            // of what shares of one image have in common
};

class Step {
public:
    Step(RunStats& stats, std::string name) : stats_(stats), name_(std::move(name)) {}
    ~Step() { stats_.steps.push_back({name_, watch_.seconds()}); }
    Step(const Step&) = delete;
    Step& operator=(const Step&) = delete;

private:
    RunStats& stats_;
    std::string name_;
    Stopwatch watch_;
};

// Leaves out techniques of `-t all` that do not take one of the lights; for others that is an error.
std::vector<TechniqueRequest> supported(const RenderRequest& request, const std::vector<Light>& lights) {
    std::vector<TechniqueRequest> kept;
    for (const TechniqueRequest& technique : request.techniques) {
        const auto unsupported = std::find_if(lights.begin(), lights.end(), [&](const Light& light) {
            return !(technique.entry->info.lights & bit(light.type));
        });
        if (unsupported == lights.end())
            kept.push_back(technique);
        else if (!technique.from_all)
            check_support(*technique.entry, *unsupported);
        else if (!request.scene.quiet)
            print_message(fmt::format("note: skipped '{}', which does not support the {} light '{}'",
                                      technique.entry->info.id, light_type_name(unsupported->type), unsupported->name));
    }
    if (kept.empty()) throw UsageError("no technique is left that supports the light");
    return kept;
}

void prepare_shading(Rendering& rendering) {
    const Step step(rendering.stats, "unshadowed image");
    const GBuffer& gbuffer = rendering.frame.gbuffer();
    rendering.base = ambient_and_emission(gbuffer, rendering.request.ambient);
    const Image<float> lit(rendering.frame.width(), rendering.frame.height(), 1.0f);
    Image<vec3> all_lit = rendering.base;
    for (const Light& light : rendering.stage.lights) {
        Image<vec3> direct(rendering.frame.width(), rendering.frame.height(), vec3(0.0f));
        add_direct_light(direct, gbuffer, light, lit);
        for (size_t i = 0; i < direct.size(); ++i) all_lit.values()[i] += direct.values()[i];
        rendering.unshadowed.push_back(std::move(direct));
    }
    rendering.exposure = rendering.request.exposure_stops ? std::exp2(*rendering.request.exposure_stops)
                                                          : automatic_exposure(gbuffer, all_lit);
    rendering.stats.exposure = rendering.exposure;
}

void add_light(Image<vec3>& radiance, const Image<vec3>& unshadowed, const Visibility& visibility) {
    parallel_for(radiance.size(), 1 << 14, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            radiance.values()[i] += visibility.radiance ? visibility.radiance->values()[i]
                                                        : unshadowed.values()[i] * visibility.values.values()[i];
    });
}

Rendered render_technique(Rendering& rendering, const TechniqueRequest& technique, const OutputFiles& files) {
    Rendered rendered{technique, files, rendering.base, {}, rendering.stats.techniques.size()};
    double seconds = 0;
    for (size_t i = 0; i < rendering.stage.lights.size(); ++i) {
        Shaded shaded =
            shade_light(rendering.frame, rendering.stage, i, technique, files.label, rendering.request.progress);
        add_light(rendered.radiance, rendering.unshadowed[i], shaded.image.visibility);
        seconds += shaded.stats.seconds;
        rendered.images.push_back(std::move(shaded.image));
        rendering.stats.techniques.push_back(std::move(shaded.stats));
    }
    rendering.stats.steps.push_back({"technique " + files.label, seconds});
    return rendered;
}

std::map<std::string, Attribute> make_attributes(const Rendering& rendering, const TechniqueRequest& technique) {
    std::map<std::string, Attribute> attributes =
        share_attributes(rendering.frame.truth_run.share, rendering.run_digest);
    attributes.merge(image_attributes(rendering.stage, rendering.frame, technique));
    return attributes;
}

void write_images(Rendering& rendering, const Rendered& rendered) {
    const Step step(rendering.stats, "write " + rendered.files.label);
    const std::map<std::string, Attribute> attributes = make_attributes(rendering, rendered.technique);
    const OutputFiles& files = rendered.files;
    const std::string& any_path = files.exr.empty() ? files.png : files.exr;
    if (!files.exr.empty())
        write_exr(files.exr, make_layers(rendering.request, rendering.frame, rendering.stage.lights, rendered.radiance,
                                         rendered.images, attributes));
    if (rendering.request.debug_images && !any_path.empty())
        write_debug_images(any_path, rendering.frame, rendered.images, attributes);
    if (files.png.empty()) return;
    std::map<std::string, std::string> text;
    for (const auto& [name, value] : attributes)
        if (const auto* sentence = std::get_if<std::string>(&value)) text[name] = *sentence;
    write_exposed_png(files.png, rendered.radiance, rendering.exposure, text);
}

// The techniques with their files. With a report, its reference too: where it is none of them it gets a label and,
// unless the one technique's file was named, files of its own.
struct Work {
    std::vector<TechniqueRequest> techniques;
    std::vector<OutputFiles> files;
    size_t reference = 0;
};

Work plan_work(const RenderRequest& request, std::vector<TechniqueRequest> techniques,
               const std::vector<Light>& lights) {
    const auto ids_of = [](const std::vector<TechniqueRequest>& requests) {
        std::vector<std::string> ids;
        for (const TechniqueRequest& technique : requests) ids.push_back(technique.entry->info.id);
        return ids;
    };
    Work work{techniques, plan_outputs(request.output, ids_of(techniques)), 0};
    if (request.report.empty()) return work;
    const TechniqueRequest reference = choose_reference(request, lights);
    for (const Light& light : lights) check_support(*reference.entry, light);
    const auto found = std::find_if(techniques.begin(), techniques.end(), [&](const TechniqueRequest& technique) {
        return same_technique(technique, reference);
    });
    work.reference = static_cast<size_t>(found - techniques.begin());
    if (found != techniques.end()) return work;
    work.techniques.push_back(reference);
    if (can_hold_several(request.output))
        work.files = plan_outputs(request.output, ids_of(work.techniques));
    else
        work.files.push_back({reference.entry->info.id + "-reference", "", "", false});
    return work;
}

void render_all(Rendering& rendering, const Work& work) {
    make_folders(work.files);
    const bool reported = !rendering.request.report.empty();
    ReportBuilder report(rendering.request, rendering.stage, rendering.frame, rendering.exposure);
    const auto render = [&](size_t i) {
        const Rendered rendered = render_technique(rendering, work.techniques[i], work.files[i]);
        write_images(rendering, rendered);
        if (reported) report.add(rendered, rendering.stats);
    };
    if (reported) render(work.reference);
    for (size_t i = 0; i < work.techniques.size(); ++i)
        if (!reported || i != work.reference) render(i);
    if (!reported) return;
    const Step step(rendering.stats, "report");
    report.write();
}

// Opens the state of the one technique of a long run.
void begin_long_run(Rendering& rendering, const Work& work) {
    const RenderRequest& request = rendering.request;
    const TechniqueRequest& technique = work.techniques.front();
    const nlohmann::json parameters = parameters_json(technique.entry->parameters, technique.parameters);
    nlohmann::ordered_json identity =
        truth_identity(rendering.stage.scene, rendering.frame.receivers(), rendering.stage.lights);
    identity["version"] = GNOMON_VERSION;
    for (const char* key : {"pattern", "seed"}) identity[key] = parameters[key];
    identity["target error"] = parameters["target-error"] > 0 ? "on" : "off";
    Digest digest;
    digest.add_text(identity.dump());
    digest.add_text(parameters.dump());
    digest.add(request.ambient);
    rendering.run_digest = digest.text();
    const OutputFiles& files = work.files.front();
    make_folders(work.files);
    rendering.state =
        open_state(*request.long_run, files.exr.empty() ? files.png : files.exr, identity, request.scene.quiet);
    rendering.frame.truth_run.state = rendering.state.get();
    rendering.frame.truth_run.share = request.long_run->share;
}

void end_long_run(Rendering& rendering) {
    if (!rendering.state) return;
    if (rendering.request.long_run->keep_state)
        rendering.state->save();
    else
        rendering.state->remove();
}

void run(const RenderRequest& request) {
    RunStats stats;
    Stopwatch watch;
    const Stage stage = load_stage(request.scene);
    stats.steps.push_back({"load scene", watch.seconds()});
    const Work work = plan_work(request, supported(request, stage.lights), stage.lights);

    watch = {};
    Frame frame(stage.scene, stage.camera, request.size.x, request.size.y, request.primary);
    // With --primary ray the frame builds Embree's structures for itself.
    stats.gbuffer_seconds = watch.seconds() - frame.rays_seconds();
    stats.gbuffer = frame.gbuffer_log();
    stats.steps.push_back({"gbuffer", stats.gbuffer_seconds});
    stats.scene = stage.scene.name, stats.camera = stage.camera.name;
    stats.triangles = stage.scene.triangles.size(), stats.vertices = stage.scene.positions.size();
    stats.objects = stage.scene.objects.size();
    stats.width = request.size.x, stats.height = request.size.y;

    std::optional<InterruptScope> interruptible;
    Rendering rendering{request, stage, frame, stats, {}, {}, 1, nullptr, ""};
    prepare_shading(rendering);
    if (request.long_run) {
        begin_long_run(rendering, work);
        if (rendering.state) interruptible.emplace();
    }
    render_all(rendering, work);
    end_long_run(rendering);
    stats.steps.push_back({"adjacency", frame.adjacency_seconds()});
    stats.steps.push_back({"embree", frame.rays_seconds()});
    if (!request.stats.empty()) write_json(request.stats, stats_json(stats));
}

} // namespace

void run_render(const RenderRequest& request) {
    with_threads(request.threads, [&] { run(request); });
}

} // namespace gnomon
