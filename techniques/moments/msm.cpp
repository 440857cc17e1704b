// Moment shadow map: four moments of depth, filtered ahead of the look-up; the sharp bound that they put on the lit
// fraction, for depths anywhere (Hamburger's moment problem) or within the view (Hausdorff's). [Peters and Klein 2015;
// Macedo 2018, 2.4]
//
// 1. moments: b = (t, t², t³, t⁴) of linear depth t; in 16 bits Θ b + o, whose rounding harms them least.
// 2. pre-filter: linear, so it may work on Θ b + o.
// 3. look-up: b ← (1 − α) b + α b', b' the moments of a fixed distribution, then V = the bound of algorithm 2 or 3 of
// the paper.
//
// The bound is below 1 as soon as some of a receiver's own plane lies in front of it in the filter: plane-bias takes
// care of that.

#include "techniques/all.h"
#include "techniques/moments/moment_map.h"
#include "techniques/moments/quantization.h"

namespace gnomon {
namespace {

enum class Problem { Hamburger, Hausdorff };
enum class Storage { Float32, Unorm16, Plain16 };
enum class Towards { EndsAndMiddle, Ends };

struct MsmParams : MomentMapParams {
    Problem problem = Problem::Hamburger;
    Storage format = Storage::Float32;
    float moment_bias = 3e-5f;
    Towards bias_towards = Towards::EndsAndMiddle;
    MsmParams() { plane_bias = 1.0f; }
};
constexpr auto msm_fields = join(
    moment_map_fields,
    fields(field("problem", &MsmParams::problem, "hamburger|hausdorff",
                 "depths may lie anywhere, or in 0 to 1 only, which bounds tighter", "Peters and Klein 2015, 3.2, 3.4"),
           field("format", &MsmParams::format, "float32|unorm16|plain16",
                 "what the map stores a moment in; unorm16 with the optimised quantisation transform, plain16 without",
                 "Peters and Klein 2015, 3.3"),
           field("moment-bias", &MsmParams::moment_bias, 0, 1, "",
                 "alpha, the share of a blend towards moments that no rounding can spoil; 3e-7 leaks less, but leaves "
                 "dark specks of rounding even with float32",
                 "Peters and Klein 2015, 3.3; author's programs: 3e-5"),
           field("bias-towards", &MsmParams::bias_towards, "ends-and-middle|ends",
                 "the distribution of that blend: depths 0, 1/2 and 1, or 0 and 1 alone, which is no help where layers "
                 "lie at both ends of the view",
                 "Peters et al. 2017; Peters and Klein 2015, 3.3"),
           preset("published",
                  "size=2048,near=1,border=shadow,kernel=7,moment-bias=3e-5,bias-towards=ends,plane-bias=0",
                  "as in the author's program", "github.com/MarcioCerqueira/GlobalIllumination")));

class Msm : public Technique {
public:
    explicit Msm(MsmParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const MomentMap map = moment_map(frame, light, params_);
        const bool quantized = params_.format == Storage::Unorm16;
        const Format format = params_.format == Storage::Float32 ? Format::RGBA32F : Format::RGBA16;
        Target moments = draw_moments(frame, map, format, [&](float t, float, float) {
            return quantized ? quantize_moments(four_moments(t)) : four_moments(t);
        });
        const vec4 towards =
            params_.bias_towards == Towards::Ends ? moments_of_ends<float> : moments_of_ends_and_middle<float>;
        Visibility visibility;
        show_channels(visibility, "moments", moments);
        const FilteredMap filtered = filter_map(frame, std::move(moments), params_);
        visibility.values =
            for_each_moment_point(frame, light, map, [&](const MomentPoint& at, PassCounters& counters) {
                const vec4 mean = filtered_mean(filtered, at, counters);
                const vec4 b = biased(quantized ? dequantize_moments(mean) : mean, params_.moment_bias, towards);
                return params_.problem == Problem::Hamburger ? hamburger(b, at.t) : hausdorff(b, at.t);
            });
        show_filtered(visibility, filtered, params_);
        return visibility;
    }

private:
    MsmParams params_;
};

} // namespace

Entry msm_entry() {
    return make_entry<Msm, MsmParams>(
        {.id = "msm",
         .title = "moment shadow map",
         .family = "moments",
         .kind = TechniqueKind::Filtered,
         .paper = "Peters, Klein 2015; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 2.4",
         .equations =
             "b = E[(z, z^2, z^3, z^4)]; V = the bound of algorithm 2 or 3 of Peters and Klein for the depth t",
         .strengths = "the sharpest bound that four moments allow: exact for two layers, little bleeds with three",
         .artifacts = "some light bleeds through three and more layers; a plane shadows itself without plane-bias"},
        msm_fields);
}

} // namespace gnomon
