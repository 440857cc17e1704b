// No receiver hides itself and no light leaks, at any scale and far from the origin: an empty plane, a sphere and a
// closed box lit from inside and outside give exactly what they must.

#include <catch2/catch.hpp>

#include <algorithm>

#include "core/random.h"
#include "raytrace/exact.h"
#include "raytrace/truth.h"
#include "tests/raytrace/shapes.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

struct Placement {
    float scale;
    vec3 shift; // metres, added after scaling
};

// Far away only as far as float32 still has digits for the scene: at 10⁵ m it knows 8 mm.
const std::vector<Placement> placements = {
    {1e-3f, vec3(0)}, {1e-2f, vec3(0)},   {1, vec3(0)},       {1e3f, vec3(0)},           {1e6f, vec3(0)},
    {1, vec3(1e5f)},  {1e3f, vec3(1e5f)}, {1e6f, vec3(1e5f)}, {1, vec3(1e5f, 0, -1e5f)},
};

void place(Scene& scene, const Placement& placement) {
    for (vec3& p : scene.positions) p = p * placement.scale + placement.shift;
}

Light placed_light(LightType type, vec3 position, vec2 size, const Placement& placement) {
    return light_at(type, position * placement.scale + placement.shift, size * placement.scale);
}

// `count` receivers spread over the triangles by area of the index; one in eight at an edge, as near as float has it.
Receivers spread(const Scene& scene, std::uint32_t first, std::uint32_t triangles, int count, bool inside_out) {
    constexpr int width = 500;
    Receivers receivers(width, (count + width - 1) / width);
    for (std::uint32_t i = 0; i < receivers.size(); ++i) {
        const std::uint32_t triangle = first + hash(i, 7) % triangles;
        float a = to_unit(hash(i, 1)), b = to_unit(hash(i, 2));
        if (i % 8 == 0) a *= 1e-6f;
        if (a + b > 1.0f) a = 1.0f - a, b = 1.0f - b;
        Receiver receiver = receiver_at(scene, triangle, a, b);
        if (inside_out) receiver.geometric_normal = -receiver.geometric_normal;
        receivers.values()[i] = receiver;
    }
    return receivers;
}

// Takes out those that rounding has put on or behind another side of the box: they are not inside it.
void keep_inside(Receivers& receivers, const Placement& placement) {
    const vec3 low = vec3(-1) * placement.scale + placement.shift, high = vec3(1) * placement.scale + placement.shift;
    for (Receiver& receiver : receivers.values()) {
        const vec3 p = receiver.position + receiver.geometric_normal * (0.5f * placement.scale);
        const bool inside = glm::all(glm::greaterThan(p, low)) && glm::all(glm::lessThan(p, high));
        if (!inside) receiver = Receiver{};
    }
}

size_t count_unlike(const Receivers& receivers, const Image<float>& visibility, float expected) {
    size_t count = 0;
    for (size_t i = 0; i < receivers.size(); ++i)
        count += receivers.values()[i].valid() && visibility.values()[i] != expected;
    return count;
}

constexpr int receiver_count = 120'000; // at nine placements: more than 10⁶

} // namespace

TEST_CASE("an empty plane is lit exactly at every scale", "[raytrace][truth][self-hit]") {
    for (const Placement& placement : placements) {
        Scene scene;
        add_floor(scene, -8, 8, -8, 8, 0);
        place(scene, placement);
        const EmbreeScene rays(scene);
        const Receivers receivers = spread(scene, 0, 2, receiver_count, false);
        for (const LightType type : {LightType::Rectangle, LightType::Sphere}) {
            const Light light = placed_light(type, {1, 3, -2}, {2, 2}, placement);
            INFO("scale " << placement.scale << ", shift " << placement.shift.x);
            CHECK(count_unlike(receivers, area_visibility(rays, receivers, light, Pattern::Sobol, 4, 0, nullptr),
                               1.0f) == 0);
        }
    }
}

TEST_CASE("a sphere is lit up to its terminator exactly at every scale", "[raytrace][truth][self-hit]") {
    for (const Placement& placement : placements) {
        // Rounded to 8 mm, a sphere of 1 m is not convex; it is with a thousandth of that.
        if (placement.shift != vec3(0) && placement.scale < 1e3f) continue;
        Scene scene;
        add_sphere(scene, {0, 0, 0}, 1, 24);
        place(scene, placement);
        const EmbreeScene rays(scene);
        const Receivers receivers =
            spread(scene, 0, static_cast<std::uint32_t>(scene.triangles.size()), receiver_count, false);
        const Light light = placed_light(LightType::Point, {3, 4, 2}, {0, 0}, placement);
        const Image<float> visibility = hard_truth(rays, receivers, light).visibility;
        size_t wrong = 0, facing = 0;
        for (size_t i = 0; i < receivers.size(); ++i) {
            const bool lit = faces(receivers.values()[i], light.position);
            facing += lit;
            wrong += visibility.values()[i] != (lit ? 1.0f : 0.0f);
        }
        INFO("scale " << placement.scale << ", shift " << placement.shift.x);
        CHECK(facing > receivers.size() / 4);
        CHECK(wrong == 0);
    }
}

TEST_CASE("a closed box lit from inside lets nothing out and hides nothing inside", "[raytrace][truth][self-hit]") {
    for (const Placement& placement : placements) {
        Scene scene;
        add_floor(scene, -8, 8, -8, 8, -2);
        add_box(scene, {-1, -1, -1}, {1, 1, 1});
        place(scene, placement);
        const EmbreeScene rays(scene);
        const Light light = placed_light(LightType::Sphere, {0.25f, 0.5f, -0.25f}, {0.25f, 0.25f}, placement);
        INFO("scale " << placement.scale << ", shift " << placement.shift.x);
        const Receivers outside = spread(scene, 0, 14, receiver_count, false);
        CHECK(count_unlike(outside, area_visibility(rays, outside, light, Pattern::Sobol, 4, 0, nullptr), 0.0f) == 0);
        const Receivers inside = spread(scene, 2, 12, receiver_count, true);
        CHECK(count_unlike(inside, area_visibility(rays, inside, light, Pattern::Sobol, 4, 0, nullptr), 1.0f) == 0);
    }
}

TEST_CASE("a closed box lit from outside is dark inside", "[raytrace][truth][self-hit]") {
    for (const Placement& placement : placements) {
        Scene scene;
        add_box(scene, {-1, -1, -1}, {1, 1, 1});
        place(scene, placement);
        const EmbreeScene rays(scene);
        INFO("scale " << placement.scale << ", shift " << placement.shift.x);
        Receivers inside = spread(scene, 0, 12, receiver_count, true);
        keep_inside(inside, placement);
        for (const vec3 position : {vec3(2, 4, 3), vec3(-3, 0.5f, 0)}) {
            const Light light = placed_light(LightType::Rectangle, position, {1, 1}, placement);
            CHECK(count_unlike(inside, area_visibility(rays, inside, light, Pattern::Sobol, 4, 0, nullptr), 0.0f) == 0);
        }
    }
}

// The half-plane's closed form, moved and scaled with the scene. All coordinates are exact in float32.
TEST_CASE("a half plane hides the same fraction at every scale", "[raytrace][truth]") {
    for (const Placement& placement : placements) {
        Scene scene;
        add_floor(scene, -2, 2, -2, 2, 0);
        add_floor(scene, -4, 0, -4, 4, 2);
        place(scene, placement);
        const EmbreeScene rays(scene);
        const Light light = placed_light(LightType::Rectangle, {0, 4, 0}, {2, 2}, placement);
        const float largest = 4 * placement.scale + std::abs(placement.shift.x);
        // The rays start 2⁻¹⁹ of the largest coordinate off the floor, and samples are rounded to 2⁻²⁴ of it; either
        // moves the edge's shadow by no more on a light that is 2 wide.
        const double systematic = double(largest) / double(2 * placement.scale) * (0x1p-19 + 0x1p-23);
        for (const float x : {-0.5f, 0.0f, 0.25f, 0.75f}) {
            const Receivers receivers = receivers_on_floor(
                std::vector<vec3>(128, vec3(x, 0, 0.5f) * placement.scale + placement.shift), x > 0.5f ? 1u : 0u);
            const Image<float> visibility = area_visibility(rays, receivers, light, Pattern::Sobol, 1024, 3, nullptr);
            double sum = 0, squares = 0;
            for (const float v : visibility.values()) sum += double(v), squares += double(v) * double(v);
            const double mean = sum / 128, error = std::sqrt(std::max(0.0, squares / 128 - mean * mean) / 127);
            INFO("scale " << placement.scale << ", shift " << placement.shift.x << ", x " << x << ", mean " << mean);
            CHECK(std::abs(mean - 0.5 * (1 + double(x))) <= 5 * error + systematic);
        }
    }
}

// 10⁵ m away a coordinate is known to 8 mm, and rays start off the surface by no more than that. The plate is nearer to
// the floor than rays started when they were traced in coordinates of the world: by 0.19 m.
TEST_CASE("far from the origin a plate just above the floor still casts its shadow", "[raytrace][truth]") {
    for (const vec3 shift : {vec3(0.0f), vec3(1e5f), vec3(1e5f, 0, -1e5f), vec3(-1e5f, 1e5f, 0)}) {
        Scene scene;
        add_floor(scene, -8, 8, -8, 8, 0);
        add_floor(scene, -4, 0, -4, 4, 0.0625f);
        place(scene, {1, shift});
        const EmbreeScene rays(scene);
        const Light light = placed_light(LightType::Rectangle, {-2, 4, 0}, {0.25f, 0.25f}, {1, shift});
        Receivers receivers(2, 1);
        receivers(0, 0) = {shift + vec3(-2, 0, 1), {0, 1, 0}, 0};
        receivers(1, 0) = {shift + vec3(2, 0, 1), {0, 1, 0}, 0};
        const TriangleClusters clusters = build_clusters(scene);
        for (const bool proofs : {false, true}) {
            const Image<float> visibility =
                area_visibility(rays, receivers, light, Pattern::Sobol, 256, 0, nullptr, proofs ? &clusters : nullptr);
            CHECK(visibility(0, 0) == 0.0f);
            CHECK(visibility(1, 0) == 1.0f);
        }
        INFO("shift " << shift.x << ", " << shift.y << ", " << shift.z);
        CHECK(exact_visibility(scene, clusters, receivers(0, 0), light) == 0.0);
        CHECK(exact_visibility(scene, clusters, receivers(1, 0), light) == 1.0);
        CHECK(double(rays.shadow_origin(to_local(receivers(0, 0), rays.shift())).rounding) < 1e-4);
    }
}

// A receiver that rounding has put below the plane of its triangle starts above it.
TEST_CASE("far from the origin rays start on the side of the normal", "[raytrace][self-hit]") {
    const vec3 shift(1e5f, 2e5f, -1e5f);
    Scene scene;
    add_polygon(scene, {shift + vec3(-3, 1, -2), shift + vec3(-3.25f, 2, 4), shift + vec3(2, 2.75f, 4),
                        shift + vec3(2, 1.5f, -2)});
    const EmbreeScene rays(scene);
    const vec3 corner = scene.positions[scene.triangles[0].x] - rays.shift();
    for (std::uint32_t i = 0; i < 1000; ++i) {
        Receiver receiver = receiver_at(scene, 0, 0.5f * to_unit(hash(i, 1)), 0.5f * to_unit(hash(i, 2)));
        const ShadowOrigin origin = rays.shadow_origin(to_local(receiver, rays.shift()));
        const float height = glm::dot(origin.position - corner, receiver.geometric_normal);
        CHECK(height > 0.5f * origin.rounding);
        CHECK(height < 1.5f * origin.rounding);
    }
}
