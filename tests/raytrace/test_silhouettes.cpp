// Silhouettes let one ray answer for many; wherever a surface ends, folds or turns over, the answer is that of all
// rays.

#include <catch2/catch.hpp>

#include "raytrace/neighbours.h"
#include "tests/raytrace/torus.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

void place(Scene& scene, Light& light, float scale, vec3 shift) {
    for (vec3& p : scene.positions) p = p * scale + shift;
    light.position = light.position * scale + shift;
    light.size *= scale;
}

void place(std::vector<Receiver>& block, float scale, vec3 shift) {
    for (Receiver& receiver : block) receiver.position = receiver.position * scale + shift;
}

// Receivers on the floor and on the surface.
Comparison compare(const Scene& scene, const Light& light, Numbers& numbers, int blocks, int samples = 256) {
    Comparison comparison;
    const Witness witness(scene, light, Pattern::Sobol, samples);
    for (int i = 0; i < blocks; ++i) {
        witness.compare(floor_block(numbers, 0.1f, 16), comparison);
        witness.compare(random_receivers(scene, numbers, 16), comparison);
    }
    return comparison;
}

std::size_t open_edges(const TriangleClusters& clusters) {
    std::size_t open = 0;
    for (std::size_t c = 0; c < clusters.clusters.size(); ++c)
        for (const auto& over : clusters.neighbours[c].over)
            for (std::uint32_t i = 0; i < clusters.clusters[c].count; ++i) open += over[i] == no_neighbour;
    return open;
}

} // namespace

TEST_CASE("neighbours are found by position and direction", "[raytrace][silhouettes]") {
    Scene closed, part, twice;
    add_torus(closed, {});
    TorusShape half;
    half.end = 32;
    add_torus(part, half);
    add_torus(twice, {});
    add_torus(twice, {});
    CHECK(open_edges(build_clusters(closed)) == 0);
    CHECK(open_edges(build_clusters(part)) == 2 * 32);
    // Four triangles at every edge.
    CHECK(open_edges(build_clusters(twice)) == 3 * twice.triangles.size());
    TorusShape flipped;
    flipped.flipped = 64 * 32; // one quad, whose four sides its neighbours have in the same direction
    Scene turned;
    add_torus(turned, flipped);
    CHECK(open_edges(build_clusters(turned)) == 8);
    const TriangleClusters clusters = build_clusters(closed);
    for (std::uint32_t c = 0; c < clusters.clusters.size(); ++c)
        for (const auto& over : clusters.neighbours[c].over)
            for (std::uint32_t i = 0; i < clusters.clusters[c].count; ++i) {
                const auto& back = clusters.neighbours[over[i] / cluster_size].over;
                const auto place = static_cast<std::uint32_t>(over[i] % cluster_size);
                const std::uint32_t self = c * std::uint32_t(cluster_size) + i;
                CHECK((back[0][place] == self || back[1][place] == self || back[2][place] == self));
            }
}

// A block that looks at a finely tessellated surface: of some 260'000 rays some tens of thousands are left.
TEST_CASE("rays are saved beside a fine closed surface", "[raytrace][silhouettes]") {
    Numbers numbers(31);
    Scene scene = on_floor();
    add_sphere(scene, {0, 1.5f, 0}, 0.8f, 64);
    Light light = light_at(LightType::Rectangle, {0.5f, 4, 0.25f}, {2, 2});
    const Comparison comparison = [&] {
        Comparison all;
        const Witness witness(scene, light, Pattern::Sobol, 1024);
        for (int i = 0; i < 24; ++i) witness.compare(floor_block(numbers, 0.05f, 16), all);
        return all;
    }();
    INFO(comparison.rays << " of " << comparison.rays_alone << " rays");
    CHECK(comparison.wrong == 0);
    CHECK(comparison.rays > 0);
    CHECK(5 * comparison.rays < comparison.rays_alone);
}

// A fine plate whose rim is straight above the receivers, and a grid of samples whose middle column is above the rim:
// those rays meet the rim exactly, from either side, or the corners and edges of the triangles at it.
TEST_CASE("samples exactly at an edge are as rays have them", "[raytrace][silhouettes]") {
    for (const float side : {1.0f, -1.0f}) {
        Scene scene = on_floor();
        constexpr int cells = 64;
        const auto corner = [&](int i, int j) {
            return vec3(0.5f + side * static_cast<float>(i) / 16, 2, static_cast<float>(j) / 16 - 2);
        };
        for (int i = 0; i < cells; ++i)
            for (int j = 0; j < cells; ++j) {
                add_polygon(scene, {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
                add_polygon(scene, {corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
            }
        Light light = light_at(LightType::Rectangle, {0.5f, 4, 0}, {6, 6});
        light.direction = {0, -1, 0}, light.tangent = {1, 0, 0};
        const Witness witness(scene, light, Pattern::Grid, 31 * 31);
        Comparison comparison;
        for (int k = -4; k < 4; ++k) {
            std::vector<Receiver> block;
            for (int i = 0; i < 8; ++i) {
                const float z = static_cast<float>(k) / 4 + static_cast<float>(i) / 64;
                block.push_back({{0.5f, 0, z}, {0, 1, 0}, 0.5f > z ? 1u : 0u});
            }
            witness.compare(block, comparison);
        }
        INFO("side " << side << ": " << comparison.rays << " of " << comparison.rays_alone << " rays");
        CHECK(comparison.wrong == 0);
        CHECK(3 * comparison.rays < comparison.rays_alone);
    }
}

TEST_CASE("silhouettes give the bits of rays alone for closed surfaces", "[raytrace][silhouettes]") {
    for (const LightType type : {LightType::Rectangle, LightType::Disk, LightType::Sphere}) {
        Numbers numbers(41u + static_cast<std::uint32_t>(type));
        Scene scene = on_floor();
        add_torus(scene, {});
        for (const float size : {0.3f, 1.5f, 5.0f}) {
            const Comparison comparison = compare(scene, lamp(numbers, type, size), numbers, 12);
            INFO(light_type_name(type) << ", size " << size);
            CHECK(comparison.wrong == 0);
            CHECK(comparison.rays < comparison.rays_alone);
        }
    }
}

TEST_CASE("silhouettes give the bits of rays alone where surfaces end or turn over", "[raytrace][silhouettes]") {
    TorusShape part, flipped, mixed, inside;
    part.end = 40;
    flipped.flipped = 97;
    mixed.flipped = 11, mixed.end = 60;
    inside.center = {0.4f, 1.1f, 0.1f}, inside.radius = 0.6f; // passes through another
    const std::vector<std::vector<TorusShape>> scenes = {{part},       {flipped}, {mixed},
                                                         {{}, inside}, {{}, {}},  {part, {}}};
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        Numbers numbers(51u + static_cast<std::uint32_t>(i));
        Scene scene = on_floor();
        for (const TorusShape& shape : scenes[i]) add_torus(scene, shape);
        INFO("scene " << i);
        CHECK(compare(scene, lamp(numbers, LightType::Rectangle, 2.0f), numbers, 16).wrong == 0);
    }
}

// Light falls through the hole only.
TEST_CASE("light through a hole in a sphere is found", "[raytrace][silhouettes]") {
    Scene scene;
    add_sphere(scene, {0, 0, 0}, 1, 48);
    scene.triangles.erase(scene.triangles.begin() + 2000, scene.triangles.begin() + 2024);
    scene.triangle_objects.pop_back();
    scene.triangle_objects.resize(scene.triangles.size());
    const vec3 hole = scene.positions[scene.triangles[1990].x];
    Light light = light_at(LightType::Rectangle, hole * 2.0f, {1, 1});
    light.direction = -glm::normalize(hole);
    light.tangent = any_tangent(light.direction);
    Numbers numbers(61);
    Comparison comparison;
    const Witness witness(scene, light, Pattern::Sobol, 256);
    for (int i = 0; i < 60; ++i) {
        std::vector<Receiver> block = random_receivers(scene, numbers, 16);
        for (Receiver& receiver : block)
            if (glm::dot(receiver.geometric_normal, receiver.position) > 0) receiver.geometric_normal *= -1.0f;
        witness.compare(block, comparison);
    }
    CHECK(comparison.wrong == 0);
    CHECK(comparison.rays < comparison.rays_alone);
}

TEST_CASE("silhouettes give the bits of rays alone at every scale and far away", "[raytrace][silhouettes]") {
    struct Placement {
        float scale;
        vec3 shift;
    };
    for (const Placement& placement :
         {Placement{1e-3f, vec3(0)}, Placement{1e6f, vec3(0)}, Placement{1, vec3(100, -30, 7)},
          Placement{100, vec3(1e5f)}, Placement{1, vec3(1e5f, 0, -1e5f)}}) {
        Numbers numbers(71);
        Scene scene = on_floor();
        add_torus(scene, {});
        Light light = lamp(numbers, LightType::Rectangle, 1.5f);
        place(scene, light, placement.scale, placement.shift);
        Comparison comparison;
        const Witness witness(scene, light, Pattern::Sobol, 256);
        for (int i = 0; i < 16; ++i) {
            std::vector<Receiver> block = floor_block(numbers, 0.1f, 16);
            place(block, placement.scale, placement.shift);
            witness.compare(block, comparison);
            witness.compare(random_receivers(scene, numbers, 16), comparison);
        }
        INFO("scale " << placement.scale << ", shift " << placement.shift.x);
        CHECK(comparison.wrong == 0);
    }
}

namespace {

// Tori of any kind, sphere and soup, lights of any kind and place, receivers everywhere.
void check_everything(std::uint32_t seed, int rounds) {
    Numbers numbers(seed);
    Comparison comparison;
    for (int round = 0; round < rounds; ++round) {
        Scene scene = on_floor();
        const int objects = 1 + numbers.below(3);
        for (int i = 0; i < objects; ++i) {
            TorusShape shape;
            shape.center = vec3(0, 1.2f, 0) + numbers.in_box(1.5f);
            shape.radius = 0.3f + 0.6f * numbers.unit(), shape.tube = 0.05f + 0.4f * numbers.unit();
            shape.bump = numbers.unit() < 0.5f ? 0.0f : 0.1f * numbers.unit() * shape.tube;
            shape.around = 8 + numbers.below(70), shape.across = 6 + numbers.below(40);
            shape.end = numbers.unit() < 0.6f ? shape.around : 1 + numbers.below(shape.around);
            shape.flipped = numbers.unit() < 0.7f ? 0 : 1 + numbers.below(200);
            add_torus(scene, shape);
        }
        if (numbers.unit() < 0.3f)
            add_sphere(scene, numbers.in_box(2.0f), 0.1f + numbers.unit(), 10 + numbers.below(40));
        const LightType types[] = {LightType::Rectangle, LightType::Disk, LightType::Sphere, LightType::Rectangle};
        Light light = random_light(numbers, types[numbers.below(4)], 1.0f, vec3(0));
        if (numbers.unit() < 0.7f) light.position.y = 1.0f + 4.0f * numbers.unit();
        const Comparison found = compare(scene, light, numbers, 4, 16 + numbers.below(1100));
        comparison.wrong += found.wrong, comparison.receivers += found.receivers;
        comparison.rays += found.rays, comparison.rays_alone += found.rays_alone;
    }
    INFO("seed " << seed << ": " << comparison.rays << " of " << comparison.rays_alone << " rays");
    CHECK(comparison.wrong == 0);
    CHECK(comparison.rays < comparison.rays_alone);
}

} // namespace

TEST_CASE("silhouettes give the bits of rays alone for any surface, light and receiver", "[raytrace][silhouettes]") {
    for (const std::uint32_t seed : {101u, 102u}) check_everything(seed, 20);
}

TEST_CASE("a soak of silhouettes", "[raytrace][silhouettes][.long]") {
    for (std::uint32_t seed = 1001; seed < 1041; ++seed) check_everything(seed, 60);
}
