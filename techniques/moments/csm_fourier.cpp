// Convolution shadow map: the shadow test as a Fourier series of depth, whose basis functions are images that are
// filtered ahead of the look-up. [Annen, Mertens, Bekaert, Seidel, Kautz 2007; Macedo 2018, 2.4]
//
// 1. depth: linear depth z, scaled to a range shorter than 1.
// 2. basis images: cos(c_k z) and sin(c_k z), c_k = π(2k − 1), k = 1 … M, two terms an RGBA image, as ½ + ½ value.
// 3. pre-filter of every image.
// 4. look-up at t' = t − offset: V = clamp(scale · (½ + 2 Σ a_k/c_k (cos(c_k t') E[sin c_k z] − sin(c_k t') E[cos c_k
//    z]))), a_k = e^(−attenuation·(k/M)²) against ringing.
//
// The series is ½ where z = t, where a surface meets itself: scaled by 2, and by 1.05 for what ringing takes from the
// light, it is lit there. An offset does the same by moving the receiver, but leaks more at contacts, the more so the
// deeper a scene is against what it holds.

#include "raster/full_screen.h"
#include "techniques/all.h"
#include "techniques/moments/moment_map.h"

namespace gnomon {
namespace {

struct CsmParams : MomentMapParams {
    int terms = 16;
    float attenuation = 1.0f;
    float offset = 0.0f;
    float scale = 2.1f;
    float range = 0.94f;
    MomentFormat format = MomentFormat::Unorm8;
    CsmParams() { plane_bias = 0.5f; }
};
constexpr auto csm_fields = join(
    moment_map_fields,
    fields(
        field("terms", &CsmParams::terms, 1, 16, "", "M, terms of the series; two to an image", "Annen et al. 2007, 4"),
        field("attenuation", &CsmParams::attenuation, 0, 16, "",
              "alpha of the attenuation e^(-alpha (k/M)^2) against ringing", "Annen et al. 2007, 4"),
        field("offset", &CsmParams::offset, 0, 1, "linear depth",
              "subtracted from the receiver's depth, so that the series has risen where it meets its own surface",
              "Annen et al. 2007, 4"),
        field("scale", &CsmParams::scale, 1, 4, "", "the series times this, before it is clamped",
              "Annen et al. 2007, 4"),
        field(
            "range", &CsmParams::range, 0.1, 1, "linear depth",
            "what depths are scaled to before they enter the series, whose period is 2: at 1 the far plane meets what "
            "lies at the near plane as it meets itself",
            "ours"),
        field("format", &CsmParams::format, "float32|half|unorm16|unorm8", "what an image stores a value in",
              "Annen et al. 2007: unorm8")));

class CsmFourier : public Technique {
public:
    explicit CsmFourier(CsmParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const MomentMap map = moment_map(frame, light, params_);
        const Target depth = draw_moments(
            frame, map, Format::R32F, [](float t, float, float) { return vec4(t, 0.0f, 0.0f, 0.0f); }, "depth");
        std::vector<Target> basis = basis_images(frame, depth);
        Visibility visibility;
        show_channels(visibility, "moments", basis[0]);
        std::vector<FilteredMap> filtered;
        for (Target& image : basis) filtered.push_back(filter_map(frame, std::move(image), params_));

        const FourierSeries series = {params_.terms, params_.attenuation};
        visibility.values =
            for_each_moment_point(frame, light, map, [&](const MomentPoint& at, PassCounters& counters) {
                vec4 means(0.0f);
                const double value = series.value(scaled(at.t - params_.offset), [&](int k) {
                    const int term = k - 1;
                    if (term % 2 == 0)
                        means = 2.0f * filtered_mean(filtered[static_cast<size_t>(term / 2)], at, counters) - 1.0f;
                    return term % 2 == 0 ? dvec2(means.x, means.y) : dvec2(means.z, means.w);
                });
                return saturate(params_.scale * static_cast<float>(value));
            });
        show_filtered(visibility, filtered[0], params_);
        return visibility;
    }

private:
    std::vector<Target> basis_images(Frame& frame, const Target& depth) const {
        const auto images = static_cast<size_t>(params_.terms + 1) / 2;
        std::vector<Target> basis;
        for (size_t i = 0; i < images; ++i)
            basis.push_back(frame.target(format(), depth.width(), depth.height(), depth.layers()));
        Pass pass = frame.pass("basis images");
        const FourierSeries series = {params_.terms, 0.0f};
        for (int layer = 0; layer < depth.layers(); ++layer) {
            Targets targets{.layer = layer};
            for (Target& image : basis) targets.color.push_back(&image);
            full_screen(pass, targets, [&](Pixel& pixel) {
                const double z = scaled(fetch(depth, pixel.x, pixel.y, layer, 0, pixel.counters).x);
                for (int term = 0; term < params_.terms; ++term) {
                    const vec2 value(FourierSeries::cos_sin(series.frequency(term + 1) * z) * 0.5 + 0.5);
                    vec4& color = pixel.color[static_cast<size_t>(term / 2)];
                    (term % 2 == 0 ? color.x : color.z) = value.x;
                    (term % 2 == 0 ? color.y : color.w) = value.y;
                }
            });
        }
        return basis;
    }

    double scaled(float depth) const { return static_cast<double>(depth) * static_cast<double>(params_.range); }

    Format format() const {
        switch (params_.format) {
        case MomentFormat::Float32:
            return Format::RGBA32F;
        case MomentFormat::Half:
            return Format::RGBA16F;
        case MomentFormat::Unorm16:
            return Format::RGBA16;
        default:
            return Format::RGBA8;
        }
    }

    CsmParams params_;
};

} // namespace

Entry csm_fourier_entry() {
    return make_entry<CsmFourier, CsmParams>(
        {.id = "csm-fourier",
         .title = "convolution shadow map",
         .family = "moments",
         .kind = TechniqueKind::Filtered,
         .paper = "Annen et al. 2007; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 2.4",
         .equations = "V = 1/2 + 2 sum over k = 1 to M of a_k/c_k E[sin(c_k (z - t))], c_k = (2k - 1) pi, a_k = "
                      "e^(-alpha (k/M)^2)",
         .strengths = "bleeds by no more than its ringing, wherever the layers lie",
         .artifacts = "ringing, bands of a few per cent; contacts closer than 1/(2 terms) of the light's depth range "
                      "bleed; terms/2 "
                      "images of memory"},
        csm_fields);
}

} // namespace gnomon
