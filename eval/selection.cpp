#include "eval/selection.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "core/parallel.h"
#include "eval/metric/classes.h"

namespace gnomon {
namespace {

using Kind = ChannelGroup::Kind;

bool is_visibility(const std::string& name) { return name == "V" || name.ends_with(".V"); }

std::string last_part(const std::string& name) { return name.substr(name.rfind('.') + 1); } // all, without a point
std::string layer_of(const std::string& name) { return name.substr(0, name.size() - last_part(name).size()); }

bool is_color(const std::string& name) {
    const std::string part = last_part(name);
    return part == "R" || part == "G" || part == "B" || part == "Y";
}

std::vector<const Channel*> visibilities(const ChannelImage& image) {
    std::vector<const Channel*> found;
    for (const Channel& channel : image.channels)
        if (is_visibility(channel.name)) found.push_back(&channel);
    return found;
}

std::string names_of(const ChannelImage& image) {
    std::string names;
    for (const Channel& channel : image.channels) names += (names.empty() ? "" : ", ") + channel.name;
    return names.empty() ? "none" : names;
}

void check_sizes(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options) {
    if (test.width != reference.width || test.height != reference.height)
        throw InputError(fmt::format("'{}' is {}x{} but '{}' is {}x{}; only images of one size can be compared",
                                     options.test_name, test.width, test.height, options.reference_name,
                                     reference.width, reference.height));
    if (!options.mask.empty() && (options.mask.width() != test.width || options.mask.height() != test.height))
        throw InputError(fmt::format("the mask is {}x{} but '{}' and '{}' are {}x{}", options.mask.width(),
                                     options.mask.height(), options.test_name, options.reference_name, test.width,
                                     test.height));
}

ComparedChannel compared(const Channel& test, const Channel& reference) {
    return {test.name, &test.values, &reference.values};
}

std::vector<ChannelGroup> visibility_groups(const ChannelImage& test, const ChannelImage& reference) {
    std::vector<ChannelGroup> groups;
    const std::vector<const Channel*> tests = visibilities(test), references = visibilities(reference);
    for (const Channel* channel : tests)
        if (const Channel* other = reference.find(channel->name))
            groups.push_back({Kind::Visibility, {compared(*channel, *other)}, {}, false});
    // One light, called differently.
    if (groups.empty() && tests.size() == 1 && references.size() == 1)
        groups.push_back({Kind::Visibility, {compared(*tests[0], *references[0])}, {}, false});
    return groups;
}

// The colours of a layer ("" or "diffuse.") where both images have all of `parts`.
std::optional<ChannelGroup> color_group(const ChannelImage& test, const ChannelImage& reference,
                                        const std::string& test_layer, const std::string& reference_layer,
                                        const std::vector<std::string>& parts) {
    ChannelGroup group{Kind::Color, {}, {}, false};
    for (const std::string& part : parts) {
        const Channel *a = test.find(test_layer + part), *b = reference.find(reference_layer + part);
        if (!a || !b) return std::nullopt;
        group.channels.push_back(compared(*a, *b));
    }
    return group;
}

const std::vector<std::string> rgb = {"R", "G", "B"};

// Adds one of --channels to the groups: components of one layer's colour stay together.
void add_chosen(const ChannelImage& test, const ChannelImage& reference, const std::string& chosen,
                const CompareOptions& options, std::vector<ChannelGroup>& groups) {
    const size_t equals = chosen.find('=');
    const std::string name = chosen.substr(0, equals),
                      other = equals == std::string::npos ? name : chosen.substr(equals + 1);
    const Channel *a = test.find(name), *b = reference.find(other);
    if (!a || !b) {
        if (const auto layer = color_group(test, reference, name + ".", other + ".", rgb))
            return groups.push_back(*layer);
        throw InputError(fmt::format("there is no channel '{}' to compare '{}' with '{}': '{}' has {}",
                                     a ? other : name, options.test_name, options.reference_name,
                                     a ? options.reference_name : options.test_name, names_of(a ? reference : test)));
    }
    if (!is_color(name))
        return groups.push_back({is_visibility(name) ? Kind::Visibility : Kind::Data, {compared(*a, *b)}, {}, false});
    for (ChannelGroup& group : groups)
        if (group.kind == Kind::Color && layer_of(group.channels[0].name) == layer_of(name))
            return group.channels.push_back(compared(*a, *b));
    groups.push_back({Kind::Color, {compared(*a, *b)}, {}, false});
}

std::vector<ChannelGroup> groups_of(const ChannelImage& test, const ChannelImage& reference,
                                    const CompareOptions& options) {
    std::vector<ChannelGroup> groups;
    for (const std::string& chosen : options.channels) add_chosen(test, reference, chosen, options, groups);
    if (options.channels.empty()) {
        groups = visibility_groups(test, reference);
        for (const std::vector<std::string>& parts : {rgb, std::vector<std::string>{"Y"}})
            if (groups.empty())
                if (const auto group = color_group(test, reference, "", "", parts)) groups.push_back(*group);
    }
    if (groups.empty())
        throw InputError(fmt::format("'{}' ({}) and '{}' ({}) have no visibility and no colour in common",
                                     options.test_name, names_of(test), options.reference_name, names_of(reference)));
    if (!options.as_visibility) return groups;
    std::vector<ChannelGroup> single;
    for (const ChannelGroup& group : groups)
        for (const ComparedChannel& channel : group.channels)
            single.push_back({Kind::Visibility, {channel}, {}, false});
    return single;
}

void check_encodings(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options,
                     std::vector<ChannelGroup>& groups) {
    const bool test_is_coded = is_srgb_coded(test), reference_is_coded = is_srgb_coded(reference);
    for (ChannelGroup& group : groups) {
        if (group.kind != Kind::Color) continue;
        if (test_is_coded != reference_is_coded)
            throw InputError(fmt::format("'{}' holds sRGB codes and '{}' scene-linear colours",
                                         test_is_coded ? options.test_name : options.reference_name,
                                         test_is_coded ? options.reference_name : options.test_name));
        group.srgb = test_is_coded;
    }
}

void keep(Image<std::uint8_t>& mask, const Image<float>& values, bool (*in)(float)) {
    if (mask.empty()) mask = Image<std::uint8_t>(values.width(), values.height(), 1);
    parallel_for(mask.size(), 1 << 16, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            if (!in(values.values()[i])) mask.values()[i] = 0;
    });
}

// Takes out of `mask` what the image's own mask for this visibility or colour leaves out.
void intersect_own_mask(const ChannelImage& image, const std::string& channel, Image<std::uint8_t>& mask) {
    const Channel* own = nullptr;
    if (is_visibility(channel)) own = image.find(channel.substr(0, channel.size() - 1) + "M");
    if (!own) own = image.find("M");
    if (own) keep(mask, own->values, [](float value) { return value >= 0.5f; });
}

std::string reference_name(const ChannelImage& reference, const ComparedChannel& channel) {
    for (const Channel& candidate : reference.channels)
        if (&candidate.values == channel.reference) return candidate.name;
    return channel.name;
}

} // namespace

std::optional<ColorPair> ChannelGroup::color() const {
    if (kind == Kind::Data || (channels.size() != 1 && channels.size() != 3)) return std::nullopt;
    if (channels.size() == 1 && kind == Kind::Color && last_part(channels[0].name) != "Y") return std::nullopt;
    ColorPair pair{{}, {}, mask, srgb};
    for (size_t i = 0; i < 3; ++i) {
        const ComparedChannel* channel = &channels[0];
        if (channels.size() == 3) {
            const auto found = std::find_if(channels.begin(), channels.end(), [&](const ComparedChannel& candidate) {
                return last_part(candidate.name) == rgb[i];
            });
            if (found == channels.end()) return std::nullopt;
            channel = &*found;
        }
        pair.test[i] = channel->test, pair.reference[i] = channel->reference;
    }
    return pair;
}

std::vector<ChannelGroup> select_channels(const ChannelImage& test, const ChannelImage& reference,
                                          const CompareOptions& options) {
    check_sizes(test, reference, options);
    std::vector<ChannelGroup> groups = groups_of(test, reference, options);
    check_encodings(test, reference, options, groups);
    for (ChannelGroup& group : groups) {
        group.mask = options.mask;
        if (options.mask_source == MaskSource::Images) {
            intersect_own_mask(test, group.channels[0].name, group.mask);
            intersect_own_mask(reference, reference_name(reference, group.channels[0]), group.mask);
        }
        if (!options.only_penumbra) continue;
        if (group.kind != Kind::Visibility)
            throw UsageError(
                fmt::format("the penumbra is known of visibility alone, not of channel '{}'", group.channels[0].name));
        keep(group.mask, *group.channels[0].reference,
             [](float value) { return std::isnan(value) || shadow_class(value) == ShadowClass::Penumbra; });
    }
    return groups;
}

bool is_srgb_coded(const ChannelImage& image) {
    const auto found = image.attributes.find("oiio:ColorSpace");
    const auto* space = found == image.attributes.end() ? nullptr : std::get_if<std::string>(&found->second);
    return space && (*space == "sRGB" || *space == "sRGB_texture");
}

void match_encodings(ChannelImage& test, ChannelImage& reference) {
    if (is_srgb_coded(test) == is_srgb_coded(reference)) return;
    ChannelImage& coded = is_srgb_coded(test) ? test : reference;
    for (Channel& channel : coded.channels) {
        if (!is_color(channel.name)) continue;
        parallel_for(channel.values.size(), 1 << 16, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                channel.values.values()[i] = linear_from_srgb(channel.values.values()[i]);
        });
    }
    coded.attributes["oiio:ColorSpace"] = std::string("Linear");
}

Image<std::uint8_t> rectangle_mask(int width, int height, int left, int top, int rectangle_width,
                                   int rectangle_height) {
    if (left < 0 || top < 0 || rectangle_width < 1 || rectangle_height < 1 || rectangle_width > width - left ||
        rectangle_height > height - top)
        throw InputError(fmt::format("the rectangle {},{},{},{} does not lie inside the image of {}x{}", left, top,
                                     rectangle_width, rectangle_height, width, height));
    Image<std::uint8_t> mask(width, height, 0);
    for (int row = top; row < top + rectangle_height; ++row)
        std::fill_n(mask.row(height - 1 - row).begin() + left, rectangle_width, std::uint8_t{1});
    return mask;
}

Image<std::uint8_t> id_mask(const ChannelImage& image, const std::string& image_name, const std::string& layer,
                            const std::vector<std::int64_t>& ids) {
    const Channel* channel = image.find(layer);
    if (!channel)
        throw InputError(fmt::format("'{}' has no layer '{}' of ids: it has {}", image_name, layer, names_of(image)));
    Image<std::uint8_t> mask(image.width, image.height, 0);
    for (size_t i = 0; i < mask.size(); ++i)
        for (const std::int64_t id : ids)
            if (channel->values.values()[i] == static_cast<float>(id)) mask.values()[i] = 1;
    return mask;
}

} // namespace gnomon
