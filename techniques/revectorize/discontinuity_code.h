#pragma once
// Discontinuities as a texture of four 8-bit channels holds them between two passes: red 2·XM + XP, green 2·YP + YM, in
// quarters; blue 1 in the umbra; alpha 1 where there is a receiver. [Bondarev 2014 as in the author's early programs;
// Macedo 2018, 3.1.2]

#include "techniques/revectorize/silhouette.h"

namespace gnomon {

inline vec4 pack_discontinuities(unsigned sides, bool lit) {
    const auto quarters = [&](Side two, Side one) {
        return (sides & two ? 0.5f : 0.0f) + (sides & one ? 0.25f : 0.0f);
    };
    return {quarters(x_minus, x_plus), quarters(y_plus, y_minus), lit ? 0.0f : 1.0f, 1.0f};
}

// Bits of Side. 8 bits hold no quarters: what is read is rounded to the nearest one.
inline unsigned unpack_discontinuities(vec4 texel) {
    const auto bits = [](float value, Side two, Side one) {
        const int quarters = static_cast<int>(value * 4.0f + 0.5f);
        return (quarters & 2 ? unsigned{two} : 0u) | (quarters & 1 ? unsigned{one} : 0u);
    };
    return bits(texel.x, x_minus, x_plus) | bits(texel.y, y_plus, y_minus);
}

} // namespace gnomon
