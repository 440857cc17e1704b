#pragma once
// Penumbrae from the distance transform of an image of hard shadows, pass by pass: which surface a pixel shows, seeds
// on the silhouette, the nearest of them, intensities from the distance to it, and a mean over the image that stops at
// edges. [Macedo 2018, 4.2 and 5.2]

#include "raster/passes/distance_transform.h"
#include "techniques/revectorize/rbsm_nonc.h"

namespace gnomon {

enum class DepthScale { Linear, PseudoLinear };
enum class DistanceSpace { World, Clip, Screen };
enum class NearestSeed { Pixel, World };
enum class SeedTransform { Exact, JumpFlooding };
enum class MeanWidth { Viewpoint, Resolution, Fixed };
enum class MeanTaps { Whole, FromEdge };

struct EdtParams : RbsmNoncParams {
    bool edge_tests = true;
    DepthScale depth_scale = DepthScale::Linear;
    float seed_threshold = 2.5e-3f, penumbra_threshold = 2.5e-3f, mean_threshold = 2.5e-3f;
    NearestSeed nearest = NearestSeed::Pixel;
    SeedTransform transform = SeedTransform::Exact;
    DistanceSpace distance = DistanceSpace::World;
    int kernel = 15;
    MeanWidth mean_width = MeanWidth::Viewpoint;
    float mean_scale = 0.0f;
    MeanTaps mean_taps = MeanTaps::Whole;
    bool field_in_degrees = false;
};

constexpr auto edt_fields = join(
    rbsm_nonc_fields,
    fields(
        field("edge-tests", &EdtParams::edge_tests, "surfaces of different depth have nothing to do with each other",
              "Macedo 2018, 4.2.3"),
        field("depth-scale", &EdtParams::depth_scale, "linear|pseudo-linear",
              "depth d of the thresholds, camera planes N and F: (d-N)/(F-N), or 2d/(d+F)", "author's programs"),
        field("seed-threshold", &EdtParams::seed_threshold, 0, 1, "depth",
              "neighbours further apart than this make no seed", "Macedo 2018, 4.2.3"),
        field("penumbra-threshold", &EdtParams::penumbra_threshold, 0, 1, "depth",
              "a seed further from the pixel than this is another surface's", "Macedo 2018, 4.2.3"),
        field("mean-threshold", &EdtParams::mean_threshold, 0, 1, "depth",
              "a tap of the mean this far or further counts as the pixel itself", "Macedo 2018, 4.2.3"),
        field("nearest", &EdtParams::nearest, "pixel|world",
              "the seed nearest in the image, or, by trying all, in the world", "Macedo 2018, 4.2.2"),
        field("transform", &EdtParams::transform, "exact|jump-flooding",
              "how the seed nearest in the image is found; jump flooding misses some", "Macedo 2018, 4.2"),
        field("distance", &EdtParams::distance, "world|clip|screen",
              "space of the distance to the seed; screen counts pixels and follows the viewer",
              "Macedo 2018, 4.2.3; clip: author's programs"),
        field("kernel", &EdtParams::kernel, 0, 255, "pixels", "side of the mean filter; 0: none", "Macedo 2018, 4.3"),
        field("mean-width", &EdtParams::mean_width, "viewpoint|resolution|fixed",
              "kernel times z_screen times mean-scale over the distance from the eye; that times height/720; or "
              "kernel pixels everywhere",
              "Macedo 2018, (4.4), (4.5)"),
        field("mean-scale", &EdtParams::mean_scale, 0, 1e6, "m",
              "for the units of (4.4); 0: 50 units of the author's scenes, each 1/144 of the scene's diagonal",
              "author's programs: 50"),
        field("mean-taps", &EdtParams::mean_taps, "whole|from-edge",
              "taps of the mean at whole pixels, or in steps of 1 from the kernel's very edge", "author's programs"),
        field("field-in-degrees", &EdtParams::field_in_degrees,
              "takes the tangent in (4.5) of degrees, as the author's program does", "author's programs")));

// Lengths of the author's scenes, where the plane is 120 × 80 units, in metres of this one.
inline float author_units(const Scene& scene, float units) { return units * scene.bounds.diagonal() / 144.0f; }

// Depth in the thresholds' scale, of a point d metres from the eye plane, between camera planes n and f.
inline float scaled_depth(DepthScale scale, float d, float n, float f) {
    return scale == DepthScale::Linear ? (d - n) / (f - n) : 2.0f * d / (d + f);
}

// (4.5), of a field of view in radians; `in_degrees` takes the tangent of its degrees.
inline double z_screen(double vertical_fov, bool in_degrees) {
    const double tangent = std::tan(0.5 * (in_degrees ? glm::degrees(vertical_fov) : vertical_fov));
    return 1.0 / (2.0 * std::abs(tangent));
}

// What the passes read: hard shadows, depth in the thresholds' scale (+∞ where nothing is seen), and whether a receiver
// was looked up at all: those that face away from the light have no silhouette. [the author's programs]
struct ShadowImage {
    const Image<float>& hard;
    Target depth;
    Image<std::uint8_t> looked_up;
};
ShadowImage shadow_image(Frame& frame, const Light& light, const EdtParams& params, const Image<float>& hard);

// Pixels with a neighbour, of eight, that was looked up, lies on the same surface and has another hard shadow.
Image<std::uint8_t> silhouette_seeds(Frame& frame, const EdtParams& params, const ShadowImage& image);

Image<Site> nearest_silhouette(Frame& frame, const EdtParams& params, const Image<std::uint8_t>& seeds);

// Distance from each pixel to its site, in the space of the parameters; infinite where there is none or where it is on
// another surface.
Image<float> silhouette_distances(Frame& frame, const EdtParams& params, const ShadowImage& image,
                                  const Image<Site>& sites);

// ½ ∓ D/width within width/2 of the silhouette, the hard shadow beyond. (4.3), (5.3)
inline float penumbra_intensity(float hard, float distance, float width) {
    if (!(distance <= 0.5f * width) || !(width > 0.0f)) return hard;
    return hard == 0.0f ? 0.5f - distance / width : 0.5f + distance / width;
}

// The mean over the image, rows then columns, in place. (4.4), (4.5)
void mean_over_surface(Frame& frame, const EdtParams& params, const ShadowImage& image, Image<float>& intensities);

} // namespace gnomon
