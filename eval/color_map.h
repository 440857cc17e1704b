#pragma once
// Colour maps as evenly spaced sRGB anchors with linear interpolation between them, shared by the pictures that are
// drawn here and by the report's page, so that both show one value in one colour.

#include <cstdint>
#include <span>

#include "core/math.h"

namespace gnomon {

using ColorMap = std::span<const std::uint32_t>; // 0xrrggbb

ColorMap blue_white_red();   // diverging: dark blue at 0, white at 0.5, dark red at 1
ColorMap shadow_and_light(); // diverging: deep to bright blue below 0.5, orange to deep red above; grey at 0.5
ColorMap blue_green_red();   // blue at 0 over cyan, green and yellow to red at 1: the false colours of papers
ColorMap magma(); // sequential, perceptually uniform: black at 0, pale yellow at 1 [van der Walt and Smith 2015]

// The display-referred sRGB colour at `t`, clamped to [0, 1].
vec3 map_color(ColorMap map, float t);

} // namespace gnomon
