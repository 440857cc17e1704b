#pragma once
// From several samples a pixel to one.

#include "raster/target.h"

namespace gnomon {

enum class ResolveMode { Average, Sample0, Minimum, Maximum };

// Layer by layer of `single`: the mean of a pixel's samples, summed in their order in float, or one of the other modes
// per channel. Depth formats take any mode but Average. `multi` has single.layers()·samples layers (see
// Targets::samples). Throws UsageError for targets that do not fit each other.
void resolve_samples(Pass& pass, const Target& multi, Target& single, int samples,
                     ResolveMode mode = ResolveMode::Average);

} // namespace gnomon
