// Variance shadow map: depth and squared depth, filtered ahead of the look-up; Chebyshev's inequality bounds the lit
// fraction. [Donnelly and Lauritzen 2006; Macedo 2018, 2.19]
//
// 1. moments: (t, t² + ¼((∂t/∂x)² + (∂t/∂y)²)) of linear depth t, cleared to (1, 1).
// 2. blur: separable binomial filter, rows then columns.
// 3. look-up, bilinear: V = t ≤ μ ? 1 : σ²/(σ² + (t − μ)²), σ² at least min-variance; then light bleeding cut.

#include <algorithm>

#include "raster/draw.h"
#include "raster/passes/filter.h"
#include "techniques/all.h"
#include "techniques/map/shadow_map.h"

namespace gnomon {
namespace {

enum class Blur { Binomial, Box };

struct VsmParams : MapParams {
    int kernel = 15;
    Blur blur = Blur::Binomial;
    float min_variance = 1e-6f;
    float bleeding = 0.0f;
};
constexpr auto vsm_fields = join(
    map_fields, fields(field("kernel", &VsmParams::kernel, 1, 63, "texels", "side of the blur", "Macedo 2018, 4.3.1"),
                       field("blur", &VsmParams::blur, "binomial|box",
                             "shape of the blur: sigma sqrt((kernel-1)/4), or flat", "Macedo 2018, 2.19"),
                       field("min-variance", &VsmParams::min_variance, 0, 1, "linear depth squared",
                             "least variance of the look-up"),
                       field("bleeding", &VsmParams::bleeding, 0, 0.999, "",
                             "fractions lit up to this are dark, the rest is stretched", "Lauritzen 2007, 8.4.3")));

struct Depth {
    float t;
};

class Vsm : public Technique {
public:
    explicit Vsm(VsmParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const int gutter = params_.kernel / 2 + 1; // the blur, and the bilinear look-up
        const LightMap map = {
            params_, light_views(frame, light, {params_.projection, params_.near_plane, params_.size, gutter})};
        Target moments = frame.target(Format::RG32F, params_.size, params_.size, static_cast<int>(map.views.size()));
        draw_moments(frame, map, moments);
        blur(frame, moments);

        const Sampler bilinear = {.filter = Filter::Linear, .wrap = Wrap::Clamp};
        return {for_each_receiver(frame, "look-up",
                                  [&](const Receiver& receiver, Pixel& pixel) {
                                      const MapPoint point = map_point(map, light, receiver);
                                      if (point.lit || point.dark) return point.lit ? 1.0f : 0.0f;
                                      const vec2 uv = point.texel / static_cast<float>(params_.size);
                                      if (glm::any(glm::lessThan(uv, vec2(0))) ||
                                          glm::any(glm::greaterThan(uv, vec2(1))))
                                          return params_.border == Border::Lit ? 1.0f : 0.0f;
                                      const LightView& view = map.views[static_cast<size_t>(point.layer)];
                                      const vec4 m = sample(moments, bilinear, uv, pixel.counters, point.layer);
                                      return chebyshev(m.x, m.y, view.linear_depth(receiver.position));
                                  }),
                {},
                {}};
    }

private:
    void draw_moments(Frame& frame, const LightMap& map, Target& moments) const {
        Pass pass = frame.pass("moments");
        Target depth = frame.target(Format::D32F, params_.size, params_.size, moments.layers());
        PipelineState state;
        state.depth = {.test = Compare::Less, .write = true};
        const std::vector<vec3>& positions = frame.scene().positions;
        const Geometry geometry = {static_cast<std::uint32_t>(positions.size()), frame.casters()};
        for (int layer = 0; layer < moments.layers(); ++layer) {
            const LightView& view = map.views[static_cast<size_t>(layer)];
            const auto vertex = [&](std::uint32_t i) {
                return Vertex<Depth>{transform(view.to_clip, positions[i]), {view.linear_depth(positions[i])}};
            };
            const auto fragment = [](const Fragment<Depth>& in, FragmentOutput& out) {
                const float t = in.varyings.t, dx = in.ddx.t, dy = in.ddy.t;
                out.color[0] = vec4(t, t * t + 0.25f * (dx * dx + dy * dy), 0.0f, 0.0f);
            };
            draw(pass, geometry, state, vertex, FragmentProgram{fragment, {.derivatives = true, .visible_only = true}},
                 Targets{.depth = &depth,
                         .color = {&moments},
                         .layer = layer,
                         .clear_depth = 1.0f,
                         .clear_color = vec4(1.0f)});
        }
    }

    void blur(Frame& frame, Target& moments) const {
        if (params_.kernel == 1) return;
        const std::vector<float> weights =
            params_.blur == Blur::Box ? box_weights(params_.kernel) : binomial_weights(params_.kernel);
        Pass pass = frame.pass("blur");
        Target rows = frame.target(Format::RG32F, params_.size, params_.size, moments.layers());
        convolve_rows(pass, moments, rows, weights);
        convolve_columns(pass, rows, moments, weights);
    }

    float chebyshev(float mean, float square, float t) const {
        t -= params_.constant_bias;
        if (t <= mean) return 1.0f;
        const float variance = std::max(square - mean * mean, params_.min_variance);
        const float lit = variance / (variance + (t - mean) * (t - mean));
        return std::clamp((lit - params_.bleeding) / (1.0f - params_.bleeding), 0.0f, 1.0f);
    }

    VsmParams params_;
};

} // namespace

Entry vsm_entry() {
    return make_entry<Vsm, VsmParams>({.id = "vsm",
                                       .title = "variance shadow map",
                                       .family = "moments",
                                       .kind = TechniqueKind::Filtered,
                                       .paper = "Donnelly, Lauritzen 2006; Macedo 2018, 2.19",
                                       .lights = all_lights},
                                      vsm_fields);
}

} // namespace gnomon
