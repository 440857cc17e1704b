#pragma once
// Holds proofs about light samples to rays alone, receiver by receiver and bit by bit.

#include <vector>

#include "core/parallel.h"
#include "core/random.h"
#include "raytrace/occlusion.h"
#include "raytrace/pattern.h"
#include "techniques/frame.h"
#include "tests/raytrace/shapes.h"

namespace gnomon_tests {

// What proofs and rays together answer beside what rays alone do.
struct Comparison {
    long receivers = 0, wrong = 0, rays = 0, rays_alone = 0, proven = 0;
};

class Witness {
public:
    Witness(const Scene& scene, const Light& light, Pattern pattern, int samples)
        : rays_(scene), clusters_(build_clusters(scene)), light_(light),
          pattern_(prepare_pattern(pattern, samples, SampleOrder::Packed)) {}

    void compare(const std::vector<Receiver>& block, Comparison& to) const {
        const size_t count = pattern_.size();
        std::vector<float> u(count), v(count), x(count), y(count), z(count);
        std::vector<std::uint16_t> seen(seen_words(count)), expected(seen_words(count));
        const FloatModeScope mode(FloatMode::FlushZero);
        Occlusion shortcuts(rays_, light_, block, count, &clusters_), all(rays_, light_, block, count, nullptr);
        for (const Receiver& receiver : block) {
            if (!receiver.valid()) continue;
            fill_pattern(pattern_, static_cast<std::uint32_t>(to.receivers++), 3, u, v);
            light_points(light_, receiver.position, u, v, x, y, z);
            const auto alone = all.seen(receiver, {x, y, z}, expected);
            const Occlusion::Proof proof = shortcuts.prove(receiver);
            const auto answer = shortcuts.seen(receiver, {x, y, z}, seen);
            to.wrong += seen != expected || answer.seen != alone.seen;
            to.wrong += proof == Occlusion::Proof::AllSeen && alone.seen != count;
            to.wrong += proof == Occlusion::Proof::NoneSeen && alone.seen != 0;
            to.proven += proof != Occlusion::Proof::None;
            to.rays += static_cast<long>(answer.rays), to.rays_alone += static_cast<long>(alone.rays);
        }
    }

private:
    EmbreeScene rays_;
    TriangleClusters clusters_;
    const Light& light_;
    PreparedPattern pattern_;
};

// The receivers of a small image, in blocks of 8×8 pixels.
inline Comparison compare_image(const Scene& scene, const Light& light, Pattern pattern, int samples, int width,
                                int height) {
    Frame frame(scene, scene.cameras.front(), width, height);
    const Witness witness(scene, light, pattern, samples);
    Comparison comparison;
    for (int bottom = 0; bottom < height; bottom += 8)
        for (int left = 0; left < width; left += 8) {
            std::vector<Receiver> block;
            for (int y = bottom; y < std::min(bottom + 8, height); ++y)
                for (int x = left; x < std::min(left + 8, width); ++x) block.push_back(frame.receivers()(x, y));
            witness.compare(block, comparison);
        }
    return comparison;
}

class Numbers {
public:
    explicit Numbers(std::uint32_t seed) : seed_(seed) {}
    float unit() { return to_unit(hash(seed_, next_++)); }
    int below(int end) { return static_cast<int>(unit() * static_cast<float>(end)); }
    vec3 in_box(float size) { return (vec3(unit(), unit(), unit()) - 0.5f) * size; }
    vec3 direction() {
        for (;;)
            if (const vec3 v = in_box(2.0f); glm::dot(v, v) < 1.0f && glm::dot(v, v) > 0.01f) return glm::normalize(v);
    }

private:
    std::uint32_t seed_, next_ = 0;
};

inline Light random_light(Numbers& numbers, LightType type, float scale, vec3 offset) {
    Light light;
    light.type = type;
    light.position = numbers.in_box(4.0f) * scale + offset;
    light.direction = numbers.direction();
    light.tangent = any_tangent(light.direction);
    light.size = vec2(0.02f + 2.0f * numbers.unit() * numbers.unit()) * scale;
    if (type == LightType::Rectangle) light.size.y *= 0.1f + numbers.unit();
    return light;
}

// Receivers near a point of a triangle, on it and on its neighbours in the list, seen from either side.
inline std::vector<Receiver> random_receivers(const Scene& scene, Numbers& numbers, int count) {
    std::vector<Receiver> receivers;
    const int first = numbers.below(static_cast<int>(scene.triangles.size()));
    for (int i = 0; i < count; ++i) {
        const auto t = static_cast<std::uint32_t>((first + i / 4) % static_cast<int>(scene.triangles.size()));
        float a = numbers.unit(), b = numbers.unit();
        if (a + b > 1.0f) a = 1.0f - a, b = 1.0f - b;
        Receiver receiver = receiver_at(scene, t, a, b);
        if (numbers.unit() < 0.5f) receiver.geometric_normal = -receiver.geometric_normal;
        if (glm::dot(receiver.geometric_normal, receiver.geometric_normal) > 0.5f) receivers.push_back(receiver);
    }
    return receivers;
}

} // namespace gnomon_tests
