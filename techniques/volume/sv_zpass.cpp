// Stencil shadow volumes, depth-pass: counted from the eye. Wrong where the near plane cuts a volume, which is why
// depth-fail exists. [Heidmann 1991; Forest 2008, 2.1; Hasselgren 2003, 2.3]
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
                 "bits of the counters: 32, which never wrap, or the API's 8", "Navratil 2015, 2.16"),
           field("eye-count", &ZpassParams::eye_count,
                 "start from the number of volumes that contain the eye; false: from zero", "Hasselgren 2003, 2.3"));

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
    return make_entry<Zpass, ZpassParams>({.id = "sv-zpass",
                                           .title = "stencil shadow volumes, depth pass",
                                           .family = "shadow volume",
                                           .kind = TechniqueKind::Hard,
                                           .paper = "Heidmann 1991; Forest 2008, 2.1",
                                           .lights = all_lights},
                                          zpass_fields);
}

} // namespace gnomon
