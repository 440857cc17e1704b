#pragma once
// `render --report`: every technique of a run measured against the reference, as one page.

#include <string>
#include <vector>

#include "bin/layers.h"
#include "bin/stats.h"
#include "eval/report/report.h"

namespace gnomon {

// A technique's finished images and where they are.
struct Rendered {
    TechniqueRequest technique;
    OutputFiles files;
    Image<vec3> radiance;
    std::vector<LitImage> images; // one a light
    size_t first_stats = 0;       // index into RunStats::techniques of the first light
};

// What --reference asks for, or the truth that fits the lights.
TechniqueRequest choose_reference(const RenderRequest& request, const std::vector<Light>& lights);

bool same_technique(const TechniqueRequest& a, const TechniqueRequest& b);

// Collects techniques, the reference first, then writes the page. With several lights the page shows the mean of their
// visibilities, and its metrics are those of `gnomon compare` on all of them.
class ReportBuilder {
public:
    ReportBuilder(const RenderRequest& request, const Stage& stage, const Frame& frame, float exposure);
    void add(const Rendered& rendered, const RunStats& stats);
    void write();

private:
    std::string relative_to_report(const std::string& path) const;

    const RenderRequest& request_;
    const Stage& stage_;
    const Frame& frame_;
    float exposure_;
    ReportData data_;
    ChannelImage reference_;
};

} // namespace gnomon
