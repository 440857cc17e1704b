#include "eval/report/embed.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/image_file.h"
#include "core/parallel.h"

namespace gnomon {
namespace {

std::string base64(const std::string& bytes) {
    constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        unsigned group = 0;
        for (size_t j = 0; j < 3; ++j)
            group = group << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0u);
        for (size_t j = 0; j < 4; ++j) text += i + j <= bytes.size() ? letters[group >> (18 - 6 * j) & 63] : '=';
    }
    return text;
}

// What one value of an image is stored as.
struct Coder {
    double low, high;
    int levels;

    unsigned operator()(float value) const {
        if (std::isfinite(value)) return static_cast<unsigned>(std::lround((value - low) / (high - low) * levels));
        return static_cast<unsigned>(levels + (std::isnan(value) ? 3 : value > 0 ? 2 : 1));
    }
};

Coder coder_for(const Image<float>& values, int levels) {
    float low = 0.0f, high = 1.0f;
    for (const float value : values.values())
        if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
    return {low, high, levels};
}

Image<vec3> reduced(const Image<vec3>& image, int step) {
    Image<vec3> small((image.width() + step - 1) / step, (image.height() + step - 1) / step);
    for (int y = 0; y < small.height(); ++y)
        for (int x = 0; x < small.width(); ++x) {
            vec3 sum(0.0f);
            float count = 0.0f;
            for (int j = y * step; j < std::min((y + 1) * step, image.height()); ++j)
                for (int i = x * step; i < std::min((x + 1) * step, image.width()); ++i) sum += image(i, j), ++count;
            small(x, y) = sum / count;
        }
    return small;
}

// From fine to coarse: visibility keeps its precision as long as it can; FLIP maps, which the files can give again, go
// before it.
struct Rung {
    int shaded_step, levels;
    bool flip;
};
constexpr Rung rungs[] = {{1, finest_levels, true}, {2, finest_levels, true}, {2, finest_levels, false},
                          {2, 4096, false},         {2, 1024, false},         {4, 252, false}};

size_t bytes_of(const EmbeddedImages& images) {
    return images.shaded.size() + images.visibility.png.size() + images.flip.png.size();
}

size_t total_bytes(const std::vector<EmbeddedImages>& images) {
    size_t sum = 0;
    for (const EmbeddedImages& one : images) sum += bytes_of(one);
    return sum;
}

// Leaves entries out, those of the highest rank first, of one rank from the last on.
void leave_out(EmbeddedSet& set, const std::vector<ImagesToEmbed>& entries, size_t budget) {
    std::vector<size_t> order(entries.size());
    std::iota(order.rbegin(), order.rend(), size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return entries[a].rank > entries[b].rank; });
    for (const size_t i : order) {
        EmbeddedImages& images = set.images[i];
        const size_t own = bytes_of(images);
        if (set.bytes <= budget || own == 0) continue;
        set.bytes -= own;
        images = {{}, {}, {}, true};
        ++set.left_out;
    }
}

} // namespace

EmbeddedValues embed_values(const Image<float>& values, int levels) {
    const int width = values.width(), height = values.height();
    const Coder code_of = coder_for(values, levels);
    Image<std::uint8_t> planes(width, 2 * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const unsigned code = code_of(values(x, y));
            planes(x, y + height) = static_cast<std::uint8_t>(code >> 8);
            planes(x, y) = static_cast<std::uint8_t>(code & 255);
        }
    return {base64(encode_png(planes)), levels, static_cast<float>(code_of.low), static_cast<float>(code_of.high)};
}

std::string embed_shaded(const Image<vec3>& srgb, int step) {
    return base64(encode_png(step == 1 ? srgb : reduced(srgb, step)));
}

std::string embed_mask(const Image<std::uint8_t>& mask) {
    Image<std::uint8_t> image(mask.width(), mask.height());
    for (size_t i = 0; i < mask.size(); ++i) image.values()[i] = mask.values()[i] ? 255 : 0;
    return base64(encode_png(image));
}

EmbeddedSet embed_images(const std::vector<ImagesToEmbed>& entries, size_t budget) {
    EmbeddedSet set;
    set.images.resize(entries.size());
    Rung before{0, 0, false};
    for (const Rung& rung : rungs) {
        parallel_for(entries.size(), 1, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                if (rung.shaded_step != before.shaded_step && entries[i].shaded && !entries[i].shaded->empty())
                    set.images[i].shaded = embed_shaded(*entries[i].shaded, rung.shaded_step);
                if (rung.levels != before.levels && entries[i].visibility && !entries[i].visibility->empty())
                    set.images[i].visibility = embed_values(*entries[i].visibility, rung.levels);
                if (rung.flip && !before.flip && entries[i].flip && !entries[i].flip->empty())
                    set.images[i].flip = embed_values(*entries[i].flip, flip_levels);
                if (!rung.flip) set.images[i].flip = {};
            }
        });
        set.bytes = total_bytes(set.images);
        set.shaded_step = rung.shaded_step, set.levels = rung.levels, set.flip = rung.flip;
        if (set.bytes <= budget) return set;
        before = rung;
    }
    leave_out(set, entries, budget);
    return set;
}

} // namespace gnomon
