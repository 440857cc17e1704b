// Gaussian shadow map: the moments of a variance shadow map, read as those of a normal distribution of depths instead
// of through Chebyshev's inequality: no bound, but a tail that falls off faster. [Gumbau, Sbert, Szirmay-Kalos,
// Chover, González 2013; Macedo 2018, 2.4]
//
// 1. moments: (w, w²) of warped depth w = t, or e^(c t) with warp=exponential.
// 2. pre-filter.
// 3. look-up: V = w ≤ μ ? 1 : h · erfc((w − μ)/(σ√2)), with h = 1, or ½ with tail=half.
//
// The distribution function itself, h = ½, halves the light at once where a receiver lies behind the mean by anything
// at all, so that a lit plane shows acne unless constant-bias or plane-bias keep it in front.

#include <cmath>

#include "techniques/all.h"
#include "techniques/moments/moment_map.h"

namespace gnomon {
namespace {

enum class Tail { Full, Half };
enum class Warp { None, Exponential };

struct GsmParams : MomentMapParams {
    Warp warp = Warp::None;
    float exponent = 40.0f;
    Tail tail = Tail::Full;
    float min_variance = 1e-6f;
};
constexpr auto gsm_fields = join(
    moment_map_fields,
    fields(field("warp", &GsmParams::warp, "none|exponential", "what depths are turned into before moments are taken",
                 "Gumbau et al. 2013, 4"),
           field("exponent", &GsmParams::exponent, 1, 1000, "per linear depth",
                 "c of warp=exponential; above 44 the second moment may overflow in 32 bits", "Gumbau et al. 2013, 4"),
           field("tail", &GsmParams::tail, "full|half",
                 "just behind the mean: full meets 1, half is what the distribution function says",
                 "Gumbau et al. 2013; full: ours"),
           field("min-variance", &GsmParams::min_variance, 0, 1, "linear depth squared",
                 "least variance of the look-up, scaled by the warp's slope squared",
                 "Donnelly and Lauritzen 2006, 4.1")));

class Gsm : public Technique {
public:
    explicit Gsm(GsmParams params) : params_(params) {
        if (params_.warp == Warp::Exponential) require_float_sums(params_, "gsm");
    }

    Visibility shade(Frame& frame, const Light& light) override {
        const MomentMap map = moment_map(frame, light, params_);
        Target moments = draw_moments(frame, map, Format::RG32F, [&](float t, float, float) {
            const float w = warped(t);
            return vec4(w, w * w, 0.0f, 0.0f);
        });
        Visibility visibility;
        show_channels(visibility, "moments", moments);
        const FilteredMap filtered = filter_map(frame, std::move(moments), params_);
        visibility.values =
            for_each_moment_point(frame, light, map, [&](const MomentPoint& at, PassCounters& counters) {
                const vec4 m = filtered_mean(filtered, at, counters);
                const float w = warped(at.t), slope = params_.warp == Warp::None ? 1.0f : params_.exponent * w;
                const float height = params_.tail == Tail::Full ? 1.0f : 0.5f;
                return gaussian_tail(m.x, m.y, w, params_.min_variance * slope * slope, height);
            });
        show_filtered(visibility, filtered, params_);
        return visibility;
    }

private:
    float warped(float t) const { return params_.warp == Warp::None ? t : std::exp(params_.exponent * t); }

    GsmParams params_;
};

} // namespace

Entry gsm_entry() {
    return make_entry<Gsm, GsmParams>(
        {.id = "gsm",
         .title = "Gaussian shadow map",
         .family = "moments",
         .kind = TechniqueKind::Filtered,
         .paper = "Gumbau et al. 2013; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 2.4",
         .equations = "V = erfc((t - mu)/(s sqrt 2)) behind the mean, half of that with tail=half, 1 before it",
         .strengths = "bleeds less than Chebyshev's bound far behind the mean",
         .artifacts = "no bound: dark where light is left, 0.32 of it (0.16 with "
                      "tail=half) between two even layers; bleeds with three layers"},
        gsm_fields);
}

} // namespace gnomon
