#include "eval/compare.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "eval/metric/reduce.h"

namespace gnomon {
namespace {

// Channels that share a mask: the components of a colour, or one visibility.
struct Group {
    std::vector<std::pair<const Channel*, const Channel*>> channels; // test, reference
    bool color = false;
    Image<std::uint8_t> mask;
};

bool is_visibility(const std::string& name) { return name == "V" || name.ends_with(".V"); }

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
    if (options.mask_source == MaskSource::Given &&
        (options.mask.width() != test.width || options.mask.height() != test.height))
        throw InputError(fmt::format("the mask is {}x{} but '{}' and '{}' are {}x{}", options.mask.width(),
                                     options.mask.height(), options.test_name, options.reference_name, test.width,
                                     test.height));
}

std::vector<Group> visibility_groups(const ChannelImage& test, const ChannelImage& reference) {
    std::vector<Group> groups;
    const std::vector<const Channel*> tests = visibilities(test), references = visibilities(reference);
    for (const Channel* channel : tests)
        if (const Channel* other = reference.find(channel->name)) groups.push_back({{{channel, other}}, false, {}});
    // One light, called differently.
    if (groups.empty() && tests.size() == 1 && references.size() == 1)
        groups.push_back({{{tests[0], references[0]}}, false, {}});
    return groups;
}

std::vector<Group> color_groups(const ChannelImage& test, const ChannelImage& reference) {
    const auto common = [&](const std::vector<std::string>& names) {
        Group group{{}, true, {}};
        for (const std::string& name : names)
            if (const Channel* a = test.find(name), *b = reference.find(name); a && b)
                group.channels.emplace_back(a, b);
        return group.channels.size() == names.size() ? std::vector<Group>{group} : std::vector<Group>{};
    };
    std::vector<Group> groups = common({"R", "G", "B"});
    return groups.empty() ? common({"Y"}) : groups;
}

std::vector<Group> chosen_groups(const ChannelImage& test, const ChannelImage& reference,
                                 const CompareOptions& options) {
    std::vector<Group> groups;
    Group color{{}, true, {}};
    for (const std::string& name : options.channels) {
        const Channel *a = test.find(name), *b = reference.find(name);
        if (!a || !b)
            throw InputError(fmt::format("there is no channel '{}' to compare '{}' with '{}': '{}' has {}", name,
                                         options.test_name, options.reference_name,
                                         a ? options.reference_name : options.test_name,
                                         names_of(a ? reference : test)));
        if (name == "R" || name == "G" || name == "B" || name == "Y")
            color.channels.emplace_back(a, b);
        else
            groups.push_back({{{a, b}}, !is_visibility(name), {}});
    }
    if (!color.channels.empty()) groups.insert(groups.begin(), color);
    return groups;
}

std::vector<Group> groups_of(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options) {
    if (!options.channels.empty()) return chosen_groups(test, reference, options);
    std::vector<Group> groups = visibility_groups(test, reference);
    if (groups.empty()) groups = color_groups(test, reference);
    if (groups.empty())
        throw InputError(fmt::format("'{}' ({}) and '{}' ({}) have no visibility and no colour in common",
                                     options.test_name, names_of(test), options.reference_name, names_of(reference)));
    return groups;
}

// Takes out of `mask` what the image's own mask for this visibility or colour leaves out.
void intersect_mask(const ChannelImage& image, const std::string& channel, Image<std::uint8_t>& mask) {
    const Channel* own = nullptr;
    if (is_visibility(channel)) own = image.find(channel.substr(0, channel.size() - 1) + "M");
    if (!own) own = image.find("M");
    if (!own) return;
    if (mask.empty()) mask = Image<std::uint8_t>(image.width, image.height, 1);
    for (size_t i = 0; i < mask.size(); ++i)
        if (!(own->values.values()[i] >= 0.5f)) mask.values()[i] = 0;
}

// Where one component of a colour is missing, the others are left out too. Returns how many pixels are.
std::int64_t drop_missing(Group& group) {
    std::int64_t missing = 0;
    for (const auto& [test, reference] : group.channels) {
        const ImagePair pair{test->values, reference->values, group.mask};
        const std::int64_t of_channel = count_missing(pair);
        if (of_channel == 0) continue;
        missing += of_channel;
        if (group.mask.empty()) group.mask = Image<std::uint8_t>(test->values.width(), test->values.height(), 1);
        const ImagePair masked{test->values, reference->values, group.mask};
        for (size_t i = 0; i < group.mask.size(); ++i)
            if (!takes_part(masked, i)) group.mask.values()[i] = 0;
    }
    return missing;
}

std::vector<const Metric*> metrics_of(const CompareOptions& options) {
    std::vector<std::string> known = {"all"};
    for (const Metric& metric : metrics()) known.push_back(metric.id);
    bool all = options.metrics.empty();
    for (const std::string& id : options.metrics) {
        if (std::find(known.begin(), known.end(), id) == known.end())
            throw UsageError(fmt::format("there is no metric '{}'{}", id, did_you_mean(id, known)));
        all = all || id == "all";
    }
    std::vector<const Metric*> chosen;
    for (const Metric& metric : metrics())
        if (all || std::find(options.metrics.begin(), options.metrics.end(), metric.id) != options.metrics.end())
            chosen.push_back(&metric);
    return chosen;
}

double evaluate(const Metric& metric, const std::vector<Group>& groups) {
    std::vector<double> values, weights;
    for (const Group& group : groups) {
        if (metric.visibility_only && group.color) continue;
        for (const auto& [test, reference] : group.channels) {
            const ImagePair pair{test->values, reference->values, group.mask};
            values.push_back(metric.evaluate(pair));
            weights.push_back(static_cast<double>(count_masked(pair)));
        }
    }
    return pool(metric, values, weights);
}

bool in_any_mask(const std::vector<Group>& groups, size_t pixel) {
    return std::any_of(groups.begin(), groups.end(),
                       [&](const Group& group) { return group.mask.empty() || group.mask.values()[pixel] != 0; });
}

// The groups with their masks, but for pixels that are missing.
std::vector<Group> masked_groups(const ChannelImage& test, const ChannelImage& reference,
                                 const CompareOptions& options) {
    check_sizes(test, reference, options);
    std::vector<Group> groups = groups_of(test, reference, options);
    for (Group& group : groups) {
        if (options.mask_source == MaskSource::Given) group.mask = options.mask;
        if (options.mask_source != MaskSource::Images) continue;
        intersect_mask(test, group.channels[0].first->name, group.mask);
        intersect_mask(reference, group.channels[0].second->name, group.mask);
    }
    return groups;
}

} // namespace

Comparison compare(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options) {
    const std::vector<const Metric*> chosen = metrics_of(options);
    std::vector<Group> groups = masked_groups(test, reference, options);
    Comparison comparison;
    comparison.test = options.test_name, comparison.reference = options.reference_name;
    comparison.pixels = std::int64_t{test.width} * test.height;
    for (Group& group : groups) {
        comparison.missing += drop_missing(group);
        for (const auto& channels : group.channels) comparison.channels.push_back(channels.first->name);
    }
    for (size_t pixel = 0; pixel < static_cast<size_t>(comparison.pixels); ++pixel)
        comparison.masked += in_any_mask(groups, pixel);
    for (const Metric* metric : chosen)
        if (const double value = evaluate(*metric, groups); !std::isnan(value))
            comparison.metrics.emplace_back(metric->id, value);
    return comparison;
}

ComparedValues compared_values(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options) {
    const std::vector<Group> groups = masked_groups(test, reference, options);
    ComparedValues values{Image<float>(test.width, test.height), Image<float>(test.width, test.height), {}};
    const bool masked =
        std::all_of(groups.begin(), groups.end(), [](const Group& group) { return !group.mask.empty(); });
    if (masked) values.mask = Image<std::uint8_t>(test.width, test.height);
    for (size_t pixel = 0; pixel < values.test.size(); ++pixel) {
        float count = 0.0f;
        for (const Group& group : groups) {
            if (!group.mask.empty() && group.mask.values()[pixel] == 0) continue;
            for (const auto& [a, b] : group.channels) {
                values.test.values()[pixel] += a->values.values()[pixel];
                values.reference.values()[pixel] += b->values.values()[pixel];
                count += 1.0f;
            }
        }
        if (count > 0.0f) values.test.values()[pixel] /= count, values.reference.values()[pixel] /= count;
        if (masked) values.mask.values()[pixel] = count > 0.0f;
    }
    return values;
}

nlohmann::ordered_json comparison_json(const Comparison& comparison) {
    nlohmann::ordered_json values = nlohmann::ordered_json::object();
    for (const auto& [id, value] : comparison.metrics)
        values[id] = std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
    return {{"test", comparison.test},     {"reference", comparison.reference}, {"channels", comparison.channels},
            {"pixels", comparison.pixels}, {"masked", comparison.masked},       {"missing", comparison.missing},
            {"metrics", std::move(values)}};
}

} // namespace gnomon
