#pragma once
// What the kernels of revectorization-based percentage-closer filtering share: parameters, places of their samples, and
// the pass over all receivers. [Macedo 2018, 4.1.2]

#include <vector>

#include "techniques/revectorize/map_silhouette.h"

namespace gnomon {

enum class KernelTaps { Cells, Corners };

struct RpcfParams : RevectorizeParams {
    RpcfParams() { receiver_plane = true; } // as pcf, which it is away from silhouettes
    int kernel = 7;
    float penumbra = 1.0f;
    KernelTaps taps = KernelTaps::Cells;
    bool flip_isolated = false;
};
constexpr auto rpcf_fields = join(
    revectorize_fields,
    fields(field("kernel", &RpcfParams::kernel, 1, 63, "samples", "side of the filter kernel", "Macedo 2018, 4.3"),
           field("penumbra", &RpcfParams::penumbra, 0, 512, "texels",
                 "half the side of the square that the samples cover", "author's programs"),
           field("taps", &RpcfParams::taps, "cells|corners",
                 "kernel x kernel cell centres, or from edge to edge in steps added up in float32, one more a side",
                 "author's programs"),
           field("flip-isolated", &RpcfParams::flip_isolated,
                 "a texel that differs from all four neighbours takes their state", "author's programs"),
           preset("published",
                  "size=2048,near=1,border=shadow,eps-unit=window,stepping=float,receiver-plane=off,taps=corners",
                  "as the author's program has it", "github.com/MarcioCerqueira/GlobalIllumination")));

// Places of the samples along one side of the kernel, texels from the receiver's place.
std::vector<float> kernel_offsets(const RpcfParams& params);

// What a kernel adds up.
struct KernelSum {
    float visibility = 0.0f;
    unsigned discontinuities = 0; // of any of its samples
    int traversals = 0;           // samples that walked

    void add(const Revectorized& sample, bool walked) {
        visibility += sample.visibility;
        discontinuities |= sample.discontinuities;
        traversals += walked && sample.discontinuities ? 1 : 0;
    }
};

// kernel(const MapSource&, const SilhouetteRules&, const MapSample& centre, const std::vector<float>& offsets) ->
// KernelSum. Images: discontinuities of all samples together, and how many samples walked.
template <class Kernel>
Visibility filter_receivers(Frame& frame, const Light& light, const RpcfParams& params, const Kernel& kernel) {
    const ShadowMap map = draw_shadow_map(frame, light, params);
    const SilhouetteRules rules = silhouette_rules(params);
    const std::vector<float> offsets = kernel_offsets(params);
    const auto samples = static_cast<float>(offsets.size() * offsets.size());
    Image<float> discontinuities(frame.width(), frame.height()), traversals(frame.width(), frame.height());
    Visibility visibility;
    visibility.values = for_each_receiver(frame, "filter", [&](const Receiver& receiver, Pixel& pixel) {
        const MapPoint point = map_point(map, light, receiver, params.receiver_plane);
        if (point.lit || point.dark) return point.lit ? 1.0f : 0.0f;
        const MapSample centre = {point.texel, point.depth, window_eps(params.slope_eps, params, map, point)};
        const KernelSum sum = kernel(MapSource{map, point, pixel.counters}, rules, centre, offsets);
        discontinuities(pixel.x, pixel.y) = static_cast<float>(sum.discontinuities);
        traversals(pixel.x, pixel.y) = static_cast<float>(sum.traversals);
        return sum.visibility / samples;
    });
    visibility.debug.push_back({"discontinuities", std::move(discontinuities)});
    visibility.debug.push_back({"traversals", std::move(traversals)});
    return visibility;
}

// The kernel that answers each sample on its own: look_up(const MapSample&) -> Revectorized.
template <class LookUp>
KernelSum sum_samples(const MapSample& centre, const std::vector<float>& offsets, const LookUp& look_up) {
    KernelSum sum;
    for (const float v : offsets)
        for (const float u : offsets)
            sum.add(look_up({centre.texels + vec2(u, v), centre.depth, centre.slope_eps}), true);
    return sum;
}

} // namespace gnomon
