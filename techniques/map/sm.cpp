// Shadow mapping: one nearest look-up a receiver. [Williams 1978; Macedo 2018, 2.2; Navrátil 2015, 2.3]
//
// 1. shadow map: depth of all casters from the light, with constant and slope-scaled offset.
// 2. look-up: V = depth of the receiver ≤ depth of the texel it falls on.

#include <cmath>

#include "techniques/all.h"
#include "techniques/map/shadow_map.h"

namespace gnomon {
namespace {

class Sm : public Technique {
public:
    explicit Sm(ShadowMapParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const ShadowMap map = draw_shadow_map(frame, light, params_);
        Visibility visibility;
        visibility.values = for_each_receiver(frame, "look-up", [&](const Receiver& receiver, Pixel& pixel) {
            const MapPoint point = map_point(map, light, receiver);
            if (point.lit || point.dark) return point.lit ? 1.0f : 0.0f;
            return shadow_test(map, point.layer, static_cast<int>(std::floor(point.texel.x)),
                               static_cast<int>(std::floor(point.texel.y)), point.depth, pixel.counters);
        });
        visibility.debug.push_back({"shadow-map", show_depth(map.depth, 0)});
        return visibility;
    }

private:
    ShadowMapParams params_;
};

} // namespace

Entry sm_entry() {
    return make_entry<Sm, ShadowMapParams>({.id = "sm",
                                            .title = "shadow map",
                                            .family = "shadow map",
                                            .kind = TechniqueKind::Hard,
                                            .paper = "Williams 1978; Macedo 2018",
                                            .lights = all_lights,
                                            .section = "Macedo 2018, 2.2 and 3.1.2; Navratil 2015, 2.3",
                                            .equations = "(3.2): V = 0 where z > S(i, j), else 1",
                                            .strengths = "one look-up a receiver; any geometry; no bias of the edge",
                                            .artifacts = "texels show as stairs at any resolution; acne without bias, "
                                                         "detached shadows with too much; details thinner than a texel "
                                                         "are lost"},
                                           shadow_map_fields);
}

} // namespace gnomon
