// Percentage-closer filtering over V* instead of V**: the mean of revectorized hard tests. [the author's programs;
// Macedo 2018, 4.1.2]
//
// 1. shadow map.
// 2. filter, per receiver: kernel × kernel samples over ±penumbra texels; V = Σ V* (3.9) / kernel².

#include "techniques/all.h"
#include "techniques/revectorize/rpcf.h"

namespace gnomon {
namespace {

class RpcfHard : public Technique {
public:
    explicit RpcfHard(RpcfParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        return filter_receivers(frame, light, params_,
                                [&](const MapSource& source, const SilhouetteRules& rules, const MapSample& centre,
                                    const std::vector<float>& offsets) {
                                    return sum_samples(centre, offsets, [&](const MapSample& sample) {
                                        return nonconservative(source, rules, sample, params_.flip_isolated);
                                    });
                                });
    }

private:
    RpcfParams params_;
};

} // namespace

Entry rpcf_hard_entry() {
    return make_entry<RpcfHard, RpcfParams>({.id = "rpcf-hard",
                                             .title = "percentage-closer filtering of revectorized hard shadows",
                                             .family = "revectorization",
                                             .kind = TechniqueKind::Filtered,
                                             .paper = "Macedo 2018",
                                             .lights = all_lights,
                                             .section = "Macedo 2018, 4.1.2, first version in the author's programs",
                                             .equations = "(3.1) to (3.5), (3.9)",
                                             .strengths = "as rpcf, and its edge stays within the steps",
                                             .artifacts = "as rpcf, with the levels of kernel² alone"},
                                            rpcf_fields);
}

} // namespace gnomon
