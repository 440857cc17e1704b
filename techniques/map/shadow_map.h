#pragma once
// The light's shadow-map pass and the way from a receiver to its place on the map: what every image-based technique
// starts with. [Williams 1978; Macedo 2018, 2.2 and 3.1.2; Navrátil 2015, 2.3]

#include <algorithm>
#include <span>

#include "core/parameters.h"
#include "raster/sampler.h"
#include "techniques/map/light_view.h"

namespace gnomon {

enum class DepthFormat { D32F, D24, D16 };
enum class Border { Lit, Shadow };

// What every map that is drawn from the light needs, whatever it stores.
struct MapParams {
    int size = 1024;
    float constant_bias = 0.0f;
    float normal_offset = 0.0f;
    bool facing_test = true;
    Projection projection = Projection::Auto;
    float near_plane = 0.0f;
    Border border = Border::Lit;
};

constexpr auto map_fields = fields(
    field("size", &MapParams::size, 1, 16384, "texels", "side of the map, or of each cube face", "Williams 1978"),
    field("constant-bias", &MapParams::constant_bias, -1, 1, "depth", "subtracted from the receiver's depth",
          "Navratil 2015, 2.3.3"),
    field("normal-offset", &MapParams::normal_offset, 0, 64, "texels",
          "moves the receiver along its normal, by texels of the map times the sine of the light's angle",
          "Holbert 2011"),
    field("facing-test", &MapParams::facing_test, "receivers that face away from the light are dark without a look-up",
          "author's programs"),
    field("projection", &MapParams::projection, projection_choices,
          "one view where all casters fit into 120 degrees, else six cube faces; or force one",
          "cube: Navratil 2015, 3.3.1"),
    field("near", &MapParams::near_plane, 0, 1e6, "m", "near plane of the light's view; 0: as far as no caster is cut",
          "author's programs: 1"),
    field("border", &MapParams::border, "lit|shadow", "what lies outside the map", "author's programs: shadow"));

// A map of depths, with the polygon offset it is drawn with.
struct ShadowMapParams : MapParams {
    DepthFormat format = DepthFormat::D32F;
    float slope_bias = 4.0f;
    float units_bias = 20.0f;
};

constexpr auto shadow_map_fields =
    join(map_fields, fields(field("format", &ShadowMapParams::format, "d32f|d24|d16", "what the map stores depth in",
                                  "author's programs: d32f"),
                            field("slope-bias", &ShadowMapParams::slope_bias, 0, 64, "",
                                  "polygon offset factor: times the depth slope per texel", "author's programs: 4"),
                            field("units-bias", &ShadowMapParams::units_bias, 0, 1e7, "",
                                  "polygon offset units: times the depth resolution", "author's programs: 20")));

// A depth map that is looked up at many texels around the receiver.
struct FilteredMapParams : ShadowMapParams {
    bool receiver_plane = true;
};

constexpr auto filtered_map_fields =
    join(shadow_map_fields,
         fields(field(
             "receiver-plane", &FilteredMapParams::receiver_plane,
             "compares each tap with the depth of the receiver's plane there; false: with the receiver's own depth, "
             "so that slope-bias must cover the kernel",
             "Isidoro 2006")));

// The light's views and how receivers fall on them; maps store one layer a view.
struct LightMap {
    MapParams params;
    std::vector<LightView> views;
};

struct ShadowMap : LightMap {
    Target depth;
};

// Where a receiver falls on the map. `texel` counts from the lower left corner of the map, in texels.
struct MapPoint {
    bool lit = false;  // no look-up needed: behind the light's view, or beyond its far plane
    bool dark = false; // no look-up needed: the receiver faces away from the light
    int layer = 0;
    vec3 position{0.0f}; // the receiver's, moved by the normal offset
    vec2 texel{0.0f};
    float depth = 0.0f;  // window depth, constant bias subtracted
    vec2 gradient{0.0f}; // window depth per texel along the receiver's plane; zero unless asked for

    // Depth to compare with at the centre of texel (x, y), no farther than the far plane, beyond which nothing casts;
    // `from` replaces the point's own depth.
    float depth_at(int x, int y) const { return std::min(1.0f, depth_at(x, y, depth)); }
    float depth_at(int x, int y, float from) const {
        return from + (gradient.x * (static_cast<float>(x) + 0.5f - texel.x) +
                       gradient.y * (static_cast<float>(y) + 0.5f - texel.y));
    }
};

// Draws all casters from the light's views: depth less, write, no colour, no culling, the polygon offset of the
// parameters.
ShadowMap draw_shadow_map(Frame& frame, const Light& light, const ShadowMapParams& params);

MapPoint map_point(const LightMap& map, const Light& light, const Receiver& receiver, bool receiver_plane = false);

// A texel to compare with: beyond the edge of a cube face it lies on the neighbouring face, with the depth as seen from
// there.
struct MapTap {
    bool inside; // false: beyond the edge of a single view
    int layer, x, y;
    float depth;
};
MapTap tap_outside(const LightMap& map, int layer, int x, int y, float depth); // of texels beyond the edge
inline MapTap map_tap(const LightMap& map, int layer, int x, int y, float depth) {
    const auto side = static_cast<unsigned>(map.params.size);
    if (static_cast<unsigned>(x) < side && static_cast<unsigned>(y) < side) [[likely]]
        return {true, layer, x, y, depth};
    return tap_outside(map, layer, x, y, depth);
}

// 1 where depth ≤ the stored depth of texel (x, y), 0 where the texel is nearer; the border's answer outside the map.
// [Macedo 2018, (3.2)]
inline float shadow_test(const ShadowMap& map, int layer, int x, int y, float depth, PassCounters& counters) {
    const MapTap tap = map_tap(map, layer, x, y, depth);
    if (!tap.inside) return map.params.border == Border::Lit ? 1.0f : 0.0f;
    return tap.depth <= fetch_depth(map.depth, tap.x, tap.y, tap.layer, counters) ? 1.0f : 0.0f;
}

// Place of tap i of n along one side of a kernel that spans [−1, 1]: the centre of the i-th of n cells.
inline float kernel_cell(int i, int n) { return (static_cast<float>(2 * i + 1) / static_cast<float>(n)) - 1.0f; }

// Mean of n×n nearest shadow tests at offsets spread evenly over ±reach texels around the point: the centres of n×n
// cells, v outer and u inner; n from 1 to 64. [Reeves et al. 1987; Macedo 2018, 2.4]
float percentage_closer(const ShadowMap& map, const MapPoint& point, int n, vec2 reach, PassCounters& counters);

// The same at any offsets from the point, in texels.
float mean_of_tests(const ShadowMap& map, const MapPoint& point, std::span<const vec2> offsets, PassCounters& counters);

// Mean of hardware comparisons at these offsets: each the bilinear mean of the four nearest texels' tests against one
// depth, that of the receiver's plane at the offset; four fetches each. [Reeves et al. 1987; OpenGL 4.6, 8.23.1]
float mean_of_bilinear_tests(const ShadowMap& map, const MapPoint& point, std::span<const vec2> offsets,
                             PassCounters& counters);

// One layer of the map as an image, for showing: depth scaled so that the casters' range is black to white.
Image<float> show_depth(const Target& depth, int layer);

} // namespace gnomon
