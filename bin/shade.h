#pragma once
// One technique on one light of a frame: its answer, what it cost, and what is written into the file about it.

#include <map>
#include <string>

#include "bin/layers.h"
#include "bin/stats.h"

namespace gnomon {

struct Shaded {
    LitImage image;
    TechniqueStats stats;
};
// `light` is an index into the stage's lights; `label` names the technique in progress and statistics. Throws
// UsageError where the technique does not support the light.
Shaded shade_light(Frame& frame, const Stage& stage, size_t light, const TechniqueRequest& technique,
                   const std::string& label, bool show_progress);

// The attributes of an image by their names in the EXR; docs/command-line.md says what they mean.
std::map<std::string, Attribute> image_attributes(const Stage& stage, const Frame& frame,
                                                  const TechniqueRequest& technique);

} // namespace gnomon
