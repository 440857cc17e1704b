#include <catch2/catch.hpp>

#include <cmath>

#include "tests/raytrace/witness.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

void check_soups(std::uint32_t seed, float scale, vec3 offset, bool lattice) {
    Numbers numbers(seed);
    Comparison comparison;
    for (int round = 0; round < 12; ++round) {
        Scene scene;
        const int triangles = 1 + numbers.below(round % 3 == 0 ? 4 : 400);
        const float size = triangles < 5 ? 4.0f : 0.05f + 2.0f * numbers.unit();
        for (int i = 0; i < triangles; ++i) {
            const vec3 center = numbers.in_box(4.0f);
            std::vector<vec3> corners;
            for (int k = 0; k < 3; ++k) {
                vec3 corner = center + numbers.in_box(size);
                if (i % 7 == 0 && k == 2) corner = 0.5f * (corners[0] + corners[1]) + numbers.in_box(1e-3f); // sliver
                if (lattice) corner = glm::round(corner * 2.0f) * 0.5f;
                corners.push_back(corner * scale + offset);
            }
            if (glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0])) > 0.0f)
                add_polygon(scene, corners);
        }
        if (scene.triangles.empty()) continue;
        for (const LightType type : {LightType::Rectangle, LightType::Disk, LightType::Sphere}) {
            Light light = random_light(numbers, type, scale, offset);
            if (lattice && type == LightType::Rectangle) {
                light.position = glm::round(numbers.in_box(4.0f) * 2.0f) * (0.5f * scale) + offset;
                light.direction = vec3(0.0f);
                light.direction[numbers.below(3)] = numbers.unit() < 0.5f ? 1.0f : -1.0f;
                light.tangent = any_tangent(light.direction);
                light.size = vec2(scale);
            }
            const Witness witness(scene, light, Pattern::Sobol, 16 + numbers.below(300));
            for (int block = 0; block < 6; ++block) witness.compare(random_receivers(scene, numbers, 24), comparison);
        }
    }
    INFO("seed " << seed << ", scale " << scale << ", offset " << offset.x << ", lattice " << lattice);
    INFO(comparison.rays << " of " << comparison.rays_alone << " rays, " << comparison.proven << " of "
                         << comparison.receivers << " receivers proven");
    CHECK(comparison.wrong == 0);
    CHECK(comparison.receivers > 2000);
    CHECK(comparison.proven > 0);
}

} // namespace

TEST_CASE("proofs and rays give the bits of rays alone on builtin scenes", "[raytrace][occlusion]") {
    for (const char* name : {"default", "fence", "stacked-plates", "staircase", "cornell", "wire-ball", "tree"}) {
        const Scene scene = load_scene(std::string("builtin:") + name);
        const Light& light = scene.lights.front();
        INFO(name);
        REQUIRE(is_area(light));
        const Comparison comparison = compare_image(scene, light, Pattern::Sobol, 256, 96, 54);
        CHECK(comparison.wrong == 0);
        CHECK(2 * comparison.rays < comparison.rays_alone);
    }
}

TEST_CASE("proofs give the bits of rays alone for every light and pattern", "[raytrace][occlusion]") {
    const Scene scene = load_scene("builtin:default");
    for (const LightType type :
         {LightType::Rectangle, LightType::Disk, LightType::Sphere, LightType::Point, LightType::Directional})
        for (const Pattern pattern : {Pattern::Sobol, Pattern::Stratified, Pattern::Grid, Pattern::Random}) {
            Light light = scene.lights.front();
            light.type = type;
            const int samples = is_area(light) ? 100 : 1;
            const Comparison comparison = compare_image(scene, light, pattern, samples, 64, 36);
            INFO(light_type_name(type) << ", pattern " << static_cast<int>(pattern));
            CHECK(comparison.wrong == 0);
            CHECK((is_area(light) ? 2 * comparison.rays < comparison.rays_alone : comparison.rays > 0));
        }
}

// More samples than a block of packets holds, and lights that surround or nearly touch what they light.
TEST_CASE("proofs give the bits of rays alone for many samples and huge lights", "[raytrace][occlusion]") {
    const Scene scene = load_scene("builtin:fence");
    for (const float size : {0.01f, 3.0f, 40.0f})
        for (const int samples : {1, 15, 2500}) {
            Light light = scene.lights.front();
            light.size = vec2(size);
            INFO(size << " m, " << samples << " samples");
            CHECK(compare_image(scene, light, Pattern::Sobol, samples, 32, 18).wrong == 0);
        }
}

TEST_CASE("proofs give the bits of rays alone in random soups", "[raytrace][occlusion]") {
    for (const std::uint32_t seed : {1u, 2u, 3u}) check_soups(seed, 1.0f, vec3(0.0f), false);
    check_soups(4, 1e-3f, vec3(0.0f), false);
    check_soups(5, 1e6f, vec3(0.0f), false);
    check_soups(6, 1.0f, vec3(100.0f, -30.0f, 7.0f), false);
}

// Corners, receivers and lights on the same planes and lines: rays in the planes of triangles, along edges, through
// corners, and lights flush with triangles.
TEST_CASE("proofs give the bits of rays alone where everything is aligned", "[raytrace][occlusion]") {
    for (const std::uint32_t seed : {11u, 12u, 13u}) check_soups(seed, 1.0f, vec3(0.0f), true);
    check_soups(14, 1.0f, vec3(64.0f, 64.0f, 64.0f), true);
}

TEST_CASE("proofs give the bits of rays alone far from the origin", "[raytrace][occlusion]") {
    Numbers numbers(21);
    Comparison comparison;
    Scene scene;
    const vec3 offset(1e5f, -1e5f, 1e5f);
    add_floor(scene, offset.x - 400, offset.x + 400, offset.z - 400, offset.z + 400, offset.y);
    for (int i = 0; i < 30; ++i) {
        const vec3 corner = offset + numbers.in_box(300.0f) * vec3(1, 0, 1) + vec3(0, 20, 0);
        add_box(scene, corner, corner + vec3(40, 60, 50));
    }
    const Light light = random_light(numbers, LightType::Rectangle, 60.0f, offset + vec3(0, 300, 0));
    const Witness witness(scene, light, Pattern::Sobol, 64);
    for (int block = 0; block < 100; ++block) witness.compare(random_receivers(scene, numbers, 24), comparison);
    CHECK(comparison.wrong == 0);
    CHECK(comparison.proven > 100);
}

TEST_CASE("an open floor, a roof and a flush ceiling need no rays", "[raytrace][occlusion]") {
    Scene open, roof, flush;
    for (Scene* scene : {&open, &roof, &flush}) add_floor(*scene, -9, 9, -9, 9, 0);
    add_floor(roof, -64, 64, -64, 64, 2);
    add_floor(flush, -9, 9, -9, 9, 4);
    const Light light = light_at(LightType::Rectangle, {0, 4, 0}, {2, 2});
    for (const Scene* scene : {&open, &roof, &flush}) {
        Comparison comparison;
        const Witness witness(*scene, light, Pattern::Sobol, 256);
        for (int i = 0; i < 50; ++i) {
            const float x = 8 * to_unit(hash(std::uint32_t(i), 1)) - 4, z = 8 * to_unit(hash(std::uint32_t(i), 2)) - 4;
            witness.compare({{{x, 0, z}, {0, 1, 0}, x > z ? 1u : 0u}}, comparison);
        }
        INFO((scene == &open ? "open" : scene == &roof ? "roof" : "flush"));
        CHECK(comparison.wrong == 0);
        // Neither of the roof's two triangles hides the light from everywhere, but together they do.
        CHECK((scene == &roof || comparison.proven == comparison.receivers));
        CHECK(comparison.rays == 0);
    }
}
