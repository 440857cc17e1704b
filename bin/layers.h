#pragma once
// A technique's answers as the channels of an EXR file, and the shaded image as a PNG.

#include <string>
#include <vector>

#include "bin/render_options.h"
#include "core/image_file.h"

namespace gnomon {

// One technique's answer for one light, and the mask of the receivers that it is measured on.
struct LitImage {
    std::string light;
    Visibility visibility;
};

// 1 where the camera sees a receiver, some part of the light is above the horizon of its geometric normal: elsewhere
// every technique says 0 and there is nothing to compare.
Image<float> light_mask(const Receivers& receivers, const Light& light);

// "V" for the only light, "<light>.V" for one of several; the same for the mask "M".
std::string light_channel(const std::string& channel, const std::string& light, size_t light_count);

// V, M and the technique's other layers of every light.
void add_visibility(ChannelImage& layers, const Frame& frame, const std::vector<Light>& lights,
                    const std::vector<LitImage>& images);

// R, G, B, then V, M and the technique's other layers of every light, then the AOVs, then debug images of the size of
// the frame. Other debug images go to files of their own, see write_debug_images.
ChannelImage make_layers(const RenderRequest& request, const Frame& frame, const std::vector<Light>& lights,
                         const Image<vec3>& radiance, const std::vector<LitImage>& images,
                         const std::map<std::string, Attribute>& attributes);

// Debug images of any other size (a shadow map) beside `exr_path`: STEM.NAME.exr, or STEM.LIGHT.NAME.exr with several
// lights.
void write_debug_images(const std::string& exr_path, const Frame& frame, const std::vector<LitImage>& images,
                        const std::map<std::string, Attribute>& attributes);

// The factor that maps the 99th percentile of the luminance of `radiance`, over pixels that show something, to 0.9; 1
// where all is dark.
float automatic_exposure(const GBuffer& gbuffer, const Image<vec3>& radiance);

// Display-referred sRGB of scene-linear radiance times `exposure`, clamped.
Image<vec3> exposed_srgb(const Image<vec3>& radiance, float exposure);

// The same as a file; its text says the exposure.
void write_exposed_png(const std::string& path, const Image<vec3>& radiance, float exposure,
                       std::map<std::string, std::string> text);

} // namespace gnomon
