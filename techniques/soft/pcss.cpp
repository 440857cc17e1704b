// Percentage-closer soft shadows: the penumbra's width from the mean depth of the blockers. [Fernando 2005; Macedo
// 2018, 2.5.1 and 5.1]
//
// 1. shadow map.
// 2. look-up: a. blocker search: mean distance d_b of the texels nearer than the receiver, over search × search taps in
// the square
//                where the light's pyramid from the receiver meets the near plane; none: V = 1.
//             b. penumbra width w_p = w_l (d_r − d_b) / d_b, d linear distances from the light (eq. 5.2).
//             c. V = mean of kernel × kernel tests over ±w_p/2.
// The light is taken for a square of its own area, parallel to the map.

#include <algorithm>
#include <cmath>

#include "techniques/all.h"
#include "techniques/map/shadow_map.h"

namespace gnomon {
namespace {

enum class Search { Frustum, Constant };

struct PcssParams : FilteredMapParams {
    int search = 9;
    int kernel = 15;
    Search search_area = Search::Frustum;
    float search_radius = 8.0f;
    float light_size = 0.0f;
};
constexpr auto pcss_fields = join(
    filtered_map_fields,
    fields(field("search", &PcssParams::search, 1, 63, "taps", "side of the blocker search", "Macedo 2018, 5.1"),
           field("kernel", &PcssParams::kernel, 1, 63, "taps", "side of the filter kernel", "Macedo 2018, 5.1"),
           field("search-area", &PcssParams::search_area, "frustum|constant",
                 "where blockers are sought: the receiver-light pyramid at the near plane, or search-radius texels",
                 "Fernando 2005; constant: author's programs"),
           field("search-radius", &PcssParams::search_radius, 0, 4096, "texels",
                 "half side of the constant search area", "author's programs: 8"),
           field("light-size", &PcssParams::light_size, 0, 1e6, "m",
                 "side of the square light; 0: the square root of the light's area", "Fernando 2005")));

float square_side(const Light& light) {
    const auto disk = static_cast<float>(pi) * 0.25f * light.size.x * light.size.x; // a sphere's too, as seen from afar
    switch (light.type) {
    case LightType::Rectangle:
    case LightType::TexturedRectangle:
        return std::sqrt(light.size.x * light.size.y);
    case LightType::Disk:
    case LightType::Sphere:
        return std::sqrt(disk);
    default:
        return 0.0f;
    }
}

class Pcss : public Technique {
public:
    explicit Pcss(PcssParams params) : params_(params) {}

    Visibility shade(Frame& frame, const Light& light) override {
        const ShadowMap map = draw_shadow_map(frame, light, params_);
        const double side = static_cast<double>(params_.light_size > 0 ? params_.light_size : square_side(light));
        Image<float> widths(frame.width(), frame.height(), 0.0f);
        Visibility visibility;
        visibility.values = for_each_receiver(frame, "look-up", [&](const Receiver& receiver, Pixel& pixel) {
            const MapPoint point = map_point(map, light, receiver, params_.receiver_plane);
            if (point.lit || point.dark) return point.lit ? 1.0f : 0.0f;
            const LightView& view = map.views[static_cast<size_t>(point.layer)];
            const double distance = view.distance(receiver.position);
            const double blocker = mean_blocker(map, view, point, search_reach(view, distance, side), pixel.counters);
            if (blocker <= 0) return 1.0f;
            const double penumbra = side * (distance - blocker) / blocker; // metres at the receiver (5.2)
            widths(pixel.x, pixel.y) = static_cast<float>(penumbra);
            const auto reach = static_cast<float>(0.5 * penumbra / view.width_at(distance) * params_.size);
            return percentage_closer(map, point, params_.kernel, vec2(std::max(reach, 0.0f)), pixel.counters);
        });
        visibility.debug.push_back({"penumbra-width", std::move(widths)});
        return visibility;
    }

private:
    // Half side of the search square in texels.
    double search_reach(const LightView& view, double distance, double side) const {
        if (params_.search_area == Search::Constant) return static_cast<double>(params_.search_radius);
        const double at_near_plane = 0.5 * side * std::max(distance - view.near_plane, 0.0) / distance;
        return at_near_plane / view.width_at(view.near_plane) * params_.size;
    }

    // Mean linear distance of the texels that shadow the point; 0 where there are none.
    double mean_blocker(const ShadowMap& map, const LightView& view, const MapPoint& point, double reach,
                        PassCounters& counters) const {
        const double n = view.near_plane, f = view.far_plane;
        double sum = 0;
        int count = 0;
        for (int v = 0; v < params_.search; ++v)
            for (int u = 0; u < params_.search; ++u) {
                const auto tap = [&](float center, int i) {
                    return std::floor(static_cast<double>(center) + ((2 * i + 1.0) / params_.search - 1.0) * reach);
                };
                const double x = tap(point.texel.x, u), y = tap(point.texel.y, v);
                const int i = static_cast<int>(x), j = static_cast<int>(y);
                const MapTap at = map_tap(map, point.layer, i, j, point.depth_at(i, j));
                if (!at.inside) continue;
                const float stored = fetch_depth(map.depth, at.x, at.y, at.layer, counters);
                if (at.depth <= stored) continue;
                sum += f * n / (f - static_cast<double>(stored) * (f - n)); // window depth to distance
                ++count;
            }
        return count ? sum / count : 0.0;
    }

    PcssParams params_;
};

} // namespace

Entry pcss_entry() {
    return make_entry<Pcss, PcssParams>(
        {.id = "pcss",
         .title = "percentage-closer soft shadows",
         .family = "shadow map",
         .kind = TechniqueKind::Soft,
         .paper = "Fernando 2005; Macedo 2018",
         .lights =
             all_lights & ~bit(LightType::Directional) & ~bit(LightType::TexturedRectangle) & ~bit(LightType::Mesh),
         .section = "Macedo 2018, 2.5.1 and 5.1",
         .equations = "(5.1) without its epsilon, (5.2)",
         .strengths = "penumbrae that widen with the distance from the blocker, from one shadow map; their width is "
                      "exact where light, blocker and receiver are parallel planes",
         .artifacts =
             "one mean depth stands for all blockers: layers mix, and penumbrae are too wide or too narrow where they "
             "do; bands where the taps are too far apart; what the search misses is lit; cost grows with both kernels"},
        pcss_fields);
}

} // namespace gnomon
