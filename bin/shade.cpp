#include "bin/shade.h"

#include "core/progress.h"

namespace gnomon {

Shaded shade_light(Frame& frame, const Stage& stage, size_t light, const TechniqueRequest& technique,
                   const std::string& label, bool show_progress) {
    frame.truth_run.light_index = static_cast<std::uint32_t>(light);
    frame.begin_technique();
    const std::int64_t pixels = std::int64_t{frame.width()} * frame.height();
    Progress progress(label, pixels, show_progress);
    frame.progress = &progress;
    const double shared_before = frame.adjacency_seconds() + frame.rays_seconds();
    const Stopwatch watch;
    const std::unique_ptr<Technique> instance = technique.entry->make(technique.parameters);
    LitImage image{stage.lights[light].name, run_technique(*technique.entry, *instance, frame, stage.lights[light])};
    const double shared = frame.adjacency_seconds() + frame.rays_seconds() - shared_before;
    progress.advance(pixels); // most techniques do not report
    frame.progress = nullptr;
    TechniqueStats stats{label,
                         technique.entry->info.id,
                         image.light,
                         parameters_json(technique.entry->parameters, technique.parameters),
                         watch.seconds() - shared,
                         frame.log()};
    return {std::move(image), std::move(stats)};
}

std::map<std::string, Attribute> image_attributes(const Stage& stage, const Frame& frame,
                                                  const TechniqueRequest& technique) {
    std::string lights;
    for (const Light& light : stage.lights) lights += (lights.empty() ? "" : ", ") + light.name;
    nlohmann::json parameters = parameters_json(technique.entry->parameters, technique.parameters);
    if (parameters.value("method", "") == "exact")
        for (const char* unused : {"samples", "pattern", "seed"}) parameters.erase(unused);
    const dmat4 view = view_matrix(stage.camera);
    return {{"gnomon:version", GNOMON_VERSION},
            {"gnomon:scene", stage.scene.name},
            {"gnomon:camera", stage.camera.name},
            {"gnomon:light", lights},
            {"gnomon:technique", technique.entry->info.id},
            {"gnomon:parameters", parameters.dump()},
            {"samplesPerPixel", parameters.contains("samples") ? parameters["samples"].get<int>() : 1},
            {"worldToCamera", mat4(view)},
            {"worldToNDC", mat4(projection_matrix(stage.camera, frame.aspect()) * view)}};
}

} // namespace gnomon
