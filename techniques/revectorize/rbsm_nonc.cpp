// Non-conservative revectorization-based shadow mapping: the staircase of texels is replaced, from both sides, by the
// line through the middle of its steps. [Macedo 2018, 3.2, algorithm 1]
//
// 1. shadow map.
// 2. revectorize, per receiver: V_SM (3.2), sides of the texel where it changes (3.3); none: V = V_SM.
//    All four, an isolated texel: V = 1 − V_SM.
//    Distances to the ends of the run, four traversals [3.2.3]; shape T (3.4); relative position r (3.5).
//    V = V*(V_SM, r) (3.9).

#include "techniques/revectorize/rbsm_nonc.h"
#include "techniques/all.h"

namespace gnomon {

Visibility revectorize_hard(Frame& frame, const Light& light, const RbsmNoncParams& params) {
    return revectorize_receivers(frame, light, params,
                                 [&](const MapSource& source, const SilhouetteRules& rules, const MapSample& sample) {
                                     return nonconservative(source, rules, sample, params.flip_isolated);
                                 });
}

namespace {

constexpr auto entry_fields =
    join(rbsm_nonc_fields,
         fields(preset("published", "size=2048,near=1,border=shadow,eps-unit=window,stepping=float",
                       "as the author's program has it", "github.com/MarcioCerqueira/GlobalIllumination")));

class RbsmNonc : public Technique {
public:
    explicit RbsmNonc(RbsmNoncParams params) : params_(params) {}
    Visibility shade(Frame& frame, const Light& light) override { return revectorize_hard(frame, light, params_); }

private:
    RbsmNoncParams params_;
};

} // namespace

Entry rbsm_nonc_entry() {
    return make_entry<RbsmNonc, RbsmNoncParams>(
        {.id = "rbsm-nonc",
         .title = "revectorization-based shadow map, non-conservative",
         .family = "revectorization",
         .kind = TechniqueKind::Hard,
         .paper = "Macedo, Apolinario 2016; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 3.2, algorithm 1",
         .equations = "(3.1) to (3.5), (3.7) to (3.9)",
         .strengths =
             "no staircase on edges of slope 1/n, n up to max-size, and the edge where it belongs; keeps areas; "
             "needs nothing but the shadow map, and walks on silhouettes alone",
         .artifacts =
             "convex corners are cut, concave ones filled, by wedges of half max-size; one-texel steps on long "
             "straight edges become ramps; runs longer than max-size keep their steps; one-texel diagonal "
             "lines vanish; blockers nearer than slope-eps end no run"},
        entry_fields);
}

} // namespace gnomon
