// Revectorization-based percentage-closer filtering: the mean of V** over a kernel. [Macedo 2018, 4.1.2]
//
// 1. shadow map.
// 2. filter, per receiver: kernel × kernel samples over ±penumbra texels, all with the receiver's depth;
//    V = Σ V** (4.2) / kernel². A sample off the silhouette is V_SM, as in pcf.

#include "techniques/revectorize/rpcf.h"
#include "techniques/all.h"

namespace gnomon {

std::vector<float> kernel_offsets(const RpcfParams& params) {
    std::vector<float> offsets;
    if (params.taps == KernelTaps::Cells) {
        for (int i = 0; i < params.kernel; ++i) offsets.push_back(kernel_cell(i, params.kernel) * params.penumbra);
        return offsets;
    }
    const float step = 2.0f * params.penumbra / static_cast<float>(params.kernel);
    float offset = -params.penumbra;
    for (int i = 0; i <= params.kernel && offset <= params.penumbra; ++i, offset += step) offsets.push_back(offset);
    return offsets;
}

namespace {

class Rpcf : public Technique {
public:
    explicit Rpcf(RpcfParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        return filter_receivers(frame, light, params_,
                                [&](const MapSource& source, const SilhouetteRules& rules, const MapSample& centre,
                                    const std::vector<float>& offsets) {
                                    return sum_samples(centre, offsets, [&](const MapSample& sample) {
                                        return filtered(source, rules, sample, params_.flip_isolated);
                                    });
                                });
    }

private:
    RpcfParams params_;
};

} // namespace

Entry rpcf_entry() {
    return make_entry<Rpcf, RpcfParams>(
        {.id = "rpcf",
         .title = "revectorization-based percentage-closer filtering",
         .family = "revectorization",
         .kind = TechniqueKind::Filtered,
         .paper = "Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 4.1.2",
         .equations = "(3.1) to (3.4), (4.1) as its text has it, (4.2)",
         .strengths = "no staircase at penumbrae of a texel or less, where pcf has one; more levels than pcf of the "
                      "same kernel; leaks nothing; needs nothing but the shadow map",
         .artifacts =
             "cost grows with the square of the kernel; along the map's axes no better than pcf; penumbrae are "
             "as wide everywhere"},
        rpcf_fields);
}

} // namespace gnomon
