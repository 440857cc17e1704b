// Stencil shadow volumes, depth-fail: counted from infinity towards the eye, right wherever the eye is.
// [Carmack 2000; Everitt and Kilgard 2002; Forest 2008, 2.2.1; Hasselgren 2003, 2.3.2]
//
// 1. scene depth: infinite far plane.
// 2. volumes with both caps, depth LESS without writing, depth clamp; two-sided stencil on depth fail: back +1, front
// −1, wrapping.
//    A lit surface coincides with its own near cap, bit for bit: equal depth fails and cancels the far cap.
// 3. V = (stencil = 0).

#include "techniques/all.h"
#include "techniques/volume/shadow_volume.h"

namespace gnomon {
namespace {

struct ZfailParams {
    StencilBits stencil = StencilBits::S32;
};
constexpr auto zfail_fields =
    fields(field("stencil", &ZfailParams::stencil, "s32|s8",
                 "bits of the counters: 32, which never wrap, or the API's 8", "Navratil 2015, 2.2.2"));

class Zfail : public Technique {
public:
    explicit Zfail(ZfailParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const ShadowVolume volume = build_shadow_volume(frame, light);
        return {stencil_shadows(frame, light, volume, VolumeTest::DepthFail, params_.stencil, 0), {}, {}};
    }

private:
    ZfailParams params_;
};

} // namespace

Entry sv_zfail_entry() {
    return make_entry<Zfail, ZfailParams>(
        {.id = "sv-zfail",
         .title = "stencil shadow volumes, depth fail",
         .family = "shadow volume",
         .kind = TechniqueKind::Hard,
         .paper = "Everitt, Kilgard 2002; Forest 2008",
         .lights = all_lights,
         .section = "Forest 2008, 2.2.1; Hasselgren 2003, 2.3.2; Navratil 2015, 2.2.2; Macedo 2018, 2.2",
         .equations = "V = 1 where the volumes left on the way from infinity to the surface, less those entered, are 0",
         .strengths = "exact to the pixel, at any distance, for any geometry and wherever the eye is",
         .artifacts = "fill grows with the area of all volumes on the screen, caps included; with stencil=s8 a "
                      "multiple of 256 volumes counts as none"},
        zfail_fields);
}

} // namespace gnomon
