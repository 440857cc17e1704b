#include "eval/color_map.h"

#include <algorithm>
#include <array>

namespace gnomon {

ColorMap blue_white_red() {
    static constexpr std::array<std::uint32_t, 11> anchors = {
        0x08306b, 0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xffffff, 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b, 0x67001f};
    return anchors;
}

ColorMap magma() {
    // Every 17th of the map's 256 colours; between them it is within 3/255 of straight.
    static constexpr std::array<std::uint32_t, 16> anchors = {
        0x000004, 0x0b0924, 0x20114b, 0x3b0f70, 0x57157e, 0x721f81, 0x8c2981, 0xa8327d,
        0xc43c75, 0xde4968, 0xf1605d, 0xfa7f5e, 0xfe9f6d, 0xfebf84, 0xfddea0, 0xfcfdbf,
    };
    return anchors;
}

vec3 map_color(ColorMap map, float t) {
    const auto anchor = [&](size_t i) {
        return vec3(static_cast<float>(map[i] >> 16), static_cast<float>(map[i] >> 8 & 0xff),
                    static_cast<float>(map[i] & 0xff)) /
               255.0f;
    };
    const float position = std::clamp(t, 0.0f, 1.0f) * static_cast<float>(map.size() - 1);
    const size_t first = std::min(static_cast<size_t>(position), map.size() - 2);
    return glm::mix(anchor(first), anchor(first + 1), position - static_cast<float>(first));
}

} // namespace gnomon
