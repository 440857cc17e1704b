#pragma once
// A scene whose shadow map of 64 texels a side is exactly a given mask: a floor at y = 0, and at y = 1 a sheet over
// every texel column, from the map's lower edge up to a given row. The light shines straight down, as a direction or
// from a spot at y = 5; the camera hangs under the sheets and sees 16 × 16 texels around the map's middle, 16 × 16
// pixels each.

#include "core/scene.h"
#include "techniques/frame.h"

namespace gnomon_tests {

inline constexpr int mask_side = 64, mask_pixels = 256;

struct MaskScene {
    gnomon::Scene scene;
    gnomon::Light light;

    // Where a floor point falls on the map, in texels from its middle.
    gnomon::vec2 texels(gnomon::vec3 p) const;
    gnomon::dvec3 world(double u, double v, double y) const; // the point at height y that falls there
    double texel_width() const;                              // metres, on the floor
};

// Shadow in column i, both counted from the map's middle, is j < top(i).
template <class Top> MaskScene mask_scene(gnomon::LightType type, const Top& top);

MaskScene mask_scene_of(gnomon::LightType type, const std::vector<int>& tops); // mask_side of them, from the left

template <class Top> MaskScene mask_scene(gnomon::LightType type, const Top& top) {
    std::vector<int> tops;
    for (int i = 0; i < mask_side; ++i) tops.push_back(top(i - mask_side / 2));
    return mask_scene_of(type, tops);
}

inline gnomon::Frame mask_frame(const MaskScene& mask) {
    return {mask.scene, mask.scene.cameras[0], mask_pixels, mask_pixels};
}

} // namespace gnomon_tests
