// Exponential shadow map: the shadow test as e^(c(z − t)), whose factor e^(cz) is filtered ahead of the look-up.
// [Annen, Mertens, Seidel, Flerackers, Kautz 2008; Salvi 2008; Macedo 2018, 2.4]
//
// 1. moments: linear depth t (store=log), or e^(c t) (store=exponential).
// 2. pre-filter of e^(c t); with store=log in log space: c·x₀ + log Σ w_k e^(c(x_k − x₀)).
// 3. look-up: V = clamp(E[e^(cz)] · e^(−c t)).

#include <algorithm>
#include <cmath>

#include "techniques/all.h"
#include "techniques/moments/moment_map.h"

namespace gnomon {
namespace {

enum class Store { Log, Exponential };

struct EsmParams : MomentMapParams {
    Store store = Store::Log;
    float exponent = 80.0f;
    float filter_exponent = 0.0f;
};
constexpr auto esm_fields = join(
    moment_map_fields,
    fields(field("store", &EsmParams::store, "log|exponential",
                 "log keeps depths, which never overflow, and needs prefilter=blur without footprint", "Salvi 2008"),
           field("exponent", &EsmParams::exponent, 1, 1000, "per linear depth",
                 "c: the larger, the less light gets past casters close to the receiver; above 88 store=exponential "
                 "overflows",
                 "Annen et al. 2008, 4.3"),
           field("filter-exponent", &EsmParams::filter_exponent, 0, 1000, "per linear depth",
                 "c of the blur of store=log; 0: exponent", "author's programs: 1"),
           preset("published", "size=2048,near=1,border=shadow,kernel=7,exponent=80,filter-exponent=1",
                  "as in the author's program", "github.com/MarcioCerqueira/GlobalIllumination")));

class Esm : public Technique {
public:
    explicit Esm(EsmParams params) : params_(params) {
        require_float_sums(params_, "esm");
        if (params_.store == Store::Log && (params_.prefilter != Prefilter::Blur || params_.footprint))
            throw UsageError("technique 'esm': a mip map or summed-area table is a sum of exponentials; use "
                             "store=exponential, or prefilter=blur without footprint");
    }

    Visibility shade(Frame& frame, const Light& light) override {
        const MomentMap map = moment_map(frame, light, params_);
        const float c = params_.exponent;
        const bool log = params_.store == Store::Log;
        Target moments = draw_moments(frame, map, Format::R32F, [&](float t, float, float) {
            return vec4(log ? t : std::exp(c * t), 0.0f, 0.0f, 0.0f);
        });
        Visibility visibility;
        show_channels(visibility, "moments", moments);
        FilteredMap filtered;
        if (log) {
            blur_map(frame, moments, params_, params_.filter_exponent > 0 ? params_.filter_exponent : c);
            filtered.levels.push_back(std::move(moments));
        } else {
            filtered = filter_map(frame, std::move(moments), params_);
        }
        visibility.values =
            for_each_moment_point(frame, light, map, [&](const MomentPoint& at, PassCounters& counters) {
                if (log) return bilinear_exponential(filtered.levels[0], at, c, counters);
                return saturate(filtered_mean(filtered, at, counters).x * std::exp(-c * at.t));
            });
        show_filtered(visibility, filtered, params_);
        return visibility;
    }

private:
    // The bilinear mean of e^(c z) of the four nearest texels, times e^(−c t).
    static float bilinear_exponential(const Target& map, const MomentPoint& at, float c, PassCounters& counters) {
        const vec2 corner = at.texel - 0.5f, low = glm::floor(corner), f = corner - low;
        const Sampler sampler = {.filter = Filter::Linear, .wrap = Wrap::Clamp};
        const vec2 uv = at.texel / vec2(static_cast<float>(map.width()), static_cast<float>(map.height()));
        const vec4 z = gather(map, sampler, uv, 0, counters, at.layer);
        // 1 is long passed where a power would overflow.
        const auto warped = [&](float depth) { return std::exp(std::min(c * (depth - at.t), 80.0f)); };
        const float upper = warped(z.x) * (1.0f - f.x) + warped(z.y) * f.x;
        const float lower = warped(z.w) * (1.0f - f.x) + warped(z.z) * f.x;
        return saturate(lower * (1.0f - f.y) + upper * f.y);
    }

    EsmParams params_;
};

} // namespace

Entry esm_entry() {
    return make_entry<Esm, EsmParams>(
        {.id = "esm",
         .title = "exponential shadow map",
         .family = "moments",
         .kind = TechniqueKind::Filtered,
         .paper = "Annen et al. 2008; Salvi 2008; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 2.4",
         .equations = "V = E[e^(cz)] e^(-ct), clamped to [0, 1]",
         .strengths = "one channel, filtered at any size for the price of one look-up; nothing leaks where casters lie "
                      "well in front of the receiver",
         .artifacts = "light leaks where caster and receiver touch, by e^(-c distance); receivers that are not plane "
                      "within the filter get lit or dark too much; above c = 88 store=exponential overflows"},
        esm_fields);
}

} // namespace gnomon
