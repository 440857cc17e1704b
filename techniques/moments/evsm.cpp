// Exponential variance shadow map: Chebyshev's bound on depths warped by e^(c⁺x), which parts layers that lie apart,
// and by −e^(−c⁻x), which bleeds elsewhere; the smaller of the two is taken. [Lauritzen 2008, 7.2 "exponential variance
// shadow maps"; Lauritzen and McCool 2008; Macedo 2018, 2.4]
//
// 1. moments: (w⁺, w⁺², w⁻, w⁻²), w⁺ = e^(c⁺x), w⁻ = −e^(−c⁻x), x = 2t − 1; the first two alone with components=two.
// 2. pre-filter.
// 3. look-up: V = min over the warps of Chebyshev's bound, σ² at least (min-deviation · c · w)².
//
// components=published is what the author of the thesis ran: (t, t²), V = min(Chebyshev, clamp(e^(c(μ − t)))).

#include <algorithm>
#include <cmath>

#include "techniques/all.h"
#include "techniques/moments/moment_map.h"

namespace gnomon {
namespace {

enum class Components { Four, Two, Published };

struct EvsmParams : MomentMapParams {
    Components components = Components::Four;
    MomentFormat format = MomentFormat::Float32;
    float positive = 40.0f;
    float negative = 5.0f;
    float published_exponent = 60.0f;
    float min_deviation = 1e-4f;
    EvsmParams() { plane_bias = 0.5f; }
};
constexpr auto evsm_fields =
    join(moment_map_fields,
         fields(field("components", &EvsmParams::components, "four|two|published",
                      "both warps, the positive one alone, or depth's own moments with the exponential of their mean",
                      "Lauritzen and McCool 2008; published: author's programs"),
                field("format", &EvsmParams::format, "float32|half",
                      "what the map stores a moment in; half holds exponents up to 5.5", "Lauritzen and McCool 2008"),
                field("positive", &EvsmParams::positive, 0.1, 1000, "",
                      "exponent of the positive warp, for depths in -1 to 1; 32 bits hold up to 42 and half up to 5.5",
                      "Lauritzen and McCool 2008"),
                field("negative", &EvsmParams::negative, 0.1, 1000, "", "exponent of the negative warp",
                      "Lauritzen and McCool 2008"),
                field("published-exponent", &EvsmParams::published_exponent, 1, 1000, "per linear depth",
                      "of components=published", "author's programs: 60"),
                field("min-deviation", &EvsmParams::min_deviation, 0, 1, "linear depth, from -1 to 1",
                      "least standard deviation of the look-up before the warp; published: of linear depth",
                      "Lauritzen and McCool 2008"),
                preset("published",
                       "size=2048,near=1,border=shadow,kernel=7,components=published,min-deviation=0,plane-bias=0",
                       "as in the author's program", "github.com/MarcioCerqueira/GlobalIllumination")));

class Evsm : public Technique {
public:
    explicit Evsm(EvsmParams params) : params_(params) {
        if (params_.components != Components::Published) require_float_sums(params_, "evsm");
    }

    Visibility shade(Frame& frame, const Light& light) override {
        const MomentMap map = moment_map(frame, light, params_);
        Target moments = draw_moments(frame, map, format(), [&](float t, float, float) { return encode(t); });
        Visibility visibility;
        show_channels(visibility, "moments", moments);
        const FilteredMap filtered = filter_map(frame, std::move(moments), params_);
        visibility.values =
            for_each_moment_point(frame, light, map, [&](const MomentPoint& at, PassCounters& counters) {
                return decode(filtered_mean(filtered, at, counters), at.t);
            });
        show_filtered(visibility, filtered, params_);
        return visibility;
    }

private:
    float positive_warp(float t) const { return std::exp(params_.positive * (2.0f * t - 1.0f)); }
    float negative_warp(float t) const { return -std::exp(-params_.negative * (2.0f * t - 1.0f)); }

    vec4 encode(float t) const {
        if (params_.components == Components::Published) return {t, t * t, 0.0f, 0.0f};
        const float p = positive_warp(t), n = negative_warp(t);
        return {p, p * p, n, n * n};
    }

    float decode(vec4 m, float t) const {
        const auto least = [&](float slope) {
            const float deviation = params_.min_deviation * slope;
            return deviation * deviation;
        };
        if (params_.components == Components::Published)
            return std::min(chebyshev(m.x, m.y, t, least(1.0f)), exponential(m.x, t, params_.published_exponent));
        const float p = positive_warp(t);
        const float lit = chebyshev(m.x, m.y, p, least(params_.positive * p));
        if (params_.components == Components::Two) return lit;
        const float n = negative_warp(t);
        return std::min(lit, chebyshev(m.z, m.w, n, least(params_.negative * n)));
    }

    Format format() const {
        const bool four = params_.components == Components::Four;
        if (params_.format == MomentFormat::Half) return four ? Format::RGBA16F : Format::RG16F;
        return four ? Format::RGBA32F : Format::RG32F;
    }

    EvsmParams params_;
};

} // namespace

Entry evsm_entry() {
    return make_entry<Evsm, EvsmParams>(
        {.id = "evsm",
         .title = "exponential variance shadow map",
         .family = "moments",
         .kind = TechniqueKind::Filtered,
         .paper = "Lauritzen, McCool 2008; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 2.4",
         .equations = "V = the smaller of s2/(s2 + (w - mu)^2) for the warps w = e^(positive x) and w = -e^(-negative "
                      "x), x = 2t - 1",
         .strengths = "light bleeds only where both warps let it; filters of any size for the price of one look-up",
         .artifacts =
             "light bleeds where casters lie close in front of the receiver; exponents above 42 overflow 32 bits"},
        evsm_fields);
}

} // namespace gnomon
