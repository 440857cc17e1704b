// The truth for area lights: the fraction of N points of the light that each receiver sees. [Macedo 2018, 2.28; Forest
// 2008, 2.2]

#include "raytrace/truth.h"
#include "techniques/all.h"

namespace gnomon {
namespace {

struct TruthParams {
    int samples = 1024;
    Pattern pattern = Pattern::Sobol;
    int seed = 0;
};
constexpr auto truth_fields =
    fields(field("samples", &TruthParams::samples, 1, 65536, "samples", "points of the light per receiver"),
           field("pattern", &TruthParams::pattern, pattern_choices, "where on the light the points lie"),
           field("seed", &TruthParams::seed, 0, 1 << 30, "", "seed of the per-pixel scrambling"));

class Truth : public Technique {
public:
    explicit Truth(TruthParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const EmbreeScene& rays = frame.rays();
        const Pass pass = frame.pass("shadow rays");
        return {area_visibility(rays, frame.receivers(), light, params_.pattern, params_.samples,
                                static_cast<std::uint32_t>(params_.seed), frame.progress),
                {},
                {}};
    }

private:
    TruthParams params_;
};

} // namespace

Entry truth_entry() {
    return make_entry<Truth, TruthParams>({.id = "truth",
                                           .title = "area-light visibility by ray tracing",
                                           .family = "ray tracing",
                                           .kind = TechniqueKind::Accurate,
                                           .paper = "Cook, Porter, Carpenter 1984; Macedo 2018, 2.28",
                                           .lights = all_lights},
                                          truth_fields);
}

} // namespace gnomon
