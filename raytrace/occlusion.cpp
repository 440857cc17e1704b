#include "raytrace/occlusion.h"

namespace gnomon {

Occlusion::Occlusion(const EmbreeScene& scene, const Light& light, std::span<const Receiver>)
    : scene_(scene), light_(light) {}

EmbreeScene::SeenCount Occlusion::seen(const Receiver& receiver, const SamplePoints& points, SeenBits seen) const {
    if (light_.type != LightType::Directional) return scene_.seen_samples(receiver, points.x, points.y, points.z, seen);
    const bool lit = scene_.visible_direction(receiver, -light_.direction);
    seen[0] = lit;
    return {lit ? std::size_t{1} : std::size_t{0}, 1};
}

} // namespace gnomon
