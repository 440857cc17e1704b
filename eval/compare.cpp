#include "eval/compare.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "eval/flip.h"
#include "eval/metric/reduce.h"

namespace gnomon {
namespace {

using Kind = ChannelGroup::Kind;
using Domain = Metric::Domain;

// Where one component of a colour is missing, the others are left out too. Returns how many pixels are.
std::int64_t drop_missing(ChannelGroup& group) {
    std::int64_t missing = 0;
    for (size_t c = 0; c < group.channels.size(); ++c) {
        const std::int64_t of_channel = count_missing(group.pair(c));
        if (of_channel == 0) continue;
        missing += of_channel;
        const Image<float>& test = *group.channels[c].test;
        if (group.mask.empty()) group.mask = Image<std::uint8_t>(test.width(), test.height(), 1);
        const ImagePair masked = group.pair(c);
        for (size_t i = 0; i < group.mask.size(); ++i)
            if (!takes_part(masked, i)) group.mask.values()[i] = 0;
    }
    return missing;
}

void check_metrics(const CompareOptions& options) {
    std::vector<std::string> known = {"all"};
    for (const Metric& metric : metrics()) known.push_back(metric.id);
    for (const std::string& id : options.metrics)
        if (std::find(known.begin(), known.end(), id) == known.end())
            throw UsageError(fmt::format("there is no metric '{}'{}", id, did_you_mean(id, known)));
}

bool is_wanted(const CompareOptions& options, const std::string& id) {
    const auto asked_for = [&](const std::string& name) {
        return std::find(options.metrics.begin(), options.metrics.end(), name) != options.metrics.end();
    };
    return options.metrics.empty() || asked_for("all") || asked_for(id);
}

bool applies(Domain domain, const ChannelGroup& group) {
    switch (domain) {
    case Domain::Any:
        return true;
    case Domain::Visibility:
        return group.kind == Kind::Visibility;
    case Domain::Picture:
        return group.kind != Kind::Data;
    case Domain::SceneLinear:
        return group.kind == Kind::Color && !group.srgb;
    case Domain::Sequence:
        break;
    }
    return false;
}

std::vector<std::int64_t> masked_pixels(const std::vector<ChannelGroup>& groups) {
    std::vector<std::int64_t> counts; // one component of a group stands for all, missing pixels being dropped
    for (const ChannelGroup& group : groups) counts.push_back(count_masked(group.pair(0)));
    return counts;
}

// Appends the wanted ones of a measure's metrics.
void add_measure(const Measure& measure, const std::vector<ChannelGroup>& groups,
                 const std::vector<std::int64_t>& pixels, const CompareOptions& options, Comparison& comparison) {
    std::vector<std::vector<double>> values(measure.metrics.size());
    std::vector<double> weights;
    const auto add = [&](const std::vector<double>& row, size_t group) {
        for (size_t i = 0; i < row.size(); ++i) values[i].push_back(row[i]);
        weights.push_back(static_cast<double>(pixels[group]));
    };
    for (size_t g = 0; g < groups.size(); ++g) {
        if (!applies(measure.metrics[0].domain, groups[g])) continue;
        if (measure.of_channel)
            for (size_t c = 0; c < groups[g].channels.size(); ++c) add(measure.of_channel(groups[g].pair(c)), g);
        else if (const auto color = groups[g].color())
            add(measure.of_color(*color), g);
    }
    for (size_t i = 0; i < measure.metrics.size(); ++i) {
        if (!is_wanted(options, measure.metrics[i].id)) continue;
        if (const double value = pool(measure.metrics[i], values[i], weights); !std::isnan(value))
            comparison.metrics.emplace_back(measure.metrics[i].id, value);
    }
}

std::optional<ConfusionTable> confusion_of(const std::vector<ChannelGroup>& groups) {
    std::optional<ConfusionTable> total;
    for (const ChannelGroup& group : groups) {
        if (group.kind != Kind::Visibility) continue;
        const ConfusionTable table = count_classes(group.pair(0));
        if (!total) total = ConfusionTable{};
        for (size_t r = 0; r < 3; ++r)
            for (size_t t = 0; t < 3; ++t) (*total)[r][t] += table[r][t];
    }
    return total;
}

std::int64_t in_any_mask(const std::vector<ChannelGroup>& groups, size_t pixels) {
    const auto all = [](const ChannelGroup& group) { return group.mask.empty(); };
    if (std::any_of(groups.begin(), groups.end(), all)) return static_cast<std::int64_t>(pixels);
    return reduce_pixels(pixels,
                         [&](size_t pixel, PixelSum& sum) {
                             for (const ChannelGroup& group : groups)
                                 if (group.mask.values()[pixel] != 0) return sum.add(0.0);
                         })
        .count;
}

// How much each channel of a map's value counts.
std::vector<double> shares(const std::vector<ChannelGroup>& groups) {
    const bool luminance = groups.size() == 1 && groups[0].kind == Kind::Color && groups[0].channels.size() == 3;
    if (luminance && groups[0].color()) {
        std::vector<double> weights;
        for (const ComparedChannel& channel : groups[0].channels)
            weights.push_back(channel.name.ends_with('R') ? 0.2126 : channel.name.ends_with('G') ? 0.7152 : 0.0722);
        return weights;
    }
    size_t channels = 0;
    for (const ChannelGroup& group : groups) channels += group.channels.size();
    return std::vector<double>(channels, 1.0);
}

} // namespace

Comparison compare(std::vector<ChannelGroup>& groups, const CompareOptions& options) {
    check_metrics(options);
    const Image<float>& first = *groups.at(0).channels.at(0).test;
    Comparison comparison;
    comparison.test = options.test_name, comparison.reference = options.reference_name;
    comparison.pixels = static_cast<std::int64_t>(first.size());
    for (ChannelGroup& group : groups) {
        comparison.missing += drop_missing(group);
        for (const ComparedChannel& channel : group.channels) comparison.channels.push_back(channel.name);
    }
    comparison.masked = in_any_mask(groups, first.size());
    const std::vector<std::int64_t> pixels = masked_pixels(groups);
    for (const Measure& measure : measures())
        if (std::any_of(measure.metrics.begin(), measure.metrics.end(),
                        [&](const Metric& metric) { return is_wanted(options, metric.id); }))
            add_measure(measure, groups, pixels, options, comparison);
    if (is_wanted(options, "class_error") || is_wanted(options, "class_iou"))
        comparison.confusion = confusion_of(groups);
    return comparison;
}

Comparison compare(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options) {
    check_metrics(options);
    std::vector<ChannelGroup> groups = select_channels(test, reference, options);
    return compare(groups, options);
}

ComparedValues compared_values(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options) {
    const std::vector<ChannelGroup> groups = select_channels(test, reference, options);
    ComparedValues values{Image<float>(test.width, test.height), Image<float>(test.width, test.height), {}, ""};
    const std::vector<double> weights = shares(groups);
    for (const ChannelGroup& group : groups)
        for (const ComparedChannel& channel : group.channels)
            values.what += (values.what.empty() ? "" : " ") + channel.name;
    if (weights[0] != 1.0) values.what = "luminance";
    const bool masked =
        std::all_of(groups.begin(), groups.end(), [](const ChannelGroup& group) { return !group.mask.empty(); });
    if (masked) values.mask = Image<std::uint8_t>(test.width, test.height);
    parallel_for(values.test.size(), 1 << 14, [&](size_t begin, size_t end) {
        for (size_t pixel = begin; pixel < end; ++pixel) {
            double test_sum = 0.0, reference_sum = 0.0, weight = 0.0;
            size_t next = 0;
            for (const ChannelGroup& group : groups)
                for (const ComparedChannel& channel : group.channels) {
                    const double share = weights[next++];
                    if (!group.mask.empty() && group.mask.values()[pixel] == 0) continue;
                    test_sum += share * channel.test->values()[pixel];
                    reference_sum += share * channel.reference->values()[pixel];
                    weight += share;
                }
            if (weight > 0.0) values.test.values()[pixel] = static_cast<float>(test_sum / weight);
            if (weight > 0.0) values.reference.values()[pixel] = static_cast<float>(reference_sum / weight);
            if (masked) values.mask.values()[pixel] = weight > 0.0;
        }
    });
    return values;
}

MapValues compared_flip(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options) {
    const std::vector<ChannelGroup> groups = select_channels(test, reference, options);
    Image<float> mean(test.width, test.height, 0.0f), counts(test.width, test.height, 0.0f);
    std::string what;
    for (const ChannelGroup& group : groups) {
        const auto color = group.color();
        if (!color) continue;
        const bool hdr = applies(Domain::SceneLinear, group);
        if (what.empty()) what = hdr ? "HDR-FLIP" : "FLIP";
        for (const ComparedChannel& channel : group.channels) what += " " + channel.name;
        const Image<float> map = hdr ? flip_hdr_map(*color) : flip_map(*color);
        for (size_t i = 0; i < map.size(); ++i) {
            if (std::isnan(map.values()[i])) continue;
            mean.values()[i] += map.values()[i];
            counts.values()[i] += 1.0f;
        }
    }
    if (what.empty())
        throw InputError(fmt::format("the channels of '{}' that are compared are no picture", options.test_name));
    for (size_t i = 0; i < mean.size(); ++i) mean.values()[i] /= counts.values()[i]; // NaN where none takes part
    return {std::move(mean), what};
}

nlohmann::ordered_json metrics_json(const std::vector<std::pair<std::string, double>>& values) {
    nlohmann::ordered_json json = nlohmann::ordered_json::object();
    for (const auto& [id, value] : values)
        json[id] = std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
    return json;
}

nlohmann::ordered_json confusion_json(const ConfusionTable& table) {
    return {{"classes", {"umbra", "penumbra", "lit"}}, {"pixels", table}};
}

nlohmann::ordered_json comparison_json(const Comparison& comparison) {
    nlohmann::ordered_json json = {{"test", comparison.test},
                                   {"reference", comparison.reference},
                                   {"channels", comparison.channels},
                                   {"pixels", comparison.pixels},
                                   {"masked", comparison.masked},
                                   {"missing", comparison.missing},
                                   {"metrics", metrics_json(comparison.metrics)}};
    if (comparison.confusion) json["confusion"] = confusion_json(*comparison.confusion);
    return json;
}

} // namespace gnomon
