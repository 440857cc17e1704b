#pragma once
// Runs techniques the way the command line does, and the comparisons that several tests make.

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "techniques/technique.h"

namespace gnomon_tests {

// "pcf:size=512" on one light of the frame.
inline gnomon::Visibility shade(gnomon::Frame& frame, const gnomon::Light& light, const std::string& text) {
    const gnomon::Specification specification = gnomon::parse_specification(text);
    const gnomon::Entry& entry = gnomon::find_technique(specification.name);
    frame.begin_technique();
    return gnomon::run_technique(entry, *entry.make(specification.parameters), frame, light);
}

// Root mean square difference over receivers that face the light.
inline double facing_rmse(const gnomon::Frame& frame, const gnomon::Light& light, const gnomon::Image<float>& a,
                          const gnomon::Image<float>& b) {
    double sum = 0;
    std::int64_t count = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        const gnomon::Receiver& receiver = frame.receivers().data()[i];
        if (!receiver.valid() || !faces_light(receiver, light)) continue;
        const double difference = static_cast<double>(a.data()[i]) - static_cast<double>(b.data()[i]);
        sum += difference * difference;
        ++count;
    }
    return count ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

// Whether some pixel within `reach` of (x, y) differs from it in what `value` says.
template <class Value> bool changes_nearby(int x, int y, int width, int height, int reach, const Value& value) {
    const auto here = value(x, y);
    for (int j = std::max(0, y - reach); j <= std::min(height - 1, y + reach); ++j)
        for (int i = std::max(0, x - reach); i <= std::min(width - 1, x + reach); ++i)
            if (value(i, j) != here) return true;
    return false;
}

// An inner image that a technique shows; the test fails without it.
inline const gnomon::Image<float>& debug_image(const gnomon::Visibility& visibility, const std::string& name) {
    for (const gnomon::NamedImage& image : visibility.debug)
        if (image.name == name) return image.values;
    throw std::runtime_error("no inner image " + name);
}

inline gnomon::Light point_light(gnomon::vec3 position) {
    gnomon::Light light;
    light.position = position;
    return light;
}

// A receiver plane y = 0 and, above it, a box [−0.5, 0.5] × [0.5, 1.5] × [−0.5, 0.5], seen from above.
gnomon::Scene box_over_floor();

} // namespace gnomon_tests
