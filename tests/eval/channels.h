#pragma once
// Images of named constant channels, and what a comparison of them found.

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "eval/compare.h"

namespace gnomon_tests {

inline gnomon::ChannelImage with_channels(const std::vector<std::pair<std::string, float>>& values, int width = 16,
                                          int height = 12) {
    gnomon::ChannelImage image;
    for (const auto& [name, value] : values) image.add(name, gnomon::Image<float>(width, height, value));
    return image;
}

// NaN where the metric is absent.
inline double value_of(const gnomon::Comparison& comparison, const std::string& id) {
    for (const auto& [name, value] : comparison.metrics)
        if (name == id) return value;
    return std::nan("");
}

} // namespace gnomon_tests
