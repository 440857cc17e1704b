// Percentage-closer filtering: the mean of shadow tests around the receiver. [Reeves et al. 1987; Macedo 2018, 2.4]
//
// 1. shadow map.
// 2. look-up: V = mean of the tests at taps spread over ±radius texels: at the centres of kernel × kernel cells, by
//    default one texel apart; at the places of the thesis' program; at Poisson-disc points, shifted around the square
//    differently in every pixel; or kernel × kernel bilinear comparisons as texture units have them.

#include <vector>

#include "core/random.h"
#include "raytrace/poisson.h"
#include "techniques/all.h"
#include "techniques/map/shadow_map.h"

namespace gnomon {
namespace {

enum class Taps { Cells, Published, Poisson, Bilinear };

struct PcfParams : FilteredMapParams {
    int kernel = 15;
    float radius = 0.0f;
    Taps taps = Taps::Cells;
    int samples = 64;
    bool shift = true;
};
constexpr auto pcf_fields = join(
    filtered_map_fields,
    fields(
        field("kernel", &PcfParams::kernel, 1, 63, "taps", "side of the filter kernel", "Macedo 2018, 4.3.1"),
        field("radius", &PcfParams::radius, 0, 512, "texels",
              "half the side of the square that the taps cover; 0: kernel/2, one texel apart", "author's programs: 1"),
        field("taps", &PcfParams::taps, "cells|published|poisson|bilinear",
              "at the centres of kernel x kernel cells; from -radius up to radius in steps of 2 radius/kernel, counted "
              "in "
              "floats, so that a side has kernel taps or one more; `samples` Poisson-disc points; or kernel x kernel "
              "hardware comparisons, each the bilinear mean of four tests against one depth",
              "Reeves et al. 1987; published: author's programs"),
        field("samples", &PcfParams::samples, 1, 4096, "taps", "of taps=poisson", "Reeves et al. 1987"),
        field("shift", &PcfParams::shift, "taps=poisson: another shift of the points in every pixel, noise for banding",
              "Reeves et al. 1987"),
        preset("published", "size=2048,near=1,border=shadow,receiver-plane=false,kernel=7,radius=1,taps=published",
               "as in the author's program", "github.com/MarcioCerqueira/GlobalIllumination")));

// Offsets of kernel × kernel taps about the receiver in texels, v outer and u inner.
std::vector<vec2> square_of(const std::vector<float>& side) {
    std::vector<vec2> offsets;
    for (const float v : side)
        for (const float u : side) offsets.emplace_back(u, v);
    return offsets;
}

class Pcf : public Technique {
public:
    explicit Pcf(PcfParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const ShadowMap map = draw_shadow_map(frame, light, params_);
        const float reach = params_.radius > 0 ? params_.radius : 0.5f * static_cast<float>(params_.kernel);
        const std::vector<vec2> offsets = tap_offsets(reach);
        Visibility visibility;
        visibility.values = for_each_receiver(frame, "look-up", [&](const Receiver& receiver, Pixel& pixel) {
            const MapPoint point = map_point(map, light, receiver, params_.receiver_plane);
            if (point.lit || point.dark) return point.lit ? 1.0f : 0.0f;
            switch (params_.taps) {
            case Taps::Cells:
                return percentage_closer(map, point, params_.kernel, vec2(reach), pixel.counters);
            case Taps::Published:
                return mean_of_tests(map, point, offsets, pixel.counters);
            case Taps::Bilinear:
                return mean_of_bilinear_tests(map, point, offsets, pixel.counters);
            default:
                return mean_of_tests(map, point, shifted(offsets, reach, pixel), pixel.counters);
            }
        });
        visibility.debug.push_back({"shadow-map", show_depth(map.depth, 0)});
        return visibility;
    }

private:
    std::vector<vec2> tap_offsets(float reach) const {
        std::vector<float> side;
        if (params_.taps == Taps::Poisson) {
            std::vector<vec2> offsets;
            for (const TorusPoint& p : best_candidates(static_cast<size_t>(params_.samples)))
                offsets.push_back(reach * (2.0f * vec2(to_unit(p.x), to_unit(p.y)) - 1.0f));
            return offsets;
        }
        const auto n = static_cast<float>(params_.kernel);
        if (params_.taps == Taps::Published)
            for (float o = -reach; o < reach; o += 2.0f * reach / n) side.push_back(o);
        else
            for (int i = 0; i < params_.kernel; ++i) side.push_back(reach * (static_cast<float>(2 * i + 1) / n - 1.0f));
        return square_of(side);
    }

    // The points moved around the square, which they cover as evenly as before.
    std::vector<vec2> shifted(std::vector<vec2> offsets, float reach, const Pixel& pixel) const {
        if (!params_.shift) return offsets;
        const auto x = static_cast<std::uint32_t>(pixel.x), y = static_cast<std::uint32_t>(pixel.y);
        const vec2 shift = 2.0f * reach * vec2(to_unit(hash(x, y, 0)), to_unit(hash(x, y, 1)));
        for (vec2& offset : offsets)
            for (int c = 0; c < 2; ++c) {
                offset[c] += shift[c];
                if (offset[c] >= reach) offset[c] -= 2.0f * reach;
            }
        return offsets;
    }

    PcfParams params_;
};

} // namespace

Entry pcf_entry() {
    return make_entry<Pcf, PcfParams>(
        {.id = "pcf",
         .title = "percentage-closer filtering",
         .family = "shadow map",
         .kind = TechniqueKind::Filtered,
         .paper = "Reeves, Salesin, Cook 1987; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 2.4",
         .equations = "V = mean of the tests (3.2) at the taps",
         .strengths = "no light leaks: only results of tests are averaged; the shadow map alone",
         .artifacts = "fetches grow with the square of the kernel; bands of 1/kernel along edges that follow the map's "
                      "axes; where the kernel is small, the map's steps show"},
        pcf_fields);
}

} // namespace gnomon
