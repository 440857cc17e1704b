#include "bin/layers.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "core/parallel.h"

namespace gnomon {
namespace {

// The largest value of n · (q − p) over the light's points q, exact for every shape; above 0 where some of the light is
// seen from the receiver's horizon up.
float height_above_horizon(const Receiver& receiver, const Light& light) {
    const vec3 n = receiver.geometric_normal;
    if (light.type == LightType::Directional) return -glm::dot(n, light.direction);
    const float center = glm::dot(n, light.position - receiver.position);
    const float along = glm::dot(n, light.tangent), across = glm::dot(n, bitangent(light));
    switch (light.type) {
    case LightType::Rectangle:
    case LightType::TexturedRectangle:
        return center + 0.5f * (std::abs(along) * light.size.x + std::abs(across) * light.size.y);
    case LightType::Disk:
        return center + 0.5f * light.size.x * std::sqrt(along * along + across * across);
    case LightType::Sphere:
        return center + 0.5f * light.size.x;
    case LightType::Mesh: {
        float highest = center;
        for (const LightTriangle& t : light.triangles)
            for (const vec3 corner : {t.a, t.b, t.c})
                highest = std::max(highest, glm::dot(n, corner - receiver.position));
        return highest;
    }
    default:
        return center;
    }
}

template <class T, class Read> Image<T> gather(const Receivers& receivers, Read read) {
    Image<T> values(receivers.width(), receivers.height());
    for (size_t i = 0; i < values.size(); ++i) values.values()[i] = read(receivers.values()[i]);
    return values;
}

void add_aovs(ChannelImage& image, const Aovs& aovs, const GBuffer& gbuffer) {
    const Receivers& receivers = gbuffer.receivers;
    if (aovs.depth) image.add("Z", gbuffer.depth);
    if (aovs.position) image.add_vector("P", gather<vec3>(receivers, [](const Receiver& r) { return r.position; }));
    if (aovs.geometric_normal)
        image.add_vector("N", gather<vec3>(receivers, [](const Receiver& r) { return r.geometric_normal; }));
    if (aovs.shading_normal) image.add_vector("Ns", gbuffer.shading_normal);
    if (aovs.albedo) image.add_color("albedo", gbuffer.albedo, false);
    if (aovs.id)
        image.add("id", gather<float>(receivers, [](const Receiver& r) {
                      return r.valid() ? static_cast<float>(r.triangle) : -1.0f;
                  }));
}

bool fits(const NamedImage& debug, const Frame& frame) {
    return debug.values.width() == frame.width() && debug.values.height() == frame.height();
}

} // namespace

Image<float> light_mask(const Receivers& receivers, const Light& light) {
    return gather<float>(receivers, [&](const Receiver& receiver) {
        return receiver.valid() && height_above_horizon(receiver, light) > 0 ? 1.0f : 0.0f;
    });
}

std::string light_channel(const std::string& channel, const std::string& light, size_t light_count) {
    return light_count == 1 ? channel : light + "." + channel;
}

void add_visibility(ChannelImage& layers, const Frame& frame, const std::vector<Light>& lights,
                    const std::vector<LitImage>& images) {
    for (size_t i = 0; i < images.size(); ++i) {
        layers.add(light_channel("V", images[i].light, images.size()), images[i].visibility.values);
        layers.add(light_channel("M", images[i].light, images.size()), light_mask(frame.receivers(), lights[i]));
        for (const NamedImage& layer : images[i].visibility.layers)
            layers.add(light_channel(layer.name, images[i].light, images.size()), layer.values);
    }
}

ChannelImage make_layers(const RenderRequest& request, const Frame& frame, const std::vector<Light>& lights,
                         const Image<vec3>& radiance, const std::vector<LitImage>& images,
                         const std::map<std::string, Attribute>& attributes) {
    ChannelImage layers;
    layers.width = frame.width(), layers.height = frame.height();
    layers.attributes = attributes;
    layers.add_color("", radiance, true);
    add_visibility(layers, frame, lights, images);
    add_aovs(layers, request.aovs, frame.gbuffer());
    if (request.debug_images)
        for (const LitImage& image : images)
            for (const NamedImage& debug : image.visibility.debug)
                if (fits(debug, frame))
                    layers.add(light_channel("debug." + debug.name, image.light, images.size()), debug.values);
    return layers;
}

void write_debug_images(const std::string& exr_path, const Frame& frame, const std::vector<LitImage>& images,
                        const std::map<std::string, Attribute>& attributes) {
    for (const LitImage& image : images)
        for (const NamedImage& debug : image.visibility.debug) {
            if (fits(debug, frame)) continue;
            ChannelImage layers;
            layers.width = debug.values.width(), layers.height = debug.values.height();
            layers.attributes = attributes;
            layers.add("Y", debug.values);
            std::string name = light_channel(debug.name, image.light, images.size());
            std::replace(name.begin(), name.end(), '/', '_');
            std::filesystem::path path(exr_path);
            path.replace_filename(fmt::format("{}.{}.exr", path.stem().string(), name));
            write_exr(path.string(), layers);
        }
}

float automatic_exposure(const GBuffer& gbuffer, const Image<vec3>& radiance) {
    std::vector<float> luminance;
    luminance.reserve(radiance.size());
    for (size_t i = 0; i < radiance.size(); ++i)
        if (gbuffer.receivers.values()[i].valid())
            luminance.push_back(glm::dot(radiance.values()[i], vec3(0.2126f, 0.7152f, 0.0722f)));
    if (luminance.empty()) return 1.0f;
    const auto percentile = luminance.begin() + static_cast<std::ptrdiff_t>((luminance.size() - 1) * 99 / 100);
    std::nth_element(luminance.begin(), percentile, luminance.end());
    const float factor = 0.9f / *percentile;
    return *percentile > 0 && std::isfinite(factor) ? factor : 1.0f;
}

Image<vec3> exposed_srgb(const Image<vec3>& radiance, float exposure) {
    Image<vec3> srgb(radiance.width(), radiance.height());
    parallel_for(srgb.size(), 1 << 14, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const vec3 linear = glm::clamp(radiance.values()[i] * exposure, vec3(0.0f), vec3(1.0f));
            srgb.values()[i] = {srgb_from_linear(linear.x), srgb_from_linear(linear.y), srgb_from_linear(linear.z)};
        }
    });
    return srgb;
}

void write_exposed_png(const std::string& path, const Image<vec3>& radiance, float exposure,
                       std::map<std::string, std::string> text) {
    text["gnomon:exposure"] = fmt::format("{} (factor on scene-linear radiance before sRGB)", exposure);
    write_png(path, exposed_srgb(radiance, exposure), text);
}

} // namespace gnomon
