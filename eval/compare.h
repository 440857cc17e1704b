#pragma once
// Compares two image files' worth of channels: which channels meet which, under which mask (eval/selection.h), and the
// metrics of each. The result is the JSON of `gnomon compare --json`.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "eval/metric/classes.h"
#include "eval/selection.h"

namespace gnomon {

struct Comparison {
    std::string test, reference;
    std::vector<std::string> channels; // of the test
    std::int64_t pixels = 0;           // of the image
    std::int64_t masked = 0;           // pixels that take part in at least one channel
    std::int64_t missing = 0;          // pixels inside the mask that are left out because a value is not finite
    std::vector<std::pair<std::string, double>>
        metrics; // in the order of metrics(); those that do not apply are absent
    std::optional<ConfusionTable>
        confusion; // of all visibilities together, where class_error or class_iou is asked for
};

// The channels R, G, B (of a colour that is missing in one of them, none takes part) and Y are compared as colours, all
// others by themselves; several channels' values are pooled as each metric says. Metrics that mean something on
// visibility alone are absent for colours. Throws what select_channels does, and UsageError for an unknown metric.
Comparison compare(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options = {});

// The same for groups that are selected already; pixels that are missing leave their masks.
Comparison compare(std::vector<ChannelGroup>& groups, const CompareOptions& options);

// What an error map of the same comparison shows: of one colour its luminance, else the mean over the compared
// channels; and their mask (empty: all pixels).
struct ComparedValues {
    Image<float> test, reference;
    Image<std::uint8_t> mask;
    std::string what; // "luminance", or the channels' names
};
ComparedValues compared_values(const ChannelImage& test, const ChannelImage& reference,
                               const CompareOptions& options = {});

// The numbers of a map and its title, such as "HDR-FLIP R G B".
struct MapValues {
    Image<float> values;
    std::string what;
};

// The mean of the FLIP maps of all that is compared, HDR-FLIP where it is scene-linear colour; NaN outside the mask and
// where a value is missing. Throws InputError where nothing that is compared is a picture.
MapValues compared_flip(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options = {});

// {"test", "reference", "channels", "pixels", "masked", "missing", "metrics": {…}, "confusion": {"classes", "pixels"}};
// an infinite value is null.
nlohmann::ordered_json comparison_json(const Comparison& comparison);
nlohmann::ordered_json metrics_json(const std::vector<std::pair<std::string, double>>& metrics);
nlohmann::ordered_json confusion_json(const ConfusionTable& table);

} // namespace gnomon
