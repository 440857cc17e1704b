#pragma once
// Blending of one fragment with one texel, in float, before the format quantises.

#include "raster/state.h"

namespace gnomon {

vec4 blend(const BlendState& state, vec4 source, vec4 destination);

} // namespace gnomon
