#include "bin/error_map_file.h"

#include <fmt/format.h>

namespace gnomon {
namespace {

// A single visibility may bear another light's name in the other image.
const Channel& matching_channel(const ChannelImage& image, const std::string& name) {
    if (const Channel* same = image.find(name)) return *same;
    for (const Channel& channel : image.channels)
        if (channel.name == "V" || channel.name.ends_with(".V")) return channel;
    throw InputError(fmt::format("there is no channel '{}' to draw", name));
}

bool is_color(const std::vector<std::string>& channels) { return channels == std::vector<std::string>{"R", "G", "B"}; }

Image<float> one_value(const ChannelImage& image, const std::vector<std::string>& channels) {
    constexpr float luminance[] = {0.2126f, 0.7152f, 0.0722f};
    Image<float> sum(image.width, image.height, 0.0f);
    for (size_t c = 0; c < channels.size(); ++c) {
        const float weight = is_color(channels) ? luminance[c] : 1.0f / static_cast<float>(channels.size());
        const Image<float>& values = matching_channel(image, channels[c]).values;
        for (size_t i = 0; i < sum.size(); ++i) sum.values()[i] += weight * values.values()[i];
    }
    return sum;
}

// The mask of a visibility channel: "<light>.M", or else "M".
const Channel* mask_of(const ChannelImage& image, const std::string& channel) {
    const Channel* own = channel.ends_with("V") ? image.find(channel.substr(0, channel.size() - 1) + "M") : nullptr;
    return own ? own : image.find("M");
}

// Pixels that some channel is measured on in both images; empty where neither has a mask.
Image<std::uint8_t> common_mask(const ChannelImage& test, const ChannelImage& reference,
                                const std::vector<std::string>& channels) {
    Image<std::uint8_t> mask(test.width, test.height, 0);
    for (const std::string& channel : channels) {
        const Channel* first = mask_of(test, matching_channel(test, channel).name);
        const Channel* second = mask_of(reference, matching_channel(reference, channel).name);
        if (!first && !second) return {};
        for (size_t i = 0; i < mask.size(); ++i) {
            const bool in =
                (!first || first->values.values()[i] >= 0.5f) && (!second || second->values.values()[i] >= 0.5f);
            if (in) mask.values()[i] = 1;
        }
    }
    return mask;
}

} // namespace

void write_error_map(const std::string& path, const ChannelImage& test, const ChannelImage& reference,
                     const std::vector<std::string>& channels, bool masked, ErrorMapKind kind) {
    ErrorMapOptions options;
    options.kind = kind;
    options.title = is_color(channels) ? "luminance" : fmt::format("{}", fmt::join(channels, " "));
    const Image<std::uint8_t> mask = masked ? common_mask(test, reference, channels) : Image<std::uint8_t>();
    write_png(path, draw_error_map(one_value(test, channels), one_value(reference, channels), mask, options));
}

} // namespace gnomon
