#include <catch2/catch.hpp>

#include <cmath>

#include "core/parallel.h"
#include "core/random.h"
#include "raytrace/embree_scene.h"
#include "tests/raytrace/shapes.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

bool sees(const EmbreeScene& rays, const Receiver& receiver, vec3 target) {
    std::uint8_t seen = 2;
    rays.visible(receiver, {&target, 1}, {&seen, 1});
    REQUIRE(seen <= 1);
    return seen == 1;
}

// Receivers spread over a triangle, its edges and corners' neighbourhood included.
std::vector<Receiver> receivers_over(const Scene& scene, std::uint32_t triangle, int count) {
    std::vector<Receiver> receivers;
    for (int i = 0; i < count; ++i) {
        float a = to_unit(hash(triangle, std::uint32_t(i), 1)), b = to_unit(hash(triangle, std::uint32_t(i), 2));
        if (a + b > 1.0f) a = 1.0f - a, b = 1.0f - b;
        if (i % 4 == 0) b = 0.0f; // on an edge shared with a neighbour
        receivers.push_back(receiver_at(scene, triangle, a, b));
    }
    return receivers;
}

} // namespace

// A convex body shadows itself nowhere but beyond the terminator, so whatever faces the light sees it, exactly.
TEST_CASE("a convex body sees every light that its triangles face", "[raytrace][self-hit]") {
    for (const float scale : {1e-3f, 1.0f, 37.0f, 1e3f, 1e6f})
        for (const vec3 offset : {vec3(0.0f), vec3(100.0f, -3.0f, 40.0f)}) {
            Scene scene;
            add_sphere(scene, offset * scale, scale, 32);
            const EmbreeScene rays(scene);
            int wrong = 0, facing = 0;
            for (std::uint32_t t = 0; t < scene.triangles.size(); ++t)
                for (const Receiver& receiver : receivers_over(scene, t, 8)) {
                    const vec3 light = (offset + vec3(3, 4, 2)) * scale;
                    // Vertices of a far body are rounded, so that it is convex but for the rounding: 2⁻²⁴ of the offset
                    // over edges of 0.1 tilts its faces by some 1e-4, and receivers within that of the terminator prove
                    // nothing.
                    const vec3 way = glm::normalize(light - receiver.position);
                    if (offset != vec3(0.0f) && std::abs(glm::dot(way, receiver.geometric_normal)) < 1e-3f) continue;
                    const bool lit = faces(receiver, light);
                    facing += lit;
                    wrong += sees(rays, receiver, light) != lit;
                }
            INFO("scale " << scale << ", offset " << offset.x << ", facing " << facing);
            CHECK(facing > 1000);
            CHECK(wrong == 0);
        }
}

TEST_CASE("a large inclined plane does not shadow itself", "[raytrace][self-hit]") {
    for (const float scale : {1e-3f, 1.0f, 1e6f}) {
        Scene scene;
        const vec3 a = vec3(-3, 1, -2) * scale, u = vec3(5, 0.7f, 0.3f) * scale, v = vec3(-0.4f, 0.9f, 6) * scale;
        add_polygon(scene, {a, a + v, a + v + u, a + u});
        const EmbreeScene rays(scene);
        const vec3 n = normal_of(scene, 0);
        int dark = 0;
        for (std::uint32_t t = 0; t < 2; ++t)
            for (const Receiver& receiver : receivers_over(scene, t, 2000))
                for (const float height : {1e-4f, 0.01f, 10.0f}) {
                    const vec3 light = a + u * 0.4f + v * 0.6f + n * (height * scale);
                    dark += faces(receiver, light) && !sees(rays, receiver, light);
                    dark += !rays.visible_direction({receiver.position, n, t}, n);
                }
        CHECK(dark == 0);
    }
}

TEST_CASE("slivers do not shadow themselves", "[raytrace][self-hit]") {
    // 1 m long and a tenth of a millimetre to a micrometre wide, inclined: their planes are known badly in float.
    for (const float width : {1e-4f, 1e-5f, 1e-6f}) {
        Scene scene;
        add_polygon(scene, {{0, 0, 0}, {1.0f, 0.31f, 0.13f}, {0.5f, 0.155f + width, 0.065f - 0.3f * width}});
        const EmbreeScene rays(scene);
        int dark = 0;
        for (Receiver receiver : receivers_over(scene, 0, 500)) {
            dark += !sees(rays, receiver, receiver.position + receiver.geometric_normal * 2.0f + vec3(0.1f, 0, 0.1f));
            receiver.geometric_normal = -receiver.geometric_normal;
            dark += !sees(rays, receiver, receiver.position + receiver.geometric_normal * 2.0f);
        }
        INFO("width " << width);
        CHECK(dark == 0);
    }
}

TEST_CASE("the terminator of a sphere is the geometric rule", "[raytrace]") {
    Scene scene;
    add_sphere(scene, {0, 0, 0}, 1, 48);
    const EmbreeScene rays(scene);
    const vec3 way = glm::normalize(vec3(0.3f, 0.8f, 0.2f));
    int wrong = 0;
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
        const Receiver receiver = receiver_at(scene, t, 0.3f, 0.3f);
        wrong += rays.visible_direction(receiver, way) != (glm::dot(receiver.geometric_normal, way) > 0.0f);
    }
    CHECK(wrong == 0);
}

TEST_CASE("geometry that touches the light point from behind does not hide it", "[raytrace]") {
    Scene scene;
    add_floor(scene, -9, 9, -9, 9, 0);
    add_floor(scene, -9, 9, -9, 9, 4.0f); // the ceiling in whose plane the light lies
    const EmbreeScene rays(scene);
    for (int i = 0; i < 200; ++i) {
        const float x = 16 * to_unit(hash(std::uint32_t(i), 1)) - 8;
        const Receiver receiver{{x, 0, 2}, {0, 1, 0}, 0};
        CHECK(sees(rays, receiver, {0.5f, 4.0f, 0.25f}));
        CHECK_FALSE(sees(rays, receiver, {0.5f, 4.001f, 0.25f}));
    }
}

// All three edge functions of such triangles are rounding errors, and Embree takes their signs for what they are.
TEST_CASE("triangles beside a ray do not hide its target when their plane holds the ray", "[raytrace]") {
    std::uint32_t next = 0;
    const auto number = [&] { return double(to_unit(hash(17u, next++))); };
    int hidden = 0;
    for (int scenes = 0; scenes < 200; ++scenes) {
        const dvec3 along(1, 0, 0), across = glm::normalize(dvec3(0, 0.1 + number(), 0.1 + number()));
        const dvec3 corner(number(), number(), number());
        Scene scene;
        add_floor(scene, -1, 1, -1, 1, -50);
        // Two on either side of the ray: Embree's boxes hold both.
        for (const double side : {-1.0, -1.0, 1.0, 1.0}) {
            const double x = 4 + number();
            std::vector<vec3> corners;
            for (int k = 0; k < 3; ++k)
                corners.push_back(vec3(corner + along * (x + number()) + across * side * (0.05 + 0.3 * number())));
            add_polygon(scene, corners);
        }
        const EmbreeScene rays(scene);
        for (int i = 0; i < 50; ++i) {
            const vec3 start(corner - along + across * (0.02 * number() - 0.01));
            const vec3 target(corner + along * 10.0 + across * (0.02 * number() - 0.01));
            hidden += !sees(rays, {start, vec3(along), 0}, target);
        }
    }
    CHECK(hidden == 0);
}

TEST_CASE("light sources are seen by camera rays and cast no shadow", "[raytrace]") {
    for (const bool light_source : {false, true}) {
        Scene scene;
        add_floor(scene, -1, 1, -1, 1, 2, light_source); // comes first: primitive numbers differ from triangle numbers
        add_floor(scene, -9, 9, -9, 9, 0);
        add_floor(scene, 3, 4, -1, 1, 1);
        const EmbreeScene rays(scene);
        const Receiver below{{0.1f, 0, 0.2f}, {0, 1, 0}, 2}, beside{{3.5f, 0, 0.2f}, {0, 1, 0}, 3};
        CHECK(sees(rays, below, {0.1f, 5, 0.2f}) == light_source);
        CHECK(rays.visible_direction(below, {0, 1, 0}) == light_source);
        CHECK_FALSE(sees(rays, beside, {3.5f, 5, 0.2f}));
        const EmbreeScene::Hit down = rays.first_hit({0.1f, 5, 0.2f}, {0, -1, 0}, 0, infinity);
        CHECK(down.triangle < 2);
        CHECK(down.distance == 3.0f);
        CHECK(rays.first_hit({3.5f, 5, 0.2f}, {0, -1, 0}, 0, infinity).triangle >= 4);
        CHECK(rays.first_hit({0.1f, 5, 0.2f}, {0, -1, 0}, 3.5f, infinity).distance == 5.0f);
        CHECK(rays.first_hit({0.1f, 5, 0.2f}, {0, -1, 0}, 0, 2.5f).triangle == no_triangle);
    }
}

TEST_CASE("a camera ray through a shared edge meets the lower index", "[raytrace]") {
    for (const bool swapped : {false, true}) {
        Scene scene;
        add_floor(scene, -1, 1, -1, 1, 0); // diagonal from (−1,−1) to (1,1)
        if (swapped) std::swap(scene.triangles[0], scene.triangles[1]);
        const EmbreeScene rays(scene);
        for (int i = -9; i <= 9; ++i) {
            const float d = static_cast<float>(i) / 10;
            CHECK(rays.first_hit({d, 1, d}, {0, -1, 0}, 0, infinity).triangle == 0);
        }
    }
}

TEST_CASE("up to sixteen targets are answered one by one", "[raytrace]") {
    Scene scene;
    add_floor(scene, -9, 9, -9, 9, 0);
    add_floor(scene, -9, 0, -9, 9, 1);
    const EmbreeScene rays(scene);
    const Receiver receiver{{0, 0, 0}, {0, 1, 0}, 0};
    std::vector<float> x, y, z;
    std::vector<vec3> targets;
    for (int i = 0; i < 37; ++i) {
        targets.push_back({to_unit(hash(std::uint32_t(i))) - 0.5f, i % 5 == 0 ? -1.0f : 2.0f, 0.3f});
        x.push_back(targets.back().x), y.push_back(targets.back().y), z.push_back(targets.back().z);
    }
    size_t expected = 0;
    for (const vec3 target : targets) {
        CHECK(sees(rays, receiver, target) == (target.y > 0 && target.x > 0));
        expected += target.y > 0 && target.x > 0;
    }
    std::vector<std::uint16_t> bits(3, 0xffff);
    const EmbreeScene::SeenCount count = rays.seen_samples(receiver, x, y, z, bits);
    CHECK(count.seen == expected);
    CHECK(count.rays == std::count_if(targets.begin(), targets.end(), [](vec3 target) { return target.y > 0; }));
    for (size_t i = 0; i < 48; ++i)
        CHECK((bits[i / 16] >> i % 16 & 1) == (i < targets.size() && targets[i].y > 0 && targets[i].x > 0));
    for (size_t asked = 0; asked <= 16; ++asked) {
        std::vector<std::uint8_t> seen(16, 9);
        rays.visible(receiver, {targets.data(), asked}, seen);
        for (size_t i = 0; i < 16; ++i) CHECK(int(seen[i]) == (i >= asked ? 9 : targets[i].y > 0 && targets[i].x > 0));
    }
}

TEST_CASE("a scene without triangles hides nothing", "[raytrace]") {
    const Scene scene;
    const EmbreeScene rays(scene);
    CHECK(rays.first_hit({0, 0, 0}, {0, 0, 1}, 0, infinity).triangle == no_triangle);
}

TEST_CASE("memory is accounted for", "[raytrace]") {
    Scene scene;
    add_sphere(scene, {0, 0, 0}, 1, 32);
    const EmbreeScene rays(scene);
    CHECK(rays.memory_bytes() > scene.triangles.size() * sizeof(uvec3));
}
