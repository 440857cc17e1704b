// Straight and round occluders before every shape of light, in visibility and radiance, against closed forms.

#include <catch2/catch.hpp>

#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "raytrace/truth.h"
#include "tests/raytrace/closed_forms.h"
#include "tests/raytrace/shapes.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

constexpr float floor_side = 2;
constexpr int pixels = 128, samples = 256;

struct Blocker {
    std::string name;
    FlatOccluder flat;
    std::vector<vec3> polygon;
};

// Corners at height 2, turned by 0.3 radians about the y axis.
vec3 turned(double along, double across) {
    return vec3(
        dvec3(std::cos(0.3) * along - std::sin(0.3) * across, 2, std::sin(0.3) * along + std::cos(0.3) * across));
}

std::vector<Blocker> blockers(double scale) {
    const dvec2 along(std::cos(0.3), std::sin(0.3)), across(-along.y, along.x);
    constexpr double far = 16, offset = 0.1, width = 0.3;
    std::vector<vec3> circle;
    constexpr int sides = 4000;
    for (int i = 0; i < sides; ++i)
        circle.push_back(vec3(dvec3(0.35 * std::cos(2 * pi * i / sides), 2, -0.35 * std::sin(2 * pi * i / sides))));
    std::vector<Blocker> all;
    const auto add = [&](const char* name, std::vector<FlatOccluder::Edge> edges, double radius,
                         std::vector<vec3> polygon) {
        for (FlatOccluder::Edge& edge : edges) edge.offset *= scale;
        for (vec3& corner : polygon) corner *= static_cast<float>(scale);
        all.push_back({name, {2 * scale, std::move(edges), radius * scale}, std::move(polygon)});
    };
    add("half-plane", {{along, offset}}, 0,
        {turned(offset, -far), turned(offset, far), turned(far, far), turned(far, -far)});
    add("strip", {{along, offset}, {-along, -offset - width}}, 0,
        {turned(offset, -far), turned(offset, far), turned(offset + width, far), turned(offset + width, -far)});
    add("corner", {{along, offset}, {across, -offset}}, 0,
        {turned(offset, -offset), turned(offset, far), turned(far, far), turned(far, -offset)});
    add("disk", {}, 0.35, circle);
    return all;
}

std::vector<Light> lights(float scale) {
    Light rectangle = light_at(LightType::Rectangle, {0.2f, 4, 0.1f}, {2, 1.5f});
    rectangle.direction = glm::normalize(vec3(-0.2f, -1, 0.1f));
    rectangle.tangent = any_tangent(rectangle.direction);
    Light disk = light_at(LightType::Disk, {0, 4, 0}, {1.8f, 1.8f});
    Light sphere = light_at(LightType::Sphere, {0.3f, 4, -0.2f}, {1.6f, 1.6f});
    rectangle.intensity = disk.intensity = sphere.intensity = {2, 1, 0.5f};
    std::vector<Light> all = {rectangle, disk, sphere};
    for (Light& light : all) light.position *= scale, light.size *= scale;
    return all;
}

Surface surface_at(vec3 p) {
    Surface surface;
    surface.position = p;
    surface.to_viewer = glm::normalize(vec3(-1, 2, 0.5f));
    surface.albedo = {0.8f, 0.4f, 0.1f};
    surface.roughness = 0.5f;
    surface.metallic = 0.25f;
    return surface;
}

// The rays start 2⁻¹⁹ of the largest coordinate above the floor, which moves the shadow of an edge across the light by
// at most as much (an occluder half way to the light); four edges of a length below the light's width w move a fraction
// by at most 4/w of that. Vertices at 16 m are rounded by 2⁻²¹.
double systematic(const Light& light, float scale) {
    return (4 * double(floor_side) * 0x1p-19 + 4 * 0x1p-20) / double(std::min(light.size.x, light.size.y)) *
           double(scale);
}

struct Mean {
    double value = 0, error = 0; // standard error of the mean, from the spread of the pixels
};

template <class Read> Mean mean_of(const TruthAnswer& answer, Read read) {
    double sum = 0, squares = 0;
    for (size_t i = 0; i < pixels; ++i) sum += read(answer, i);
    const double mean = sum / pixels;
    for (size_t i = 0; i < pixels; ++i) squares += (read(answer, i) - mean) * (read(answer, i) - mean);
    return {mean, std::sqrt(squares / (pixels - 1.0) / pixels)};
}

// 5 standard errors: wrong once in 1.7 million.
void check_mean(const Mean& mean, double expected, double unit, double systematic_error) {
    INFO("expected " << expected << ", found " << mean.value << " ± " << mean.error);
    CHECK(std::abs(mean.value - expected) <= 5 * mean.error + unit * systematic_error);
}

} // namespace

namespace {

// One receiver, many pixels: visibility and radiance of every pattern against the integrals.
void check_receiver(const EmbreeScene& rays, const Blocker& blocker, const Light& light, vec3 p, float scale,
                    std::span<const Pattern> patterns) {
    const FlatLight shape = flat(light, dvec3(p));
    const double fraction = visible_fraction(shape, &blocker.flat, dvec3(p)), floor = systematic(light, scale);
    const Receivers receivers = receivers_on_floor(std::vector<vec3>(pixels, p), p.x > p.z ? 1u : 0u);
    for (const Brdf model : {Brdf::Lambert, Brdf::Ggx}) {
        const Surface surface = surface_at(p);
        const auto integrand = [&](dvec3 q) {
            const dvec3 way = q - dvec3(p);
            const double d2 = glm::dot(way, way);
            const dvec3 w = way / std::sqrt(d2);
            return dvec3(brdf(model, surface, vec3(w))) * dvec3(light.intensity) *
                   (w.y * -glm::dot(shape.facing, w) / d2);
        };
        const dvec3 radiance = visible_integral(shape, &blocker.flat, dvec3(p), integrand);
        const dvec3 unshadowed = visible_integral(shape, nullptr, dvec3(p), integrand);
        for (const Pattern pattern : patterns) {
            TruthSettings settings;
            settings.pattern = pattern;
            settings.samples = samples;
            settings.seed = 11;
            settings.brdf = model;
            settings.surface = [&](int, int) { return surface; };
            const TruthAnswer answer = area_truth(rays, receivers, light, settings);
            INFO("pattern " << static_cast<int>(pattern) << ", brdf " << static_cast<int>(model));
            if (pattern == Pattern::Grid) {
                // The same in every pixel, and only as good as its cells.
                CHECK(answer.visibility(0, 0) == answer.visibility(pixels - 1, 0));
                CHECK(std::abs(double(answer.visibility(0, 0)) - fraction) <= 1.0 / 16);
                continue;
            }
            check_mean(mean_of(answer, [](const TruthAnswer& a, size_t i) { return double(a.visibility.values()[i]); }),
                       fraction, 1, floor);
            check_mean(
                mean_of(answer, [](const TruthAnswer& a, size_t i) { return double(a.radiance->values()[i].x); }),
                radiance.x, unshadowed.x, floor);
        }
    }
}

} // namespace

TEST_CASE("sampled visibility and radiance agree with closed forms", "[raytrace][truth]") {
    constexpr Pattern every[] = {Pattern::Sobol,  Pattern::Stratified, Pattern::Random,
                                 Pattern::Halton, Pattern::Poisson,    Pattern::Grid};
    for (const float scale : {1.0f, 1e-3f, 1e6f})
        for (const Blocker& blocker : blockers(double(scale))) {
            Scene scene;
            const float side = floor_side * scale;
            add_floor(scene, -side, side, -side, side, 0);
            add_polygon(scene, blocker.polygon);
            const EmbreeScene rays(scene);
            for (const Light& light : lights(scale))
                for (const vec3 p : {vec3(0.1f, 0, 0.05f), vec3(-0.6f, 0, 0.3f)}) {
                    INFO(blocker.name << " before a " << light_type_name(light.type) << " from x = " << p.x
                                      << ", scale " << scale);
                    check_receiver(rays, blocker, light, p * scale, scale,
                                   scale == 1.0f ? std::span<const Pattern>(every)
                                                 : std::span<const Pattern>(every).first(1));
                }
        }
}

// The bound is strict where one straight edge crosses a rectangle: checked for edges in every direction.
TEST_CASE("the error bar of a grid bounds the error of a straight edge", "[raytrace][truth]") {
    Light light = light_at(LightType::Rectangle, {0, 4, 0}, {2, 2});
    light.tangent = {1, 0, 0};
    double closest = 0;
    for (int i = 0; i < 60; ++i) {
        const double angle = 0.11 * i, offset = 0.021 * i - 0.6;
        const dvec2 normal(std::cos(angle), std::sin(angle));
        const auto corner = [&](double along, double across) {
            return vec3(dvec3(normal.x * along - normal.y * across, 2, normal.y * along + normal.x * across));
        };
        Scene scene;
        add_floor(scene, -floor_side, floor_side, -floor_side, floor_side, 0);
        add_polygon(scene, {corner(offset, -16), corner(offset, 16), corner(16, 16), corner(16, -16)});
        const EmbreeScene rays(scene);
        const FlatOccluder occluder{2, {{normal, offset}}, 0};
        const double fraction = visible_fraction(flat(light, dvec3(0)), &occluder, dvec3(0));
        for (const int count : {16, 64, 256, 1024}) {
            TruthSettings settings;
            settings.pattern = Pattern::Grid;
            settings.samples = count;
            const TruthAnswer answer = area_truth(rays, receivers_on_floor({{0, 0, 0}}, 0), light, settings);
            const double error = std::abs(double(answer.visibility(0, 0)) - fraction);
            INFO("edge " << i << ", " << count << " samples, visible " << fraction);
            CHECK(error <= double(answer.error(0, 0)) + systematic(light, 1));
            closest = std::max(closest, error / double(answer.error(0, 0)));
        }
    }
    CHECK(closest > 0.1); // a bound that is not far from what happens
}

TEST_CASE("a sphere without occluders gives the irradiance of a point", "[raytrace][truth]") {
    // E = π L (r/d)² cos θ, exactly, while the sphere is above the horizon.
    Scene scene;
    add_floor(scene, -floor_side, floor_side, -floor_side, floor_side, 0);
    const EmbreeScene rays(scene);
    const Light light = light_at(LightType::Sphere, {0.5f, 3, 0}, {2, 2});
    TruthSettings settings;
    settings.samples = 1024;
    settings.surface = [](int, int) {
        Surface surface;
        surface.albedo = vec3(1);
        return surface;
    };
    const TruthAnswer answer =
        area_truth(rays, receivers_on_floor(std::vector<vec3>(pixels, vec3(0)), 0), light, settings);
    const double d = std::sqrt(0.25 + 9);
    const Mean mean = mean_of(answer, [](const TruthAnswer& a, size_t i) { return double(a.radiance->values()[i].x); });
    CHECK(std::abs(mean.value - 1 / (d * d) * 3 / d) <= 5 * mean.error + 1e-7);
}

// A wall without end on the floor, the light half behind it: exactly half is seen, however near the receiver.
TEST_CASE("a receiver in contact with its occluder sees half of the light", "[raytrace][truth]") {
    for (const float scale : {1e-3f, 1.0f, 1e3f, 1e6f}) {
        Scene scene;
        add_floor(scene, -scale, scale, -scale, scale, 0);
        add_polygon(scene, {vec3(0, 0, -16) * scale, vec3(0, 0, 16) * scale, vec3(0, 16, 16) * scale,
                            vec3(0, 16, -16) * scale});
        const EmbreeScene rays(scene);
        const Light light = light_at(LightType::Rectangle, vec3(0, 4, 0) * scale, vec2(2) * scale);
        std::vector<vec3> points;
        for (const float x : {1e-2f, 1e-4f, 1e-6f, 1e-8f, 1e-12f}) points.push_back(vec3(x, 0, 0.1f) * scale);
        const Image<float> visibility =
            area_visibility(rays, receivers_on_floor(points, 0), light, Pattern::Grid, 1024, 0, nullptr);
        INFO("scale " << scale);
        for (const float v : visibility.values()) CHECK(v == 0.5f);
    }
}

// Ceilings in the plane of the light, around it and behind it, touch every one of its points and hide none.
TEST_CASE("a light flush with its surroundings is seen whole", "[raytrace][truth]") {
    for (const float scale : {1e-3f, 1.0f, 1e3f, 1e6f})
        for (const bool opening : {false, true}) {
            Scene scene;
            add_floor(scene, -4 * scale, 4 * scale, -4 * scale, 4 * scale, 0);
            if (opening) {
                add_floor(scene, -8 * scale, -scale, -8 * scale, 8 * scale, 4 * scale);
                add_floor(scene, scale, 8 * scale, -8 * scale, 8 * scale, 4 * scale);
                add_floor(scene, -scale, scale, -8 * scale, -scale, 4 * scale);
                add_floor(scene, -scale, scale, scale, 8 * scale, 4 * scale);
            } else {
                add_floor(scene, -8 * scale, 8 * scale, -8 * scale, 8 * scale, 4 * scale);
            }
            const EmbreeScene rays(scene);
            std::vector<vec3> points;
            for (int i = 0; i < 400; ++i)
                points.push_back(vec3(float(i % 20) - 9.5f, 0, float(i / 20) - 9.5f) * (0.4f * scale));
            Receivers receivers = receivers_on_floor(points, 0);
            for (int i = 0; i < 400; ++i) receivers(i, 0).triangle = points[size_t(i)].x > points[size_t(i)].z ? 1 : 0;
            for (const LightType type : {LightType::Rectangle, LightType::Disk}) {
                const Light light = light_at(type, vec3(0, 4, 0) * scale, vec2(2) * scale);
                const Image<float> visibility = area_visibility(rays, receivers, light, Pattern::Sobol, 64, 0, nullptr);
                INFO("scale " << scale << ", " << light_type_name(type) << ", opening " << opening);
                CHECK(std::all_of(visibility.values().begin(), visibility.values().end(),
                                  [](float v) { return v == 1.0f; }));
            }
        }
}
