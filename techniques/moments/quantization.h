#pragma once
// Four moments of depth in 16 bits a channel: an affine map that spreads what moments of depths in [0, 1] can be over
// the unit cube as evenly as can be, so that rounding costs least. Linear, so that filters work on what it gives.
// [Peters and Klein 2015, 3.3; the constants too]

#include "core/math.h"

namespace gnomon {

vec4 quantize_moments(vec4 b);           // Θ b + o, in [0, 1] for moments of depths in [0, 1]
vec4 dequantize_moments(vec4 quantized); // Θ⁻¹ (quantized − o)

} // namespace gnomon
