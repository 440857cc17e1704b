#pragma once
// Images as text inside a page, within a budget.

#include <string>
#include <utility>
#include <vector>

#include "core/image.h"
#include "core/math.h"

namespace gnomon {

// Values are stored as codes: round((v - low) / (high - low) * levels) over [low, high], which is [0, 1] or what
// holds all finite values, where some lie beyond. The three codes above the levels stand for -infinity, infinity and
// NaN. With the finest levels, those of visibility, every n/1024 in [0, 1] is exact, and any other value to 1/129024.
inline constexpr int finest_levels = 63 * 1024;
// Of FLIP maps, which are read as colours: off by at most 1/2040.
inline constexpr int flip_levels = 1020;

struct EmbeddedValues {
    std::string png; // base64
    int levels = finest_levels;
    float low = 0.0f, high = 1.0f;
};

// A browser's canvas has 8 bits a channel, so that the codes travel as two grey planes in one PNG, twice as high as the
// image: the high bytes on top, the low bytes below.
EmbeddedValues embed_values(const Image<float>& values, int levels = finest_levels);

// Display-referred sRGB as a PNG in base64; every `step`-th pixel in both directions is the mean of its step × step.
std::string embed_shaded(const Image<vec3>& srgb, int step = 1);

// 1 as white, 0 as black.
std::string embed_mask(const Image<std::uint8_t>& mask);

// One entry's images and their text.
struct ImagesToEmbed {
    const Image<vec3>* shaded;
    const Image<float>* visibility;
    int rank;                           // the highest are left out first
    const Image<float>* flip = nullptr; // how far it looks from the reference
};
struct EmbeddedImages {
    std::string shaded;
    EmbeddedValues visibility, flip; // empty png: none, or left out
    bool left_out = false;
};
struct EmbeddedSet {
    std::vector<EmbeddedImages> images; // one an entry
    int shaded_step = 1, levels = finest_levels;
    bool flip = true;    // false: no FLIP maps, to make room
    size_t left_out = 0; // entries
    size_t bytes = 0;
};

// All of them, as finely as `budget` bytes hold; the result depends on the images and the budget alone.
EmbeddedSet embed_images(const std::vector<ImagesToEmbed>& entries, size_t budget);

} // namespace gnomon
