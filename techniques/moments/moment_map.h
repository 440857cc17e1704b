#pragma once
// Maps that are filtered ahead of their look-ups: moments or other functions of linear depth t, drawn from the light,
// pre-filtered, and read as means around a receiver. What vsm, esm, evsm, gsm, msm and csm-fourier share; what they
// make of the means is in bounds.h. [Macedo 2018, 2.4]
//
//   const MomentMap map = moment_map(frame, light, params);             // the light's views, wide enough for the
//   filter Target moments = draw_moments(frame, map, Format::RG32F, encode);   // encode(t, ∂t/∂x, ∂t/∂y) -> vec4 const
//   FilteredMap filtered = filter_map(frame, std::move(moments), params); for_each_moment_point(frame, light, map,
//   [&](const MomentPoint& at, PassCounters& counters) {
//       const vec4 mean = filtered_mean(filtered, at, counters); …
//
// Linear depth is 0 at the near plane of the light's view and 1 at its far plane. A filter stays on its own cube face,
// which is drawn so much wider than 90° that it always can; beyond the edge of a map its edge texel repeats.

#include <variant>

#include "raster/draw.h"
#include "raster/passes/summed_area.h"
#include "techniques/map/shadow_map.h"
#include "techniques/moments/bounds.h"
#include "techniques/technique.h"

namespace gnomon {

enum class Prefilter { Blur, Mip, Sat };
enum class BlurShape { Binomial, Box, Gaussian };
enum class SumKind { Float, Double, Uint32, Int64 };
enum class MomentFormat { Float32, Half, Unorm16, Unorm8 };

struct MomentMapParams : MapParams {
    int kernel = 15;
    Prefilter prefilter = Prefilter::Blur;
    BlurShape blur = BlurShape::Binomial;
    float sigma = 0.0f;
    SumKind sums = SumKind::Double;
    float sum_offset = 0.5f;
    bool footprint = false;
    float plane_bias = 0.0f;
    float bleeding = 0.0f;
};

constexpr auto moment_map_fields = join(
    map_fields,
    fields(
        field("kernel", &MomentMapParams::kernel, 1, 63, "texels", "side of the filter", "Macedo 2018, 4.3.1"),
        field("prefilter", &MomentMapParams::prefilter, "blur|mip|sat",
              "separable blur and bilinear look-up; mip map, trilinear at the level whose texels are as wide as the "
              "filter; or summed-area table, a box of exactly that width about the receiver",
              "Donnelly and Lauritzen 2006, 4; sat: Lauritzen 2007, 8.5"),
        field("blur", &MomentMapParams::blur, "binomial|box|gaussian",
              "shape of prefilter=blur: binomial has sigma sqrt((kernel-1)/4)", "author's programs: binomial"),
        field("sigma", &MomentMapParams::sigma, 0, 64, "texels", "of blur=gaussian; 0: kernel/6",
              "Donnelly and Lauritzen 2006, 4"),
        field("sums", &MomentMapParams::sums, "float|double|uint32|int64",
              "what prefilter=sat sums in: as a GPU's floats do, in double, or in fixed point, of 32 bits that wrap "
              "around or exact",
              "Lauritzen 2007, 8.5.2"),
        field("footprint", &MomentMapParams::footprint,
              "filter over no less than the pixel covers on the map, with mip levels of the blurred map where "
              "prefilter=blur",
              "Donnelly and Lauritzen 2006, 4.2"),
        field("plane-bias", &MomentMapParams::plane_bias, 0, 8, "",
              "brings the receiver nearer by this times the depth that its own plane spans over the filter's standard "
              "deviation along both axes, so that a plane does not shadow itself",
              "Peters and Klein 2015, 3.4"),
        field("bleeding", &MomentMapParams::bleeding, 0, 0.999, "",
              "light bleeding reduction: fractions lit up to this are dark, the rest is stretched",
              "Lauritzen 2007, 8.4.3")));

// The light's views with its parameters. Throws UsageError where the filter does not fit on a cube face.
struct MomentMap : LightMap {
    MomentMapParams filter;
};
MomentMap moment_map(const Frame& frame, const Light& light, const MomentMapParams& params);

namespace detail {
struct LinearDepth {
    float t;
};
} // namespace detail

// Draws the casters from the light's views, depth less, no culling, and stores encode(t, ∂t/∂x, ∂t/∂y) -> vec4 of what
// is seen; where nothing is, encode(1, 0, 0). Derivatives are per texel.
template <class Encode>
Target draw_moments(Frame& frame, const MomentMap& map, Format format, const Encode& encode,
                    const char* name = "moments") {
    const int size = map.params.size, layers = static_cast<int>(map.views.size());
    Pass pass = frame.pass(name);
    Target moments = frame.target(format, size, size, layers);
    Target depth = frame.target(Format::D32F, size, size, layers);
    PipelineState state;
    state.depth = {.test = Compare::Less, .write = true};
    const std::vector<vec3>& positions = frame.scene().positions;
    const Geometry geometry = {static_cast<std::uint32_t>(positions.size()), frame.casters()};
    for (int layer = 0; layer < layers; ++layer) {
        const LightView& view = map.views[static_cast<size_t>(layer)];
        const auto vertex = [&](std::uint32_t i) {
            return Vertex<detail::LinearDepth>{transform(view.to_clip, positions[i]),
                                               {view.linear_depth(positions[i])}};
        };
        const auto fragment = [&](const Fragment<detail::LinearDepth>& in, FragmentOutput& out) {
            out.color[0] = encode(in.varyings.t, in.ddx.t, in.ddy.t);
        };
        draw(pass, geometry, state, vertex, FragmentProgram{fragment, {.derivatives = true, .visible_only = true}},
             Targets{.depth = &depth,
                     .color = {&moments},
                     .layer = layer,
                     .clear_depth = 1.0f,
                     .clear_color = encode(1.0f, 0.0f, 0.0f)});
    }
    return moments;
}

// A map after its pre-filter: blurred, with its mip chain, or with the summed-area tables of its layers.
struct FilteredMap {
    std::vector<Target> levels; // [0] blurred or as drawn; above it the mip chain, where there is one
    std::variant<std::monostate, std::vector<SummedArea<float>>, std::vector<SummedArea<double>>,
                 std::vector<SummedArea<std::uint32_t>>, std::vector<SummedArea<std::int64_t>>>
        sums;
};

// Filters as the parameters say. `widest` in texels is the largest width that look-ups of a summed-area table will ask
// for: it sets the resolution of 32-bit sums, which wrap around beyond it; 0: the kernel.
FilteredMap filter_map(Frame& frame, Target moments, const MomentMapParams& params, int widest = 0);

// The separable blur alone, in place. With log_warp c > 0 what is blurred is e^(c·value), values in and out (see
// convolve_rows_log).
void blur_map(Frame& frame, Target& moments, const MomentMapParams& params, float log_warp = 0.0f);

// Mean over the square of `width` texels about `texel`. A blurred map is wider by its blur: bilinear up to width 1,
// beyond that trilinear in its mip chain. Fetches are counted.
vec4 filtered_mean(const FilteredMap& map, vec2 texel, float width, int layer, PassCounters& counters);

// A receiver on the map: where to filter, how wide, and the depth to compare, all biases included.
struct MomentPoint {
    vec2 texel;
    float width; // texels, for filtered_mean
    int layer;
    float t; // linear depth
};
inline vec4 filtered_mean(const FilteredMap& map, const MomentPoint& at, PassCounters& counters) {
    return filtered_mean(map, at.texel, at.width, at.layer, counters);
}

// The point of the receiver at pixel (x, y), or the fraction lit where no look-up is needed: it faces away from the
// light, or lies outside the map.
std::variant<float, MomentPoint> moment_point(const Frame& frame, const Light& light, const MomentMap& map,
                                              const Receiver& receiver, ivec2 pixel);

// The look-up pass: program(const MomentPoint&, PassCounters&) -> fraction lit, then light bleeding is reduced.
template <class Program>
Image<float> for_each_moment_point(Frame& frame, const Light& light, const MomentMap& map, const Program& program) {
    return for_each_receiver(frame, "look-up", [&](const Receiver& receiver, Pixel& pixel) {
        const auto point = moment_point(frame, light, map, receiver, {pixel.x, pixel.y});
        if (const float* known = std::get_if<float>(&point)) return *known;
        const float lit = program(std::get<MomentPoint>(point), pixel.counters);
        return reduce_bleeding(lit, map.filter.bleeding);
    });
}

// Layer 0 of every channel as a debug image "name-1", "name-2", …
void show_channels(Visibility& visibility, const std::string& name, const Target& map);
// The map that look-ups read as "filtered-1", …: blurred, or the mip level as wide as the filter; a summed-area table's
// sums as "sums-1", …
void show_filtered(Visibility& visibility, const FilteredMap& map, const MomentMapParams& params);

// Throws UsageError where exponentials, which fixed point cannot hold, would be summed in it.
void require_float_sums(const MomentMapParams& params, const char* technique);

} // namespace gnomon
