// Stencil shadow volumes, depth-pass: counted from the eye. Wrong where the near plane cuts a volume, which is why
// depth-fail exists. [Heidmann 1991; Forest 2008, 2.2.1; Hasselgren 2003, 2.3.2]
//
// 1. scene depth.
// 2. volume sides, no caps, depth LESS without writing; two-sided stencil on depth pass: front +1, back −1, wrapping.
// The count
//    starts with the number of volumes around the eye.
// 3. V = (stencil = 0).

#include "techniques/all.h"
#include "techniques/volume/shadow_volume.h"

namespace gnomon {
namespace {

struct ZpassParams {
    StencilBits stencil = StencilBits::S32;
    bool eye_count = true;
};
constexpr auto zpass_fields =
    fields(field("stencil", &ZpassParams::stencil, "s32|s8",
                 "bits of the counters: 32, which never wrap, or the API's 8", "Navratil 2015, 2.2.2"),
           field("eye-count", &ZpassParams::eye_count,
                 "start from the number of volumes that contain the eye; false: from zero", "Hasselgren 2003, 2.3.2"));

class Zpass : public Technique {
public:
    explicit Zpass(ZpassParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const ShadowVolume volume = build_shadow_volume(frame, light);
        const std::uint32_t around_eye = params_.eye_count ? count_volumes_around_eye(frame, volume) : 0;
        return {stencil_shadows(frame, light, volume, VolumeTest::DepthPass, params_.stencil, around_eye), {}, {}};
    }

private:
    ZpassParams params_;
};

} // namespace

Entry sv_zpass_entry() {
    return make_entry<Zpass, ZpassParams>(
        {.id = "sv-zpass",
         .title = "stencil shadow volumes, depth pass",
         .family = "shadow volume",
         .kind = TechniqueKind::Hard,
         .paper = "Heidmann 1991; Forest 2008",
         .lights = all_lights,
         .section = "Forest 2008, 2.2.1; Hasselgren 2003, 2.3.2; Navratil 2015, 2.2.2; Macedo 2018, 2.2",
         .equations = "V = 1 where the volumes entered on the way from the eye, less those left, are 0",
         .strengths =
             "exact to the pixel, at any distance and for any geometry; no caps, so it fills less than depth fail",
         .artifacts = "regions turn over where the near plane cuts a volume; fill grows with the area of all volumes "
                      "on the screen; with stencil=s8 a multiple of 256 volumes counts as none"},
        zpass_fields);
}

} // namespace gnomon
