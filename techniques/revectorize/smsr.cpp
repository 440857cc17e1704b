// Shadow map silhouette revectorization, the two-pass ancestor of rbsm-cons: discontinuities of lit receivers go to a
// texture first, then a second pass walks the map from there. [Bondarev 2014; Macedo 2018, 2.3.3 and 3]
//
// 1. shadow map.
// 2. discontinuities: per receiver, sides of the texel where V_SM changes (3.3), packed into 8 bits a channel.
// 3. revectorize: V_SM = 0: V = 0. No sides: V = 1. Shadows on both sides along an axis: V = 0.
//    Distances to the ends of the run, by a depth traversal-bias nearer to the light, without the rule for slopes;
//    shape T (3.4), relative position r (3.5); V = 0 where r.x·r.y > 0 and 1 − r.x > r.y (3.6).
//
// The original draws the scene twice; here both passes are full-screen over the G-buffer.

#include "techniques/all.h"
#include "techniques/revectorize/discontinuity_code.h"
#include "techniques/revectorize/map_silhouette.h"

namespace gnomon {
namespace {

struct SmsrParams : RevectorizeParams {
    SmsrParams() {
        slope_eps = 0.0f;
        continuation = Continuation::Any;
        reject_isolated_end = false;
    }
    float traversal_bias = 2.5e-5f;
    bool fill_gaps = true;
};
constexpr auto smsr_fields =
    join(revectorize_fields,
         fields(field("traversal-bias", &SmsrParams::traversal_bias, 0, 1, "depth",
                      "subtracted from the receiver's depth before it walks; its unit is eps-unit's",
                      "author's early programs"),
                field("fill-gaps", &SmsrParams::fill_gaps,
                      "a lit texel between two shadows, along x or along y, is dark", "Bondarev 2014"),
                preset("published", "size=2048,near=1,border=shadow,eps-unit=window,stepping=float",
                       "as the author's early program has it", "github.com/MarcioCerqueira/GlobalIllumination")));

class Smsr : public Technique {
public:
    explicit Smsr(SmsrParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const ShadowMap map = draw_shadow_map(frame, light, params_);
        const Target discontinuities = find_discontinuities(frame, light, map);
        const SilhouetteRules rules = silhouette_rules(params_);
        SilhouetteImages images(frame);
        Visibility visibility;
        visibility.values = for_each_receiver(frame, "revectorize", [&](const Receiver& receiver, Pixel& pixel) {
            count_texels(discontinuities, 1, pixel.counters);
            const vec4 texel = discontinuities.load(pixel.x, pixel.y);
            if (texel.z > 0.5f) return 0.0f;
            Revectorized result{1.0f, true, unpack_discontinuities(texel), vec2(0.0f)};
            if (result.discontinuities == 0) return 1.0f;
            if (params_.fill_gaps && closes_gap(result.discontinuities)) {
                result.visibility = 0.0f;
            } else {
                const MapPoint point = map_point(map, light, receiver, params_.receiver_plane);
                const MapSource source{map, point, pixel.counters};
                const Silhouette silhouette(source, rules);
                SilhouettePoint p = silhouette.point(sample_of(map, point));
                p.depth -= window_eps(params_.traversal_bias, params_, map, point);
                result.relative =
                    relative_position(silhouette.distances(p, result.discontinuities), true, rules.max_size);
                result.visibility = conservative_visibility(result.relative) ? 1.0f : 0.0f;
            }
            images.set(pixel, result);
            return result.visibility;
        });
        images.move_to(visibility);
        return visibility;
    }

private:
    MapSample sample_of(const ShadowMap& map, const MapPoint& point) const {
        return {point.texel, point.depth, window_eps(params_.slope_eps, params_, map, point)};
    }

    Target find_discontinuities(Frame& frame, const Light& light, const ShadowMap& map) const {
        Pass pass = frame.pass("discontinuities");
        Target target = frame.target(Format::RGBA8, frame.width(), frame.height());
        const SilhouetteRules rules = silhouette_rules(params_);
        full_screen(pass, Targets{.color = {&target}}, [&](Pixel& pixel) {
            const Receiver& receiver = frame.receivers()(pixel.x, pixel.y);
            if (!receiver.valid()) return;
            const MapPoint point = map_point(map, light, receiver, params_.receiver_plane);
            pixel.color[0] = pack_discontinuities(0, !point.dark);
            if (point.lit || point.dark) return;
            const MapSource source{map, point, pixel.counters};
            const Silhouette silhouette(source, rules);
            const SilhouettePoint p = silhouette.point(sample_of(map, point));
            pixel.color[0] =
                pack_discontinuities(p.lit ? silhouette.discontinuities(p.place, p.depth, true) : 0u, p.lit);
        });
        return target;
    }

    SmsrParams params_;
};

} // namespace

Entry smsr_entry() {
    return make_entry<Smsr, SmsrParams>(
        {.id = "smsr",
         .title = "shadow map silhouette revectorization",
         .family = "revectorization",
         .kind = TechniqueKind::Hard,
         .paper = "Bondarev 2014; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 2.3.3 and introduction of 3",
         .equations = "(3.1), (3.3) to (3.6), which later work made of it",
         .strengths = "no staircase on edges of slope 1/n, n up to max-size",
         .artifacts =
             "two passes and a texture between them; false run ends on sloped receivers; one-texel gaps close; "
             "else as rbsm-cons"},
        smsr_fields);
}

} // namespace gnomon
