// Hard shadows by one ray from each receiver to the light's centre. [Macedo 2018, 2.28]

#include "raytrace/truth.h"
#include "techniques/all.h"

namespace gnomon {
namespace {

struct RaytracedParams {};
constexpr auto raytraced_fields = fields();

class Raytraced : public Technique {
public:
    explicit Raytraced(RaytracedParams) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const EmbreeScene& rays = frame.rays();
        Pass pass = frame.pass("shadow rays");
        TruthAnswer answer = hard_truth(rays, frame.receivers(), light);
        pass.counters().rays += answer.rays;
        return {std::move(answer.visibility), {}, {}};
    }
};

} // namespace

Entry raytraced_entry() {
    return make_entry<Raytraced, RaytracedParams>({.id = "raytraced",
                                                   .title = "hard shadows by ray tracing",
                                                   .family = "ray tracing",
                                                   .kind = TechniqueKind::Hard,
                                                   .paper = "Whitted 1980; Macedo 2018, 2.28",
                                                   .lights = all_lights},
                                                  raytraced_fields);
}

} // namespace gnomon
