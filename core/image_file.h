#pragma once
// Reading and writing EXR and PNG through OpenImageIO. Images are bottom-up in memory and top-down in files: this is
// the one place that flips them. Files appear whole or not at all (core/atomic_file.h).

#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "core/image.h"
#include "core/math.h"

namespace gnomon {

// A named channel: "R", "V", "lamp.V", "N.X".
struct Channel {
    std::string name;
    Image<float> values;
    bool half = false; // stored as half float in EXR
};

using Attribute = std::variant<std::string, float, int, mat4>;

struct ChannelImage {
    int width = 0, height = 0;
    std::vector<Channel> channels; // all of width × height
    std::map<std::string, Attribute> attributes;

    const Channel* find(const std::string& name) const;
    void add(const std::string& name, Image<float> values, bool half = false);
    void add_color(const std::string& prefix, const Image<vec3>& color, bool half); // "R","G","B" or "prefix.R", …
    void add_vector(const std::string& prefix, const Image<vec3>& vector);          // "prefix.X", ".Y", ".Z"
};

// ZIP-compressed scan-line EXR, deterministic bytes (no dates). Throws InputError where the file cannot be written.
void write_exr(const std::string& path, const ChannelImage& image);

// 8-bit PNG of values that are already display-referred sRGB in [0, 1] (rounded to nearest, clamped). `text` goes into
// tEXt.
void write_png(const std::string& path, const Image<vec3>& srgb, const std::map<std::string, std::string>& text = {});

// The bytes of a PNG file, in colour as above or in grey, for embedding.
std::string encode_png(const Image<vec3>& srgb);
std::string encode_png(const Image<std::uint8_t>& gray);

// Any format OpenImageIO reads. Integer formats are scaled to [0, 1], but for EXR's, which are ids and counts; PNG's
// sRGB channels stay as stored (not linearised). Throws InputError where the file is missing, not an image, truncated,
// larger than max_image_side, or holds several images (parts of an EXR).
ChannelImage read_image(const std::string& path);

// The sRGB transfer function (IEC 61966-2-1), on one value: linear in [0, 1] to display-referred, and back.
float srgb_from_linear(float linear);
float linear_from_srgb(float srgb);

} // namespace gnomon
