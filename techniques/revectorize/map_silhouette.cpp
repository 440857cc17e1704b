#include "techniques/revectorize/map_silhouette.h"

namespace gnomon {

SilhouetteRules silhouette_rules(const RevectorizeParams& params) {
    return {params.max_size, params.continuation, params.reject_isolated_end,
            params.stepping == Stepping::Float ? params.size : 0};
}

float window_eps(float eps, const RevectorizeParams& params, const LightMap& map, const MapPoint& point) {
    if (params.eps_unit == EpsUnit::Window) return eps;
    // In the author's light a window depth of e is e·d² metres at distance d, near plane 1; its map is 2d·tan(45°/2)
    // wide.
    constexpr double author_distance = 164.3, author_half_extent = 0.41421356;
    const double map_widths = static_cast<double>(eps) * author_distance / (2.0 * author_half_extent);
    const LightView& view = map.views[static_cast<size_t>(point.layer)];
    const double range = view.far_plane - view.near_plane;
    // Times the width here, metres, and the window depth per metre: 1/(F − N), or FN/((F − N)·d²) where d = FN/(F −
    // z·(F − N)).
    if (view.orthographic) return static_cast<float>(map_widths * 2.0 * view.half_extent / range);
    return static_cast<float>(map_widths * 2.0 * view.half_extent *
                              (view.far_plane / range - static_cast<double>(point.depth)));
}

SilhouetteImages::SilhouetteImages(const Frame& frame)
    : discontinuities_(frame.width(), frame.height()), relative_x_(frame.width(), frame.height()),
      relative_y_(frame.width(), frame.height()) {}

void SilhouetteImages::move_to(Visibility& visibility) {
    visibility.debug.push_back({"discontinuities", std::move(discontinuities_)});
    visibility.debug.push_back({"relative-position.x", std::move(relative_x_)});
    visibility.debug.push_back({"relative-position.y", std::move(relative_y_)});
}

} // namespace gnomon
