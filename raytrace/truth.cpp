#include "raytrace/truth.h"

#include <vector>

#include "core/parallel.h"
#include "core/progress.h"
#include "raytrace/occlusion.h"

namespace gnomon {
namespace {

// Sample positions of one receiver and which of them it sees.
struct Targets {
    explicit Targets(size_t count) : u(count), v(count), x(count), y(count), z(count), seen(seen_words(count)) {}
    std::vector<float> u, v, x, y, z;
    std::vector<std::uint16_t> seen;
};

bool sees_center(const EmbreeScene& scene, const Receiver& receiver, const Light& light) {
    if (light.type == LightType::Directional) return scene.visible_direction(receiver, -light.direction);
    std::uint8_t seen = 0;
    scene.visible(receiver, {&light.position, 1}, {&seen, 1});
    return seen != 0;
}

} // namespace

Image<float> hard_visibility(const EmbreeScene& scene, const Receivers& receivers, const Light& light) {
    Image<float> visibility(receivers.width(), receivers.height(), 1.0f);
    const auto rows = [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (int x = 0; x < receivers.width(); ++x) {
                const Receiver& receiver = receivers(x, static_cast<int>(y));
                if (receiver.valid() && !sees_center(scene, receiver, light)) visibility(x, static_cast<int>(y)) = 0.0f;
            }
    };
    parallel_for(static_cast<size_t>(receivers.height()), 4, rows, FloatMode::FlushZero);
    return visibility;
}

Image<float> area_visibility(const EmbreeScene& scene, const Receivers& receivers, const Light& light, Pattern pattern,
                             int samples, std::uint32_t seed, Progress* progress) {
    if (!is_area(light)) {
        Image<float> visibility = hard_visibility(scene, receivers, light);
        if (progress) progress->advance(receivers.height());
        return visibility;
    }
    const PreparedPattern prepared = prepare_pattern(pattern, samples, SampleOrder::Packed);
    Image<float> visibility(receivers.width(), receivers.height(), 1.0f);
    const auto row = [&](size_t begin, size_t) {
        const int y = static_cast<int>(begin);
        Targets targets(prepared.size());
        const Occlusion occlusion(scene, light, receivers.row(y));
        for (int x = 0; x < receivers.width(); ++x) {
            const Receiver& receiver = receivers(x, y);
            if (!receiver.valid()) continue;
            fill_pattern(prepared, static_cast<std::uint32_t>(y * receivers.width() + x), seed, targets.u, targets.v);
            light_points(light, receiver.position, targets.u, targets.v, targets.x, targets.y, targets.z);
            const size_t seen = occlusion.seen(receiver, {targets.x, targets.y, targets.z}, targets.seen).seen;
            visibility(x, y) = static_cast<float>(seen) / static_cast<float>(samples);
        }
        if (progress) progress->advance();
    };
    parallel_for(static_cast<size_t>(receivers.height()), 1, row, FloatMode::FlushZero);
    return visibility;
}

} // namespace gnomon
