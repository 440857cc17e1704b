#pragma once
// `render --report`: each technique measured against the reference, as one page.

#include <vector>

#include "bin/layers.h"

namespace gnomon {

// A technique's finished images and where they are.
struct Rendered {
    TechniqueRequest technique;
    OutputFiles files;
    Image<vec3> radiance;
    std::vector<LitImage> images; // one a light
    size_t first_stats = 0;       // index into RunStats::techniques of the first light
};

} // namespace gnomon
