// Euclidean distance transform shadow mapping: penumbrae of one width around revectorized hard shadows, from distances
// to the nearest silhouette pixel of the image. [Macedo 2018, 4.2, algorithm 3]
//
// 1. shadow map, revectorize: R = V* of rbsm-nonc.
// 2. seeds: pixels with a neighbour of eight on the same surface, of another R.
// 3. distance transform: the nearest seed of every pixel in the image; D, the distance to it in the world.
// 4. normalize: I = ½ − D/P where R = 0, ½ + D/P where R = 1, within D ≤ P/2 of a seed on the same surface; else R
// (4.3).
// 5. mean, rows then columns, over kernel·z_screen·scale/z_eye pixels (4.4), (4.5); taps on other surfaces count as the
//    pixel itself.

#include "techniques/all.h"
#include "techniques/revectorize/edt_penumbra.h"

namespace gnomon {
namespace {

struct EdtsmParams : EdtParams {
    float penumbra = 0.0f;
};
constexpr auto edtsm_fields = join(
    edt_fields,
    fields(
        field("penumbra", &EdtsmParams::penumbra, 0, 1e6, "m",
              "width of the penumbra, pixels with distance=screen; 0: 1/144 of the scene's diagonal, which is one "
              "unit of the author's scenes, or 15 pixels",
              "Macedo 2018, 4.2.2"),
        preset("published",
               "size=2048,near=1,border=shadow,eps-unit=window,stepping=float,penumbra=0.2,distance=clip,depth-scale="
               "pseudo-linear,penumbra-threshold=5e-4,mean-scale=50,mean-taps=from-edge,field-in-degrees=on",
               "as the author's program has it", "github.com/MarcioCerqueira/GlobalIllumination")));

class Edtsm : public Technique {
public:
    explicit Edtsm(EdtsmParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        Visibility visibility = revectorize_hard(frame, light, params_);
        const Image<float> hard = std::move(visibility.values);
        const ShadowImage image = shadow_image(frame, light, params_, hard);
        const Image<std::uint8_t> seeds = silhouette_seeds(frame, params_, image);
        const Image<Site> sites = nearest_silhouette(frame, params_, seeds);
        Image<float> distances = silhouette_distances(frame, params_, image, sites);

        const float width = penumbra_width(frame.scene());
        visibility.values = normalize(frame, hard, distances, width);
        Image<float> penumbra = visibility.values;
        mean_over_surface(frame, params_, image, visibility.values);
        // What faces away from the light stays dark, as everywhere.
        for (size_t i = 0; i < hard.size(); ++i)
            if (frame.receivers().data()[i].valid() && !image.looked_up.data()[i]) visibility.values.data()[i] = 0.0f;

        Image<float> seed_image(frame.width(), frame.height());
        std::copy(seeds.values().begin(), seeds.values().end(), seed_image.values().begin());
        visibility.debug.push_back({"hard", hard});
        visibility.debug.push_back({"seeds", std::move(seed_image)});
        visibility.debug.push_back({"distances", std::move(distances)});
        visibility.debug.push_back({"penumbra", std::move(penumbra)});
        return visibility;
    }

private:
    float penumbra_width(const Scene& scene) const {
        if (params_.penumbra > 0) return params_.penumbra;
        return params_.distance == DistanceSpace::Screen ? 15.0f : author_units(scene, 1.0f);
    }

    static Image<float> normalize(Frame& frame, const Image<float>& hard, const Image<float>& distances, float width) {
        Image<float> intensities(frame.width(), frame.height());
        Pass pass = frame.pass("normalize");
        full_screen(pass, intensities, [&](Pixel& pixel) {
            pixel.counters.texels_fetched += 2;
            pixel.counters.bytes_read += std::int64_t{2 * sizeof(float)};
            return penumbra_intensity(hard(pixel.x, pixel.y), distances(pixel.x, pixel.y), width);
        });
        return intensities;
    }

    EdtsmParams params_;
};

} // namespace

Entry edtsm_entry() {
    return make_entry<Edtsm, EdtsmParams>(
        {.id = "edtsm",
         .title = "Euclidean distance transform shadow map",
         .family = "revectorization",
         .kind = TechniqueKind::Filtered,
         .paper = "Macedo, Apolinario 2017; Macedo 2018",
         .lights = all_lights,
         .section = "Macedo 2018, 4.2, algorithm 3",
         .equations = "(3.1) to (3.5), (3.9), (4.3) to (4.5)",
         .strengths = "penumbrae of any width at the same cost; no staircase; leaks nothing between surfaces that the "
                      "thresholds tell apart",
         .artifacts = "creases along the middle of shadows narrower than the penumbra, before the mean; the two pixels "
                      "at an edge are both 1/2; round corners; no penumbra where a silhouette is hidden from view; "
                      "surfaces nearer than the thresholds mix, and grazing ones fall apart"},
        edtsm_fields);
}

} // namespace gnomon
