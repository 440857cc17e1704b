#include <catch2/catch.hpp>

#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>

#include "core/parallel.h"
#include "core/random.h"
#include "raytrace/truth.h"
#include "tests/raytrace/shapes.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

// The visible part of a light is bounded by one straight edge or one circle, so of N points of a net or grid at most
// the cells on that boundary, 4·√N of them, can be counted wrongly; an exact fraction is met within 4/√N whatever the
// scramble. Independent points are held to 5 standard deviations (1 in 1.7 million). Nothing and all are exact.
double tolerance(Pattern pattern, int samples, double fraction) {
    if (fraction == 0.0 || fraction == 1.0) return 0;
    if (pattern == Pattern::Random) return 5.0 * std::sqrt(fraction * (1.0 - fraction) / samples);
    return 4.0 / std::sqrt(double(samples));
}

constexpr Pattern all_patterns[] = {Pattern::Sobol,  Pattern::Stratified, Pattern::Grid,
                                    Pattern::Random, Pattern::Halton,     Pattern::Poisson};

// Rays start 2⁻¹⁹ of the largest coordinate above the floor, of 2 m here; an edge half way up to the light throws its
// shadow by as much to the side on the light, which is 2 m wide.
constexpr double ray_offset = 0x1p-19;

// Means of many pixels, each with its own scramble: the standard error of the mean, estimated from the pixels
// themselves, bounds the bias at 5 standard deviations.
void check_unbiased(const Image<float>& visibility, double expected) {
    double sum = 0, squares = 0;
    for (const float v : visibility.values()) {
        sum += double(v);
        squares += (double(v) - expected) * (double(v) - expected);
    }
    const double n = static_cast<double>(visibility.size());
    CHECK(std::abs(sum / n - expected) <= 5.0 * std::sqrt(squares) / n + ray_offset);
}

} // namespace

TEST_CASE("a half plane hides the closed-form fraction of a square light", "[raytrace][truth]") {
    Scene scene;
    add_floor(scene, -2, 2, -2, 2, 0);
    add_floor(scene, -4, 0, -4, 4, 2);
    const EmbreeScene rays(scene);
    const Light light = light_at(LightType::Rectangle, {0, 4, 0}, {2, 2});
    // Visible fraction (1 + x) / 2: the light's point lx is seen where (x + lx) / 2 ≥ 0 [analytic reference values,
    // case 2].
    for (const float x : {-1.0f, -0.75f, -0.5f, 0.0f, 0.3f, 0.5f, 0.75f, 1.0f})
        for (const Pattern pattern : all_patterns) {
            const double fraction = 0.5 * (1.0 + double(x));
            const Receivers receivers = receivers_on_floor(std::vector<vec3>(256, {x, 0, 0}), 0);
            const Image<float> visibility = area_visibility(rays, receivers, light, pattern, 1024, 7, nullptr);
            INFO("x " << x << ", pattern " << static_cast<int>(pattern));
            for (const float v : visibility.values())
                CHECK(std::abs(double(v) - fraction) <= tolerance(pattern, 1024, fraction));
            if (pattern != Pattern::Grid) check_unbiased(visibility, fraction);
        }
}

TEST_CASE("visible fractions equal the shared reference values", "[raytrace][truth]") {
    const std::string path = shared_path("analytic/reference_values.json");
    if (path.empty()) return;
    Scene half_plane, open;
    add_floor(half_plane, -2, 2, -2, 2, 0);
    add_floor(half_plane, -4, 0, -4, 4, 2);
    add_floor(open, -4, 4, -4, 4, 0);
    const EmbreeScene half_plane_rays(half_plane), open_rays(open);
    const Light light = light_at(LightType::Rectangle, {0, 4, 0}, {2, 2});
    int cases = 0;
    const nlohmann::json reference = nlohmann::json::parse(std::ifstream(path));
    for (const auto& entry : reference.at("irradiance_of_unit_radiance")) {
        const std::string name = entry.at("case");
        if (name != "square_half_plane" && name != "square_unoccluded") continue;
        ++cases;
        const vec3 p(entry["receiver"][0].get<float>(), 0.0f, 0.0f);
        const double fraction = entry["visible_fraction"];
        const EmbreeScene& rays = name == "square_half_plane" ? half_plane_rays : open_rays;
        const Receivers receivers = receivers_on_floor(std::vector<vec3>(256, p), 0);
        INFO(name << " at x = " << p.x);
        check_unbiased(area_visibility(rays, receivers, light, Pattern::Sobol, 1024, 1, nullptr), fraction);
    }
    CHECK(cases == 10);
}

TEST_CASE("a coaxial disk hides three quarters' complement of a disk light", "[raytrace][truth]") {
    Scene scene;
    add_floor(scene, -4, 4, -4, 4, 0);
    std::vector<vec3> rim;
    // The concentric map lays the shadow along the borders of the stratified cells: with fewer sides the sliver between
    // the polygon and the circle would get a sample now and then, which no spread of pixels foretells.
    constexpr int sides = 4000;
    for (int i = 0; i < sides; ++i) {
        const double angle = 2 * pi * i / sides;
        rim.push_back(vec3(dvec3(0.25 * std::cos(angle), 2, -0.25 * std::sin(angle))));
    }
    add_polygon(scene, rim);
    const EmbreeScene rays(scene);
    const Light light = light_at(LightType::Disk, {0, 4, 0}, {2, 2});
    // The blocker's outline projects to half the light's radius: (1/2)² of its area, less what the polygon lacks of its
    // circle.
    const double polygon = sides / (2 * pi) * std::sin(2 * pi / sides);
    for (const Pattern pattern : all_patterns) {
        const Receivers receivers = receivers_on_floor(std::vector<vec3>(256, {0, 0, 0}), 0);
        const Image<float> visibility = area_visibility(rays, receivers, light, pattern, 1024, 3, nullptr);
        INFO("pattern " << static_cast<int>(pattern));
        for (const float v : visibility.values()) CHECK(std::abs(double(v) - 0.75) <= tolerance(pattern, 1024, 0.75));
        if (pattern != Pattern::Grid) check_unbiased(visibility, 1.0 - 0.25 * polygon);
    }
}

TEST_CASE("a sphere light is hidden as far as its limb disk is", "[raytrace][truth]") {
    Scene scene;
    add_floor(scene, -2, 2, -2, 2, 0);
    add_floor(scene, -4, 0, -4, 4, 2);
    const EmbreeScene rays(scene);
    const Light light = light_at(LightType::Sphere, {0, 4, 0}, {2, 2});
    const Receivers receivers = receivers_on_floor(std::vector<vec3>(256, {0, 0, 0}), 0);
    check_unbiased(area_visibility(rays, receivers, light, Pattern::Sobol, 1024, 3, nullptr), 0.5);
}

TEST_CASE("a box's shadow of a point light is the projected top face", "[raytrace][truth]") {
    Scene scene;
    add_floor(scene, -4, 4, -4, 4, 0);
    add_box(scene, {-0.5f, 0.5f, -0.5f}, {0.5f, 1.5f, 0.5f});
    const EmbreeScene rays(scene);
    std::vector<vec3> points;
    for (int i = 0; i < 4000; ++i) points.push_back({4 * to_unit(hash(i, 1)) - 2, 0, 4 * to_unit(hash(i, 2)) - 2});
    for (const float d : {0.79999f, 0.80001f}) // on both sides of each edge
        for (const float s : {-0.79f, 0.0f, 0.31f, 0.79f})
            points.insert(points.end(), {{d, 0, s}, {-d, 0, s}, {s, 0, d}, {s, 0, -d}});
    const Image<float> visibility =
        hard_truth(rays, receivers_on_floor(points, 0), light_at(LightType::Point, {0, 4, 0})).visibility;
    for (size_t i = 0; i < points.size(); ++i) {
        INFO(points[i].x << ", " << points[i].z);
        const bool hidden = std::max(std::abs(points[i].x), std::abs(points[i].z)) < 0.8f;
        CHECK(visibility.values()[i] == (hidden ? 0.0f : 1.0f));
    }
}

TEST_CASE("nothing between light and plane: exactly 1, and 0 behind the plane", "[raytrace][truth]") {
    Scene scene;
    add_floor(scene, -100, 100, -100, 100, 0);
    const EmbreeScene rays(scene);
    std::vector<vec3> points;
    for (int i = 0; i < 500; ++i)
        points.push_back({200 * to_unit(hash(i, 1)) - 100, 0, 200 * to_unit(hash(i, 2)) - 100});
    Receivers receivers = receivers_on_floor(points, 0);
    for (int i = 0; i < receivers.width(); ++i) receivers(i, 0).triangle = points[size_t(i)].x > points[size_t(i)].z;
    for (const LightType type : {LightType::Rectangle, LightType::Disk, LightType::Sphere, LightType::Point,
                                 LightType::Spot, LightType::Directional, LightType::TexturedRectangle})
        for (const float height : {0.001f, 1.0f, 1000.0f}) {
            INFO(light_type_name(type) << " at " << height);
            const Light light = light_at(type, {3, height, 1}, vec2(std::min(1.0f, height)));
            const Image<float> above = area_visibility(rays, receivers, light, Pattern::Sobol, 64, 0, nullptr);
            CHECK(std::all_of(above.values().begin(), above.values().end(), [](float v) { return v == 1.0f; }));
            Light below = light;
            below.position.y = -height;
            below.direction = -light.direction;
            const Image<float> under = area_visibility(rays, receivers, below, Pattern::Sobol, 64, 0, nullptr);
            CHECK(std::all_of(under.values().begin(), under.values().end(), [](float v) { return v == 0.0f; }));
        }
}

TEST_CASE("pixels without a receiver count as lit", "[raytrace][truth]") {
    Scene scene;
    add_floor(scene, -1, 1, -1, 1, 0);
    const EmbreeScene rays(scene);
    const Light light = light_at(LightType::Rectangle, {0, 4, 0}, {2, 2});
    const Image<float> visibility = area_visibility(rays, Receivers(5, 3), light, Pattern::Sobol, 16, 0, nullptr);
    CHECK(std::all_of(visibility.values().begin(), visibility.values().end(), [](float v) { return v == 1.0f; }));
}

TEST_CASE("a closed box lets no light out", "[raytrace][truth]") {
    Scene scene;
    add_floor(scene, -10, 10, -10, 10, -2);
    add_box(scene, {-1, -1, -1}, {1, 1, 1});
    const EmbreeScene rays(scene);
    std::vector<vec3> points;
    for (int i = 0; i < 3000; ++i) points.push_back({20 * to_unit(hash(i, 1)) - 10, -2, 20 * to_unit(hash(i, 2)) - 10});
    for (int i = -200; i <= 200; ++i)
        points.push_back(vec3(0.02f, 0, 0.02f) * float(i) - vec3(0, 2, 0)); // below edges and corners
    const Receivers receivers = receivers_on_floor(points, 0);
    for (const LightType type : {LightType::Point, LightType::Rectangle, LightType::Sphere}) {
        const Light light = light_at(type, {0.1f, 0.2f, -0.1f}, {0.5f, 0.5f});
        const Image<float> visibility = area_visibility(rays, receivers, light, Pattern::Sobol, 256, 0, nullptr);
        CHECK(std::all_of(visibility.values().begin(), visibility.values().end(), [](float v) { return v == 0.0f; }));
    }
}

TEST_CASE("the same visibility for any number of threads", "[raytrace][truth]") {
    Scene scene;
    add_floor(scene, -4, 4, -4, 4, 0);
    add_sphere(scene, {0, 1, 0}, 0.8f, 24);
    add_box(scene, {-2, 0.5f, -1}, {-1, 1.5f, 1});
    Receivers receivers(64, 64);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            receivers(x, y) = {{-4 + float(x) / 8, 0, -4 + float(y) / 8}, {0, 1, 0}, std::uint32_t(x > y)};
    const Light light = light_at(LightType::Disk, {1, 5, 1}, {1.5f, 1.5f});
    std::vector<std::vector<float>> answers;
    for (const int threads : {1, 2, 7})
        with_threads(threads, [&] {
            const EmbreeScene rays(scene);
            const Image<float> visibility = area_visibility(rays, receivers, light, Pattern::Sobol, 100, 5, nullptr);
            answers.emplace_back(visibility.values().begin(), visibility.values().end());
        });
    CHECK(answers[0] == answers[1]);
    CHECK(answers[0] == answers[2]);
    CHECK(std::any_of(answers[0].begin(), answers[0].end(), [](float v) { return v > 0.0f && v < 1.0f; }));
}
