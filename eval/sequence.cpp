#include "eval/sequence.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "eval/metric/reduce.h"

namespace gnomon {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

// Where a frame's receivers are; empty where its images do not say.
struct Receivers {
    Image<vec3> positions; // NaN where nothing is seen
    mat4 world_to_ndc{1.0f};
};

Receivers receivers_of(const ChannelImage& image) {
    const Channel *x = image.find("P.X"), *y = image.find("P.Y"), *z = image.find("P.Z");
    const auto attribute = image.attributes.find("worldToNDC");
    const mat4* matrix = attribute == image.attributes.end() ? nullptr : std::get_if<mat4>(&attribute->second);
    if (!x || !y || !z || !matrix) return {};
    Receivers receivers{Image<vec3>(image.width, image.height), *matrix};
    for (size_t i = 0; i < receivers.positions.size(); ++i)
        receivers.positions.values()[i] = {x->values.values()[i], y->values.values()[i], z->values.values()[i]};
    return receivers;
}

// The distance to the nearer neighbour along each axis, the larger of the two: how far apart the receivers of
// neighbouring pixels lie.
float spacing(const Image<vec3>& positions, int x, int y) {
    const auto step = [&](int dx, int dy) {
        const int to_x = x + dx, to_y = y + dy;
        if (to_x < 0 || to_y < 0 || to_x >= positions.width() || to_y >= positions.height()) return infinity;
        const float distance = glm::distance(positions(x, y), positions(to_x, to_y));
        return std::isnan(distance) ? infinity : distance;
    };
    const float across = std::min(step(-1, 0), step(1, 0)), up = std::min(step(0, -1), step(0, 1));
    return std::isinf(across) ? up : std::isinf(up) ? across : std::max(across, up);
}

// The pixel of the frame before that shows the receiver, or (−1, −1).
ivec2 same_receiver(const Receivers& before, vec3 position) {
    const vec4 clip = before.world_to_ndc * vec4(position, 1.0f);
    if (!(clip.w > 0.0f)) return ivec2(-1);
    const auto pixel = [](float ndc, int size) {
        const float at = std::floor((0.5f + 0.5f * ndc) * static_cast<float>(size));
        return at >= 0.0f && at < static_cast<float>(size) ? static_cast<int>(at) : -1;
    };
    const ivec2 at(pixel(clip.x / clip.w, before.positions.width()), pixel(clip.y / clip.w, before.positions.height()));
    if (at.x < 0 || at.y < 0) return ivec2(-1);
    const float distance = glm::distance(before.positions(at.x, at.y), position);
    return distance <= spacing(before.positions, at.x, at.y) ? at : ivec2(-1);
}

Image<float> errors_of(const ImagePair& pair) {
    Image<float> errors(pair.test.width(), pair.test.height(), nan);
    parallel_for(errors.size(), 1 << 14, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            if (takes_part(pair, i)) errors.values()[i] = pair.test.values()[i] - pair.reference.values()[i];
    });
    return errors;
}

struct Changes {
    double absolute = 0.0, squares = 0.0;
    std::int64_t count = 0;
};

Changes changes_of(const Image<float>& now, const Receivers& receivers, const Image<float>& before,
                   const Receivers& receivers_before) {
    const bool known = !receivers.positions.empty() && !receivers_before.positions.empty();
    std::vector<Changes> rows(static_cast<size_t>(now.height()));
    parallel_for(rows.size(), 8, [&](size_t begin, size_t end) {
        for (size_t row = begin; row < end; ++row)
            for (int x = 0; x < now.width(); ++x) {
                const int y = static_cast<int>(row);
                if (std::isnan(now(x, y))) continue;
                const ivec2 at = known ? same_receiver(receivers_before, receivers.positions(x, y)) : ivec2(x, y);
                if (at.x < 0 || std::isnan(before(at.x, at.y))) continue;
                const double change = double{now(x, y)} - double{before(at.x, at.y)};
                rows[row].absolute += std::abs(change);
                rows[row].squares += change * change;
                ++rows[row].count;
            }
    });
    Changes total;
    for (const Changes& row : rows) {
        total.absolute += row.absolute;
        total.squares += row.squares;
        total.count += row.count;
    }
    return total;
}

void add_table(const std::optional<ConfusionTable>& table, std::optional<ConfusionTable>& sum) {
    if (!table) return;
    if (!sum) sum = ConfusionTable{};
    for (size_t r = 0; r < 3; ++r)
        for (size_t t = 0; t < 3; ++t) (*sum)[r][t] += (*table)[r][t];
}

std::optional<double> value_of(const Comparison& comparison, const std::string& id) {
    for (const auto& [name, value] : comparison.metrics)
        if (name == id) return value;
    return std::nullopt;
}

} // namespace

struct SequenceComparer::State {
    CompareOptions options;
    std::vector<SequenceComparison::Frame> frames;
    std::vector<Image<float>> errors; // of the frame before, one per channel
    Receivers receivers;
    Changes changes;
};

SequenceComparer::SequenceComparer(CompareOptions options) : state_(std::make_unique<State>()) {
    state_->options = std::move(options);
}
SequenceComparer::~SequenceComparer() = default;

void SequenceComparer::add(const std::string& name, const std::string& test_name, const ChannelImage& test,
                           const std::string& reference_name, const ChannelImage& reference, Image<std::uint8_t> mask) {
    CompareOptions options = state_->options;
    options.test_name = test_name, options.reference_name = reference_name;
    if (!mask.empty()) options.mask = std::move(mask);
    std::vector<ChannelGroup> groups = select_channels(test, reference, options);
    state_->frames.push_back({name, compare(groups, options)});
    if (state_->frames.size() > 1 &&
        state_->frames.front().comparison.channels != state_->frames.back().comparison.channels)
        throw InputError(fmt::format("'{}' has other channels to compare than the frames before it", test_name));

    std::vector<Image<float>> errors;
    for (const ChannelGroup& group : groups)
        for (size_t c = 0; c < group.channels.size(); ++c) errors.push_back(errors_of(group.pair(c)));
    Receivers receivers = receivers_of(reference);
    if (receivers.positions.empty()) receivers = receivers_of(test);
    for (size_t i = 0; i < state_->errors.size(); ++i) {
        if (errors[i].size() != state_->errors[i].size() || errors[i].width() != state_->errors[i].width())
            throw InputError(fmt::format("'{}' is of another size than the frames before it", test_name));
        const Changes changes = changes_of(errors[i], receivers, state_->errors[i], state_->receivers);
        state_->changes.absolute += changes.absolute;
        state_->changes.squares += changes.squares;
        state_->changes.count += changes.count;
    }
    state_->errors = std::move(errors);
    state_->receivers = std::move(receivers);
}

SequenceComparison SequenceComparer::finish() const {
    SequenceComparison sequence{state_->frames, {}};
    Comparison& whole = sequence.whole;
    whole.test = state_->options.test_name, whole.reference = state_->options.reference_name;
    for (const SequenceComparison::Frame& frame : sequence.frames) {
        whole.channels = frame.comparison.channels;
        whole.pixels += frame.comparison.pixels;
        whole.masked += frame.comparison.masked;
        whole.missing += frame.comparison.missing;
        add_table(frame.comparison.confusion, whole.confusion);
    }
    for (const Metric& metric : metrics()) {
        std::vector<double> values, weights;
        for (const SequenceComparison::Frame& frame : sequence.frames)
            if (const auto value = value_of(frame.comparison, metric.id)) {
                values.push_back(*value);
                weights.push_back(static_cast<double>(frame.comparison.masked));
            }
        if (const double value = pool(metric, values, weights); !std::isnan(value))
            whole.metrics.emplace_back(metric.id, value);
    }
    const auto wanted = [&](const std::string& id) {
        const std::vector<std::string>& ids = state_->options.metrics;
        return ids.empty() || std::find(ids.begin(), ids.end(), "all") != ids.end() ||
               std::find(ids.begin(), ids.end(), id) != ids.end();
    };
    if (const auto count = static_cast<double>(state_->changes.count); count > 0.0) {
        if (wanted("temporal_mean")) whole.metrics.emplace_back("temporal_mean", state_->changes.absolute / count);
        if (wanted("temporal_rms"))
            whole.metrics.emplace_back("temporal_rms", std::sqrt(state_->changes.squares / count));
    }
    return sequence;
}

nlohmann::ordered_json sequence_json(const SequenceComparison& sequence) {
    nlohmann::ordered_json json = comparison_json(sequence.whole), frames = nlohmann::ordered_json::array();
    for (const SequenceComparison::Frame& frame : sequence.frames) {
        nlohmann::ordered_json row = {{"frame", frame.name}};
        row.update(comparison_json(frame.comparison));
        frames.push_back(std::move(row));
    }
    json["frames"] = std::move(frames);
    return json;
}

} // namespace gnomon
