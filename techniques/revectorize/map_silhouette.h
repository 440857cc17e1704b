#pragma once
// Revectorization on a light's shadow map: the parameters that its techniques share, the map as a source of the
// traversal, and the inner images they show. [Macedo 2018, chapters 3 and 4]
//
// Cube faces: a run goes on over the edge of a face, onto the texels that lie next to it on the neighbouring one.
//
// The preset "published" that these techniques have is the state of the author's programs (github.com/MarcioCerqueira/
// GlobalIllumination, 2020). Its lengths are units of his scenes, where the light's near plane is 1.

#include "techniques/map/shadow_map.h"
#include "techniques/revectorize/revectorize.h"
#include "techniques/technique.h"

namespace gnomon {

enum class EpsUnit { Scaled, Window };
enum class Stepping { Integer, Float };

struct RevectorizeParams : FilteredMapParams {
    RevectorizeParams() { receiver_plane = false; } // the thesis keeps the receiver's own depth
    int max_size = 16;
    float slope_eps = 2.5e-5f;
    EpsUnit eps_unit = EpsUnit::Scaled;
    Continuation continuation = Continuation::Perp;
    bool reject_isolated_end = true;
    Stepping stepping = Stepping::Integer;
};

constexpr auto revectorize_fields = join(
    filtered_map_fields,
    fields(field("max-size", &RevectorizeParams::max_size, 1, 1024, "texels", "longest run that is walked, each way",
                 "Macedo 2018, listing A.3"),
           field("slope-eps", &RevectorizeParams::slope_eps, 0, 1, "depth",
                 "on a walk, depths nearer than this count as the receiver's own slope; 0: none do",
                 "Macedo 2018, 3.1.3"),
           field("eps-unit", &RevectorizeParams::eps_unit, "scaled|window",
                 "scaled: as in the author's light, where 2.5e-5 is 1/200 of the map's width; window: this light's "
                 "own window depth",
                 "author's programs: near 1, far 1000, 45 degrees, 164 away"),
           field("continuation", &RevectorizeParams::continuation, "any|share|perp",
                 "a run goes on at a texel with any discontinuity, with one in common, or with one in common "
                 "across the walk",
                 "Macedo 2018, listing A.3; 3.1.3; author's programs"),
           field("reject-isolated-end", &RevectorizeParams::reject_isolated_end,
                 "a texel that differs from all its neighbours closes no run", "author's programs"),
           field("stepping", &RevectorizeParams::stepping, "integer|float",
                 "whole texels, or steps of 1/size in float32 coordinates, which slip near texel edges as on a GPU",
                 "Macedo 2018, listing A.3")));

SilhouetteRules silhouette_rules(const RevectorizeParams& params);

// `eps`, in the unit of the parameters, as window depth of the view that the point falls on.
float window_eps(float eps, const RevectorizeParams& params, const LightMap& map, const MapPoint& point);

// The map as seen from one receiver.
struct MapSource {
    const ShadowMap& map;
    const MapPoint& point;
    PassCounters& counters;

    float behind(ivec2 texel, float depth) const {
        const MapTap tap = map_tap(map, point.layer, texel.x, texel.y, point.depth_at(texel.x, texel.y, depth));
        if (!tap.inside) return map.params.border == Border::Lit ? -infinity : infinity;
        return tap.depth - fetch_depth(map.depth, tap.x, tap.y, tap.layer, counters);
    }
};

// Inner images, 0 off the silhouette: discontinuities as bits of Side, 16 more where V_SM is 0, and relative positions.
class SilhouetteImages {
public:
    explicit SilhouetteImages(const Frame& frame);
    void set(const Pixel& pixel, const Revectorized& result) {
        if (result.discontinuities == 0) return;
        discontinuities_(pixel.x, pixel.y) = static_cast<float>(result.discontinuities + (result.lit ? 0u : 16u));
        relative_x_(pixel.x, pixel.y) = result.relative.x;
        relative_y_(pixel.x, pixel.y) = result.relative.y;
    }
    void move_to(Visibility& visibility);

private:
    Image<float> discontinuities_, relative_x_, relative_y_;
};

// The shadow map, then the full-screen pass of a technique with one look-up a receiver: look_up(const MapSource&, const
// SilhouetteRules&, const MapSample&) -> Revectorized.
template <class LookUp>
Visibility revectorize_receivers(Frame& frame, const Light& light, const RevectorizeParams& params,
                                 const LookUp& look_up) {
    const ShadowMap map = draw_shadow_map(frame, light, params);
    const SilhouetteRules rules = silhouette_rules(params);
    SilhouetteImages images(frame);
    Visibility visibility;
    visibility.values = for_each_receiver(frame, "revectorize", [&](const Receiver& receiver, Pixel& pixel) {
        const MapPoint point = map_point(map, light, receiver, params.receiver_plane);
        if (point.lit || point.dark) return point.lit ? 1.0f : 0.0f;
        const MapSample sample = {point.texel, point.depth, window_eps(params.slope_eps, params, map, point)};
        const Revectorized result = look_up(MapSource{map, point, pixel.counters}, rules, sample);
        images.set(pixel, result);
        return result.visibility;
    });
    images.move_to(visibility);
    visibility.debug.push_back({"shadow-map", show_depth(map.depth, 0)});
    return visibility;
}

} // namespace gnomon
