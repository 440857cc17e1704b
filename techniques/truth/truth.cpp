// The truth for area lights: the fraction of N points of the light that each receiver sees, and what light they send
// it. [Macedo 2018, 2.1 and 2.6; Forest 2008, 2.3]

#include "raytrace/truth.h"
#include "core/error.h"
#include "raytrace/exact.h"
#include "techniques/all.h"

namespace gnomon {
namespace {

enum class RadianceMode { Off, Lambert, Ggx };
enum class Method { Samples, Exact };
enum class Shortcuts { On, Off };

struct TruthParams {
    int samples = 1024;
    Pattern pattern = Pattern::Sobol;
    int seed = 0;
    float target_error = 0;
    RadianceMode radiance = RadianceMode::Off;
    Method method = Method::Samples;
    Shortcuts shortcuts = Shortcuts::On;
};
constexpr auto truth_fields = fields(
    field("samples", &TruthParams::samples, 1, 65536, "samples", "points of the light per receiver",
          "Macedo 2018, figure 4.12: 1024"),
    field("pattern", &TruthParams::pattern, pattern_choices, "where on the light the points lie",
          "Macedo 2018, 2.6; sobol: Owen 1995"),
    field("seed", &TruthParams::seed, 0, 1 << 30, "", "seed of the per-pixel scrambling", "ours"),
    field("target-error", &TruthParams::target_error, 0, 1, "",
          "stop a pixel after 64, 256, 1024, ... samples once its error bar is not above this; 0: never", "ours"),
    field("radiance", &TruthParams::radiance, "off|lambert|ggx",
          "integrate each sample's light with this BRDF, instead of unshadowed light times visibility",
          "Macedo 2018, (2.5); Forest 2008, (2.8)"),
    field("method", &TruthParams::method, "samples|exact",
          "exact: the light's visible area by geometry, without samples; for area lights and small scenes", "ours"),
    field("shortcuts", &TruthParams::shortcuts, "on|off",
          "off: trace every ray; on: the same bits, and proofs in place of rays where they are cheaper", "ours"));

vec3 to_viewer(const Camera& camera, vec3 position) {
    return camera.orthographic ? -camera.forward : glm::normalize(camera.position - position);
}

class Truth : public Technique {
public:
    explicit Truth(TruthParams params) : params_(params) {
        if (params.method != Method::Exact) return;
        if (params.radiance != RadianceMode::Off)
            throw UsageError("truth: method exact gives visibility, not radiance: leave radiance off");
        if (params.target_error > 0)
            throw UsageError("truth: method exact has no samples to stop at: leave target-error out");
    }

    Visibility shade(Frame& frame, const Light& light) override {
        if (params_.method == Method::Exact && is_area(light)) return exact(frame, light);
        const EmbreeScene& rays = frame.rays();
        Pass pass = frame.pass("shadow rays");
        TruthRun run = frame.truth_run;
        run.progress = frame.progress;
        if (params_.shortcuts == Shortcuts::On && is_area(light)) run.clusters = &frame.clusters();
        TruthAnswer answer = area_truth(rays, frame.receivers(), light, settings(frame), run);
        pass.counters().rays += answer.rays;
        Visibility visibility{std::move(answer.visibility), std::move(answer.radiance), {}};
        visibility.layers.push_back({"error", std::move(answer.error)});
        if (params_.target_error > 0) visibility.layers.push_back({"samples", std::move(answer.samples)});
        return visibility;
    }

private:
    static Visibility exact(Frame& frame, const Light& light) {
        const TriangleClusters& clusters = frame.clusters();
        const Pass pass = frame.pass("exact visibility");
        return {exact_visibility(frame.scene(), clusters, frame.receivers(), light, frame.progress), {}, {}};
    }

    TruthSettings settings(const Frame& frame) const {
        TruthSettings settings;
        settings.samples = params_.samples;
        settings.pattern = params_.pattern;
        settings.seed = static_cast<std::uint32_t>(params_.seed);
        settings.target_error = params_.target_error;
        if (params_.radiance == RadianceMode::Off) return settings;
        settings.brdf = params_.radiance == RadianceMode::Ggx ? Brdf::Ggx : Brdf::Lambert;
        settings.surface = [&frame](int x, int y) {
            const GBuffer& gbuffer = frame.gbuffer();
            const Receiver& receiver = gbuffer.receivers(x, y);
            const Material& material = frame.scene().material_of(receiver.triangle);
            return Surface{
                receiver.position,    gbuffer.shading_normal(x, y), to_viewer(frame.camera(), receiver.position),
                gbuffer.albedo(x, y), material.roughness,           material.metallic};
        };
        return settings;
    }

    TruthParams params_;
};

} // namespace

Entry truth_entry() {
    return make_entry<Truth, TruthParams>(
        {.id = "truth",
         .title = "area-light visibility by ray tracing",
         .family = "ray tracing",
         .kind = TechniqueKind::Accurate,
         .paper = "Cook, Porter, Carpenter 1984; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 2.1 and 2.6; Forest 2008, 2.3",
         .equations = "Macedo 2018, (2.7), (2.8): V = the mean of V_ray (2.2) over the light; Forest 2008, (2.10)",
         .strengths = "converges to the exact answer for every light and scene, with an error bar per pixel; what "
                      "every soft-shadow technique is measured against",
         .artifacts = "noise, which falls with the number of samples and is told by the layer `error`; time"},
        truth_fields);
}

} // namespace gnomon
