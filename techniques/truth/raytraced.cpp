// Hard shadows by one ray from each receiver to the light's centre. [Macedo 2018, 2.1 and 2.2]

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
    return make_entry<Raytraced, RaytracedParams>(
        {.id = "raytraced",
         .title = "hard shadows by ray tracing",
         .family = "ray tracing",
         .kind = TechniqueKind::Hard,
         .paper = "Whitted 1980; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 2.1 and 2.2",
         .equations = "(2.2), (2.9): V = 1 where the receiver and the light's centre see each other",
         .strengths = "exact: what every hard-shadow technique is measured against",
         .artifacts = "none that are known; one ray a pixel, so its edges are as jagged as the image's pixels"},
        raytraced_fields);
}

} // namespace gnomon
