// Variance shadow map: depth and squared depth, filtered ahead of the look-up; Chebyshev's inequality bounds the lit
// fraction. [Donnelly and Lauritzen 2006; Macedo 2018, 2.4]
//
// 1. moments: (t, t² + ¼((∂t/∂x)² + (∂t/∂y)²)) of linear depth t, cleared to (1, 1).
// 2. pre-filter: blur, mip map or summed-area table.
// 3. look-up: V = t ≤ μ ? 1 : σ²/(σ² + (t − μ)²), σ² at least min-variance; then light bleeding is cut.

#include "techniques/all.h"
#include "techniques/moments/moment_map.h"

namespace gnomon {
namespace {

struct VsmParams : MomentMapParams {
    MomentFormat format = MomentFormat::Float32;
    bool slope_variance = true;
    float min_variance = 1e-6f;
};
constexpr auto vsm_fields = join(
    moment_map_fields,
    fields(field("format", &VsmParams::format, "float32|half|unorm16", "what the map stores a moment in",
                 "Donnelly and Lauritzen 2006, 4"),
           field("slope-variance", &VsmParams::slope_variance,
                 "adds the variance of depth within a texel, a quarter of its squared gradient, to the second moment",
                 "Donnelly and Lauritzen 2006, 4.1"),
           field("min-variance", &VsmParams::min_variance, 0, 1, "linear depth squared",
                 "least variance of the look-up", "Donnelly and Lauritzen 2006, 4.1"),
           preset("published", "size=2048,near=1,border=shadow,kernel=7,slope-variance=true,min-variance=0",
                  "as in the author's program", "github.com/MarcioCerqueira/GlobalIllumination")));

class Vsm : public Technique {
public:
    explicit Vsm(VsmParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const MomentMap map = moment_map(frame, light, params_);
        const float slope_share = params_.slope_variance ? 0.25f : 0.0f;
        Target moments = draw_moments(frame, map, format(), [&](float t, float dx, float dy) {
            return vec4(t, t * t + slope_share * (dx * dx + dy * dy), 0.0f, 0.0f);
        });
        Visibility visibility;
        show_channels(visibility, "moments", moments);
        const FilteredMap filtered = filter_map(frame, std::move(moments), params_);
        visibility.values =
            for_each_moment_point(frame, light, map, [&](const MomentPoint& at, PassCounters& counters) {
                const vec4 m = filtered_mean(filtered, at, counters);
                return chebyshev(m.x, m.y, at.t, params_.min_variance);
            });
        show_filtered(visibility, filtered, params_);
        return visibility;
    }

private:
    Format format() const {
        switch (params_.format) {
        case MomentFormat::Half:
            return Format::RG16F;
        case MomentFormat::Unorm16:
            return Format::RG16;
        default:
            return Format::RG32F;
        }
    }

    VsmParams params_;
};

} // namespace

Entry vsm_entry() {
    return make_entry<Vsm, VsmParams>(
        {.id = "vsm",
         .title = "variance shadow map",
         .family = "moments",
         .kind = TechniqueKind::Filtered,
         .paper = "Donnelly, Lauritzen 2006; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 2.4",
         .equations = "V = s2/(s2 + (t - mu)^2) behind the mean, 1 before it; mu = E[z], s2 = E[z^2] - mu^2",
         .strengths = "filters of any size for the price of one look-up; no bias where a plane is seen at a slant",
         .artifacts = "light bleeds through a caster where the filter also covers a nearer one: V = s2/(s2 + (t - "
                      "mu)^2) > 0 in the umbra"},
        vsm_fields);
}

} // namespace gnomon
