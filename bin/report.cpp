#include "bin/report.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "eval/compare.h"

namespace gnomon {
namespace {

Image<std::uint8_t> any_light_mask(const Receivers& receivers, const std::vector<Light>& lights) {
    Image<std::uint8_t> mask(receivers.width(), receivers.height(), 0);
    for (const Light& light : lights) {
        const Image<float> own = light_mask(receivers, light);
        for (size_t i = 0; i < mask.size(); ++i)
            if (own.values()[i] > 0) mask.values()[i] = 1;
    }
    return mask;
}

Image<float> mean_visibility(const std::vector<LitImage>& images) {
    Image<float> mean = images.front().visibility.values;
    for (size_t light = 1; light < images.size(); ++light)
        for (size_t i = 0; i < mean.size(); ++i) mean.values()[i] += images[light].visibility.values.values()[i];
    if (images.size() > 1)
        for (float& value : mean.values()) value /= static_cast<float>(images.size());
    return mean;
}

std::vector<std::pair<std::string, double>> measure(const ChannelImage& test, const ChannelImage& reference,
                                                    const std::vector<std::string>& channels) {
    CompareOptions options;
    options.channels = channels;
    return compare(test, reference, options).metrics;
}

} // namespace

TechniqueRequest choose_reference(const RenderRequest& request, const std::vector<Light>& lights) {
    if (request.reference) return *request.reference;
    const bool area = std::any_of(lights.begin(), lights.end(), [](const Light& light) { return is_area(light); });
    return read_technique(area ? "truth" : "raytraced");
}

bool same_technique(const TechniqueRequest& a, const TechniqueRequest& b) {
    return a.entry == b.entry &&
           parameters_json(a.entry->parameters, a.parameters) == parameters_json(b.entry->parameters, b.parameters);
}

ReportBuilder::ReportBuilder(const RenderRequest& request, const Stage& stage, const Frame& frame, float exposure)
    : request_(request), stage_(stage), frame_(frame), exposure_(exposure) {
    const std::string size = fmt::format("{}x{}", frame.width(), frame.height());
    std::string lights;
    for (const Light& light : stage.lights)
        lights += fmt::format("{}{} ({})", lights.empty() ? "" : ", ", light.name, light_type_name(light.type));
    if (stage.lights.size() > 1) lights += "; visibility is the mean over the lights";
    data_.title = stage.scene.name;
    data_.facts = {{"Scene", stage.scene.name}, {"Camera", stage.camera.name}, {"Light", lights}, {"Images", size}};
    data_.command_lines = {request.command_line};
    data_.views = {
        {stage.scene.name, stage.camera.name, lights, size, "", any_light_mask(frame.receivers(), stage.lights)}};
}

std::string ReportBuilder::relative_to_report(const std::string& path) const {
    const std::filesystem::path folder = std::filesystem::absolute(request_.report).parent_path();
    return std::filesystem::absolute(path).lexically_relative(folder).generic_string();
}

void ReportBuilder::add(const Rendered& rendered, const RunStats& stats) {
    const TechniqueInfo& info = rendered.technique.entry->info;
    ReportEntry entry;
    entry.id = info.id, entry.title = info.title;
    entry.kind = technique_kind_name(info.kind), entry.paper = info.paper;
    entry.parameters = parameters_json(rendered.technique.entry->parameters, rendered.technique.parameters);
    for (const ParameterInfo& parameter : rendered.technique.entry->parameters)
        data_.parameter_units[parameter.name] = parameter.unit;
    entry.shaded = exposed_srgb(rendered.radiance, exposure_);
    entry.visibility = mean_visibility(rendered.images);
    for (size_t i = rendered.first_stats; i < rendered.first_stats + rendered.images.size(); ++i) {
        const TechniqueStats& light = stats.techniques[i];
        for (auto pass : passes_json(light.log)) {
            pass["name"] = light_channel(pass["name"], light.light, rendered.images.size());
            entry.passes.push_back(std::move(pass));
        }
        entry.seconds += light.seconds;
        entry.peak_bytes = std::max(entry.peak_bytes, light.log.memory->peak());
    }
    for (const std::string& path : {rendered.files.exr, rendered.files.png})
        if (!path.empty()) entry.links.push_back(relative_to_report(path));

    RenderRequest plain = request_; // the layers that are measured, and no others
    plain.aovs = {}, plain.debug_images = false;
    ChannelImage layers = make_layers(plain, frame_, stage_.lights, rendered.radiance, rendered.images, {});
    if (data_.entries.empty()) {
        entry.is_reference = true;
        reference_ = std::move(layers);
    } else {
        entry.visibility_metrics = measure(layers, reference_, {});
        entry.shaded_metrics = measure(layers, reference_, {"R", "G", "B"});
    }
    data_.entries.push_back(std::move(entry));
}

void ReportBuilder::write() {
    const ReportEntry& reference = data_.entries.front();
    data_.facts.emplace_back("Techniques", std::to_string(data_.entries.size() - 1));
    data_.facts.emplace_back("Reference", reference.title);
    if (std::filesystem::path stats = request_.stats; !stats.empty() && stats != "-")
        data_.links.push_back(relative_to_report(stats));
    name_differences(data_);
    write_report(request_.report, data_);
}

} // namespace gnomon
