// Filtered revectorization, V**: instead of a line through the steps, a ramp about one texel wide. [Macedo 2018, 4.1.1]
//
// 1. shadow map.
// 2. revectorize, per receiver: V_SM (3.2), sides (3.3), isolated texels and traversals as in rbsm-nonc.
//    Relative position r, negative where both ends of a run are closed (4.1); V = V**(V_SM, r) (4.2).

#include "techniques/all.h"
#include "techniques/revectorize/rbsm_nonc.h"

namespace gnomon {
namespace {

constexpr auto rbsm_filt_fields =
    join(rbsm_nonc_fields,
         fields(preset("published", "size=2048,near=1,border=shadow,eps-unit=window,stepping=float",
                       "as the author's program has it", "github.com/MarcioCerqueira/GlobalIllumination")));

class RbsmFilt : public Technique {
public:
    explicit RbsmFilt(RbsmNoncParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        return revectorize_receivers(
            frame, light, params_, [&](const MapSource& source, const SilhouetteRules& rules, const MapSample& sample) {
                return filtered(source, rules, sample, params_.flip_isolated);
            });
    }

private:
    RbsmNoncParams params_;
};

} // namespace

Entry rbsm_filt_entry() {
    return make_entry<RbsmFilt, RbsmNoncParams>(
        {.id = "rbsm-filt",
         .title = "revectorization-based shadow map, filtered",
         .family = "revectorization",
         .kind = TechniqueKind::Filtered,
         .paper = "Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 4.1.1",
         .equations = "(3.1) to (3.4), (4.1) as its text has it, (4.2)",
         .strengths = "a linear ramp on edges of slope 1/n, n up to max-size, whose middle is rbsm-nonc's edge; one "
                      "look-up",
         .artifacts = "the ramp is one texel wide, whatever the screen; edges along the map's axes get none and stay "
                      "hard; isolated texels vanish; else as rbsm-nonc"},
        rbsm_filt_fields);
}

} // namespace gnomon
