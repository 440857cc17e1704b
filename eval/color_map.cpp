#include "eval/color_map.h"

#include <algorithm>
#include <array>

namespace gnomon {

ColorMap blue_white_red() {
    static constexpr std::array<std::uint32_t, 11> anchors = {
        0x08306b, 0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xffffff, 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b, 0x67001f};
    return anchors;
}

ColorMap shadow_and_light() {
    // Strong colours right beside the grey: what is shown at all is wrong.
    static constexpr std::array<std::uint32_t, 21> anchors = {
        0x0a1f9c, 0x0c26b4, 0x0e2dcc, 0x1035e4, 0x123ffc, 0x1a52ff, 0x2466ff, 0x2e7bff, 0x3890ff, 0x42a5ff, 0x9a9a9a,
        0xffb300, 0xffa000, 0xff8c00, 0xff7800, 0xff6400, 0xfb4e08, 0xf03a10, 0xdc2814, 0xc81814, 0xb00810};
    return anchors;
}

ColorMap blue_green_red() {
    static constexpr std::array<std::uint32_t, 5> anchors = {0x0000ff, 0x00ffff, 0x00ff00, 0xffff00, 0xff0000};
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
