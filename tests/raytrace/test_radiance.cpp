#include <catch2/catch.hpp>

#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>

#include "core/random.h"
#include "raytrace/truth.h"
#include "tests/raytrace/shapes.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

vec3 direction(double theta, double phi) {
    return vec3(dvec3(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)));
}

Surface white(float roughness, float metallic) {
    Surface surface;
    surface.albedo = vec3(1);
    surface.roughness = roughness;
    surface.metallic = metallic;
    return surface;
}

// ∫ f cos θ over the hemisphere.
double reflected(Brdf model, const Surface& surface) {
    constexpr int rows = 1000, columns = 250;
    double sum = 0;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            // Rows crowd where the highlight of a viewer near the zenith is.
            const double t = (j + 0.5) / rows, theta = 0.5 * pi * t * t, width = pi * t / rows;
            const double phi = 2 * pi * (i + 0.5) / columns;
            sum += double(brdf(model, surface, direction(theta, phi)).x) * std::cos(theta) * std::sin(theta) * width;
        }
    return sum * 2 * pi / columns;
}

} // namespace

TEST_CASE("a BRDF is reciprocal and reflects no more than it gets", "[raytrace]") {
    CHECK(reflected(Brdf::Lambert, white(1, 0)) == Approx(1).epsilon(1e-4));
    for (const float roughness : {0.3f, 0.6f, 1.0f})
        for (const float metallic : {0.0f, 0.5f, 1.0f})
            for (const double theta : {0.01, 0.5, 1.2}) {
                Surface surface = white(roughness, metallic);
                surface.to_viewer = direction(theta, 0.3);
                const double share = reflected(Brdf::Ggx, surface);
                INFO("roughness " << roughness << ", metallic " << metallic << ", view " << theta << ": " << share);
                // Mixing by the Fresnel term of the half vector gives grazing views of a white dielectric more than
                // there is; microfacets alone do not.
                if (metallic == 1.0f || theta < 1) CHECK(share <= 1.001);
                CHECK(share > 0.3); // Smith's shadowing loses light between rough facets, but not most of it
                for (std::uint32_t i = 0; i < 50; ++i) {
                    const vec3 to_light = direction(1.5 * double(to_unit(hash(i, 1))), 6 * double(to_unit(hash(i, 2))));
                    Surface swapped = surface;
                    swapped.to_viewer = to_light;
                    const float forth = brdf(Brdf::Ggx, surface, to_light).x,
                                back = brdf(Brdf::Ggx, swapped, surface.to_viewer).x;
                    CHECK(forth == Approx(back).epsilon(1e-3));
                }
            }
}

// With the light and the viewer at the zenith: D = 1/(π α²), the shadowing term G₂/(4 n·l n·v) = 1/4, F = F₀.
TEST_CASE("GGX has its closed form along the normal", "[raytrace]") {
    for (const float roughness : {0.1f, 0.5f, 1.0f}) {
        Surface surface = white(roughness, 1);
        surface.albedo = {0.9f, 0.5f, 0.2f};
        surface.to_viewer = surface.normal;
        const double alpha2 = std::pow(double(roughness), 4), peak = 1 / (pi * alpha2) / 4;
        CHECK(brdf(Brdf::Ggx, surface, surface.normal).y == Approx(0.5 * peak).epsilon(1e-5));
        surface.metallic = 0;
        CHECK(brdf(Brdf::Ggx, surface, surface.normal).y == Approx(0.96 * 0.5 / pi + 0.04 * peak).epsilon(1e-5));
        CHECK(brdf(Brdf::Ggx, surface, -surface.normal) == vec3(0));
        CHECK(brdf(Brdf::Lambert, surface, -surface.normal) == vec3(0));
    }
}

// π × radiance of a white Lambert receiver is the irradiance.
TEST_CASE("integrated irradiance equals the shared reference values", "[raytrace][truth]") {
    const std::string path = shared_path("analytic/reference_values.json");
    if (path.empty()) return;
    const nlohmann::json reference = nlohmann::json::parse(std::ifstream(path));
    int cases = 0;
    for (const auto& entry : reference.at("irradiance_of_unit_radiance")) {
        const std::string name = entry.at("case"), description = entry.at("light");
        Scene scene;
        add_floor(scene, -4, 4, -4, 4, 0);
        if (name == "square_half_plane") add_floor(scene, -8, 0, -8, 8, 2);
        if (name == "disk_coaxial_blocker_on_axis") {
            std::vector<vec3> rim;
            for (int i = 0; i < 4000; ++i)
                rim.push_back(vec3(dvec3(0.25 * std::cos(2 * pi * i / 4000), 2, -0.25 * std::sin(2 * pi * i / 4000))));
            add_polygon(scene, rim);
        }
        Light light = light_at(LightType::Rectangle, {0, 4, 0}, {2, 2});
        if (name.starts_with("disk")) {
            float radius = 1, height = 4;
            if (name == "disk_on_axis")
                REQUIRE(std::sscanf(description.c_str(), "disk of radius %f at height %f", &radius, &height) == 2);
            light = light_at(LightType::Disk, {0, height, 0}, vec2(2 * radius));
        }
        const EmbreeScene rays(scene);
        const vec3 p(entry["receiver"][0].get<float>(), 0, 0);
        TruthSettings settings;
        settings.surface = [&](int, int) {
            Surface surface = white(1, 0);
            surface.position = p;
            return surface;
        };
        const TruthAnswer answer = area_truth(rays, receivers_on_floor(std::vector<vec3>(256, p), 0), light, settings);
        double sum = 0, squares = 0, seen = 0;
        for (size_t i = 0; i < 256; ++i) {
            const double e = pi * double(answer.radiance->values()[i].y);
            sum += e, squares += e * e, seen += double(answer.visibility.values()[i]);
        }
        const double mean = sum / 256, error = std::sqrt(std::max(0.0, squares / 256 - mean * mean) / 255);
        const double expected = entry["irradiance"];
        INFO(name << " at x = " << p.x << ": " << mean << " ± " << error << ", expected " << expected);
        // 4·2⁻¹⁹ is how far the rays start off the floor, in metres before a light of 2.
        CHECK(std::abs(mean - expected) <= 5 * error + 1e-5 * expected);
        CHECK(std::abs(seen / 256 - entry["visible_fraction"].get<double>()) <= 2e-4);
        ++cases;
    }
    CHECK(cases == 14);
}

TEST_CASE("punctual lights reflect what they are defined to send", "[raytrace][truth]") {
    Scene scene;
    add_floor(scene, -4, 4, -4, 4, 0);
    const EmbreeScene rays(scene);
    TruthSettings settings;
    settings.surface = [](int, int) { return white(1, 0); };
    const auto radiance = [&](const Light& light) {
        const TruthAnswer answer = area_truth(rays, receivers_on_floor({{0, 0, 0}}, 0), light, settings);
        CHECK(answer.rays == 1);
        CHECK(answer.error(0, 0) == 0.0f);
        return double((*answer.radiance)(0, 0).x);
    };
    Light light = light_at(LightType::Point, {3, 4, 0});
    light.intensity = vec3(10);
    CHECK(radiance(light) == Approx(10.0 / 25 * 0.8 / pi));
    light.type = LightType::Directional;
    light.direction = glm::normalize(vec3(-3, -4, 0));
    CHECK(radiance(light) == Approx(10 * 0.8 / pi));
    light.type = LightType::Spot;
    light.outer_cone = 0.1f;
    CHECK(radiance(light) == Approx(10.0 / 25 * 0.8 / pi));
    light.direction = {0, -1, 0};
    CHECK(radiance(light) == 0.0);
}

// A mesh of two triangles is the rectangle; a texture's texels shine each by themselves.
TEST_CASE("a mesh light and a textured one give what their parts give", "[raytrace][truth]") {
    Scene scene;
    add_floor(scene, -4, 4, -4, 4, 0);
    add_floor(scene, -8, 0, -8, 8, 2);
    const EmbreeScene rays(scene);
    TruthSettings settings;
    settings.surface = [](int, int) { return white(1, 0); };
    const auto run = [&](const Light& light) {
        const TruthAnswer answer =
            area_truth(rays, receivers_on_floor(std::vector<vec3>(400, vec3(0)), 0), light, settings);
        double seen = 0, sum = 0;
        for (size_t i = 0; i < 400; ++i)
            seen += double(answer.visibility.values()[i]) / 400, sum += double(answer.radiance->values()[i].x) / 400;
        return std::pair(seen, sum);
    };
    const Light rectangle = light_at(LightType::Rectangle, {0.25f, 4, 0}, {2, 2});
    const auto [seen, radiance] = run(rectangle);
    Light mesh = rectangle;
    mesh.type = LightType::Mesh;
    const vec3 a(-0.75f, 4, -1), b(1.25f, 4, -1), c(1.25f, 4, 1), d(-0.75f, 4, 1);
    set_triangles(mesh, std::vector<vec3>{a, b, c, a, c, d});
    CHECK(mesh.direction == vec3(0, -1, 0));
    CHECK(mesh.position == rectangle.position);
    CHECK(surface_area(mesh) == 4.0f);
    CHECK(unshadowed_irradiance(mesh, vec3(0), vec3(0, 1, 0)).x ==
          Approx(unshadowed_irradiance(rectangle, vec3(0), vec3(0, 1, 0)).x).epsilon(0.02));
    CHECK(run(mesh).first == Approx(seen).margin(2e-4));
    CHECK(run(mesh).second == Approx(radiance).epsilon(5e-4));

    Light textured = light_at(LightType::TexturedRectangle, {0, 4, 0}, {2, 2});
    textured.tangent = {1, 0, 0};
    textured.texture = Image<vec3>(2, 1, vec3(0));
    textured.texture(0, 0) = vec3(7);
    CHECK(run(textured).first == Approx(0.5).margin(2e-4));
    CHECK(run(textured).second == 0.0); // the half that shines is behind the half-plane
    textured.texture(1, 0) = vec3(1);
    Light half = light_at(LightType::Rectangle, {0.5f, 4, 0}, {1, 2});
    half.tangent = {1, 0, 0};
    CHECK(run(textured).second == Approx(run(half).second).epsilon(5e-4));
}
