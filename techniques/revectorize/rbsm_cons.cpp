// Conservative revectorization-based shadow mapping: of the staircase of texels, the lit side is filled up to the line
// through its outer corners; what sm darkens stays dark. [Macedo 2018, 3.1, algorithm 1, appendices A and B]
//
// 1. shadow map.
// 2. revectorize, per receiver: V_SM = 0: V = 0 (3.2). Sides of the texel where V_SM changes (3.3); none: V = 1.
//    Distances to the ends of the run, four traversals [3.1.3]; shape T (3.4); relative position r (3.5).
//    V = 0 where r.x·r.y > 0 and 1 − r.x > r.y (3.6).
//
// variant=unity is the one for a game engine that lets a program compare but not read: a bilinear comparison above 0
// means that any of the 2×2 texels around the point is lit, on a grid half a texel off. It walks without ε, and takes a
// run along y that both ends close for one that is closed above. [appendix B]

#include "core/error.h"
#include "techniques/all.h"
#include "techniques/revectorize/map_silhouette.h"

namespace gnomon {
namespace {

enum class Variant { Glsl, Unity };

struct RbsmConsParams : RevectorizeParams {
    RbsmConsParams() {
        continuation = Continuation::Any;
        reject_isolated_end = false;
    }
    bool fill_gaps = false;
    Variant variant = Variant::Glsl;
};
constexpr auto rbsm_cons_fields =
    join(revectorize_fields,
         fields(field("fill-gaps", &RbsmConsParams::fill_gaps,
                      "a lit texel between two shadows, along x or along y, is dark", "author's programs"),
                field("variant", &RbsmConsParams::variant, "glsl|unity",
                      "unity: for a spot light whose map can only be compared with, two by two texels at a time",
                      "Macedo 2018, appendix B"),
                preset("published", "size=2048,near=1,border=shadow,eps-unit=window,stepping=float,fill-gaps=on",
                       "as the author's program has it", "github.com/MarcioCerqueira/GlobalIllumination")));

// Texel t of the dilated map covers the points that lie between the centres of texels t and t + 1.
struct DilatedSource {
    const MapSource& source;
    float behind(ivec2 texel, float depth) const {
        const auto row = [&](int y) {
            return std::min(source.behind({texel.x, y}, depth), source.behind({texel.x + 1, y}, depth));
        };
        return std::min(row(texel.y), row(texel.y + 1));
    }
};

class RbsmCons : public Technique {
public:
    explicit RbsmCons(RbsmConsParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        if (params_.variant == Variant::Unity) return shade_unity(frame, light);
        return revectorize_receivers(
            frame, light, params_, [&](const MapSource& source, const SilhouetteRules& rules, const MapSample& sample) {
                return conservative(source, rules, sample, {.fill_gaps = params_.fill_gaps});
            });
    }

private:
    Visibility shade_unity(Frame& frame, const Light& light) const {
        if (light.type != LightType::Spot)
            throw UsageError("technique 'rbsm-cons': variant=unity needs a spot light, and '" + light.name + "' is a " +
                             light_type_name(light.type) + " light; variant=glsl takes every light");
        return revectorize_receivers(
            frame, light, params_, [&](const MapSource& source, const SilhouetteRules& rules, const MapSample& sample) {
                const MapSample shifted = {sample.texels - 0.5f, sample.depth, 0.0f};
                return conservative(DilatedSource{source}, rules, shifted,
                                    {.fill_gaps = params_.fill_gaps, .vertical_u_as_l = true});
            });
    }

    RbsmConsParams params_;
};

} // namespace

Entry rbsm_cons_entry() {
    return make_entry<RbsmCons, RbsmConsParams>(
        {.id = "rbsm-cons",
         .title = "revectorization-based shadow map, conservative",
         .family = "revectorization",
         .kind = TechniqueKind::Hard,
         .paper = "Macedo, Apolinario 2016; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 3.1, algorithm 1, appendices A and B",
         .equations = "(3.1) to (3.6)",
         .strengths = "no staircase on edges of slope 1/n, n up to max-size; walks on the lit side alone; never lights "
                      "what sm darkens; needs nothing but the shadow map",
         .artifacts =
             "shadows grow by half a texel; concave corners are filled by long wedges, one-texel gaps close to "
             "a V; one-texel steps on long straight edges grow wedges of max-size; runs longer than max-size "
             "keep their steps; blockers nearer than slope-eps end no run"},
        rbsm_cons_fields);
}

} // namespace gnomon
