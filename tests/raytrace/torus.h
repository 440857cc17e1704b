#pragma once
// Fine surfaces, and receivers and lights around them, for the tests of silhouettes.

#include <cmath>
#include <vector>

#include "tests/raytrace/witness.h"

namespace gnomon_tests {

inline constexpr float turn = 6.2831853f;

// A closed bumpy torus, or a part of it: quads [0, end) of `around`, each two triangles. Counter-clockwise from outside
// but for every `flipped`-th quad.
struct TorusShape {
    vec3 center{0, 1.2f, 0};
    float radius = 0.7f, tube = 0.3f, bump = 0.02f;
    int around = 64, across = 32, end = 64, flipped = 0;
};

inline void add_torus(Scene& scene, const TorusShape& shape) {
    const auto point = [&](int i, int j) {
        const float a = turn * static_cast<float>(i % shape.around) / static_cast<float>(shape.around);
        const float b = turn * static_cast<float>(j % shape.across) / static_cast<float>(shape.across);
        const float tube = shape.tube + shape.bump * std::sin(5 * a) * std::cos(3 * b);
        const float out = shape.radius + tube * std::cos(b);
        return shape.center + vec3(out * std::cos(a), out * std::sin(a), tube * std::sin(b));
    };
    for (int i = 0; i < shape.end; ++i)
        for (int j = 0; j < shape.across; ++j) {
            const vec3 p[4] = {point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)};
            const bool flip = shape.flipped > 0 && (i * shape.across + j) % shape.flipped == 0;
            add_polygon(scene, flip ? std::vector<vec3>{p[0], p[2], p[1]} : std::vector<vec3>{p[0], p[1], p[2]});
            add_polygon(scene, flip ? std::vector<vec3>{p[0], p[3], p[2]} : std::vector<vec3>{p[0], p[2], p[3]});
        }
}

// A block of receivers that are near each other on the floor, which is the first two triangles of a scene.
inline std::vector<Receiver> floor_block(Numbers& numbers, float spread, int count) {
    std::vector<Receiver> block;
    const vec3 middle = numbers.in_box(3.0f);
    for (int i = 0; i < count; ++i) {
        const vec3 at = middle + numbers.in_box(spread);
        block.push_back({{at.x, 0, at.z}, {0, 1, 0}, at.x > at.z ? 1u : 0u});
    }
    return block;
}

inline Light lamp(Numbers& numbers, LightType type, float size) {
    Light light = light_at(type, vec3(2, 4, 1) + numbers.in_box(2.0f), vec2(size, size));
    light.direction = glm::normalize(vec3(0, 1, 0) - light.position);
    light.tangent = any_tangent(light.direction);
    return light;
}

inline Scene on_floor() {
    Scene scene;
    add_floor(scene, -9, 9, -9, 9, 0);
    return scene;
}

} // namespace gnomon_tests
