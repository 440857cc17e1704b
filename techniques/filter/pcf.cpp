// Percentage-closer filtering: the mean of n×n shadow tests around the receiver. [Reeves et al. 1987; Macedo
// 2018, 2.18]
//
// 1. shadow map.
// 2. look-up: V = mean of kernel × kernel nearest tests spread over ±radius texels; by default one texel apart.

#include "techniques/all.h"
#include "techniques/map/shadow_map.h"

namespace gnomon {
namespace {

struct PcfParams : FilteredMapParams {
    int kernel = 15;
    float radius = 0.0f;
};
constexpr auto pcf_fields =
    join(filtered_map_fields,
         fields(field("kernel", &PcfParams::kernel, 1, 63, "taps", "side of the filter kernel", "Macedo 2018, 4.3.1"),
                field("radius", &PcfParams::radius, 0, 512, "texels",
                      "half the side of the square that the taps cover; 0: kernel/2, one texel apart",
                      "Macedo 2018, 2.18")));

class Pcf : public Technique {
public:
    explicit Pcf(PcfParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const ShadowMap map = draw_shadow_map(frame, light, params_);
        const vec2 reach(params_.radius > 0 ? params_.radius : 0.5f * static_cast<float>(params_.kernel));
        return {for_each_receiver(frame, "look-up",
                                  [&](const Receiver& receiver, Pixel& pixel) {
                                      const MapPoint point = map_point(map, light, receiver, params_.receiver_plane);
                                      if (point.lit || point.dark) return point.lit ? 1.0f : 0.0f;
                                      return percentage_closer(map, point, params_.kernel, reach, pixel.counters);
                                  }),
                {},
                {}};
    }

private:
    PcfParams params_;
};

} // namespace

Entry pcf_entry() {
    return make_entry<Pcf, PcfParams>({.id = "pcf",
                                       .title = "percentage-closer filtering",
                                       .family = "shadow map",
                                       .kind = TechniqueKind::Filtered,
                                       .paper = "Reeves, Salesin, Cook 1987; Macedo 2018, 2.18",
                                       .lights = all_lights},
                                      pcf_fields);
}

} // namespace gnomon
