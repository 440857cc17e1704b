#pragma once
// Compares two image files' worth of channels: which channels meet which, under which mask, and the metrics of each.
// The result is the JSON of `gnomon compare --json`.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/image_file.h"
#include "eval/metrics.h"

namespace gnomon {

enum class MaskSource {
    Images, // `<light>.M` beside a channel `<light>.V`, or else `M`: receivers that face the light; of both images
            // where both have one
    None,   // all pixels
    Given,  // CompareOptions::mask
};

struct CompareOptions {
    std::string test_name = "test", reference_name = "reference"; // in errors and in the result
    std::vector<std::string> metrics;                             // ids; empty or {"all"}: every metric that applies
    std::vector<std::string>
        channels; // empty: the visibility channels where both images have them, else R, G, B, else Y
    MaskSource mask_source = MaskSource::Images;
    Image<std::uint8_t> mask; // 1 in, 0 out
};

struct Comparison {
    std::string test, reference;
    std::vector<std::string> channels; // of the test
    std::int64_t pixels = 0;           // of the image
    std::int64_t masked = 0;           // pixels that take part in at least one channel
    std::int64_t missing = 0;          // pixels inside the mask that are left out because a value is not finite
    std::vector<std::pair<std::string, double>>
        metrics; // in the order of metrics(); those that do not apply are absent
};

// The channels R, G, B (of a colour that is missing in one of them, none takes part) and Y are compared as colours, all
// others by themselves; several channels' values are pooled as each metric says. Metrics that mean something on
// visibility alone are absent for colours. Throws InputError naming both files where the sizes differ, a channel is
// missing or the images have none in common, and UsageError for an unknown metric.
Comparison compare(const ChannelImage& test, const ChannelImage& reference, const CompareOptions& options = {});

// What an error map of the same comparison shows: the mean over the compared channels, and their mask (empty: all
// pixels).
struct ComparedValues {
    Image<float> test, reference;
    Image<std::uint8_t> mask;
};
ComparedValues compared_values(const ChannelImage& test, const ChannelImage& reference,
                               const CompareOptions& options = {});

// {"test", "reference", "channels", "pixels", "masked", "missing", "metrics": {…}}; an infinite value is null.
nlohmann::ordered_json comparison_json(const Comparison& comparison);

} // namespace gnomon
