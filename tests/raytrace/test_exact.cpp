#include <catch2/catch.hpp>

#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/random.h"
#include "raytrace/exact.h"
#include "raytrace/truth.h"
#include "techniques/frame.h"
#include "tests/raytrace/shapes.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

constexpr double tolerance = 1e-5;

double exact(const Scene& scene, const Light& light, vec3 position, vec3 normal = {0, 1, 0}, std::uint32_t own = 0) {
    return exact_visibility(scene, build_clusters(scene), {position, normal, own}, light);
}

Light square_light() { return light_at(LightType::Rectangle, {0, 4, 0}, {2, 2}); }

// Moves and scales everything; the numbers are rounded to float afterwards.
void transform_scene(Scene& scene, Light& light, std::vector<vec3>& points, double scale, dvec3 offset) {
    const auto place = [&](vec3 p) { return vec3(dvec3(p) * scale + offset); };
    for (vec3& p : scene.positions) p = place(p);
    for (vec3& p : points) p = place(p);
    light.position = place(light.position);
    light.size = vec2(dvec2(light.size) * scale);
}

} // namespace

TEST_CASE("exact: visible fractions equal the shared reference values", "[raytrace][exact]") {
    const std::string path = shared_path("analytic/reference_values.json");
    if (path.empty()) return;
    Scene half_plane, open, disk;
    for (Scene* scene : {&half_plane, &open, &disk}) add_floor(*scene, -8, 8, -8, 8, 0);
    add_floor(half_plane, -64, 0, -64, 64, 2);
    std::vector<vec3> rim;
    constexpr int sides = 2048;
    for (int i = 0; i < sides; ++i) {
        const double angle = 2 * pi * i / sides;
        rim.push_back(vec3(dvec3(0.25 * std::cos(angle), 2, -0.25 * std::sin(angle))));
    }
    add_polygon(disk, rim);
    int cases = 0;
    const nlohmann::json reference = nlohmann::json::parse(std::ifstream(path));
    for (const auto& entry : reference.at("irradiance_of_unit_radiance")) {
        const std::string name = entry.at("case"), light_text = entry.at("light");
        const vec3 p(entry["receiver"][0].get<float>(), 0, 0);
        Light light = square_light();
        if (name.starts_with("disk_")) {
            float radius = 0, height = 0;
            if (std::sscanf(light_text.c_str(), "disk of radius %f at height %f", &radius, &height) != 2)
                REQUIRE(std::sscanf(light_text.c_str(), "disk of radius %f at y=%f", &radius, &height) == 2);
            light = light_at(LightType::Disk, {0, height, 0}, vec2(2 * radius));
        }
        const Scene& scene = name == "square_half_plane"              ? half_plane
                             : name == "disk_coaxial_blocker_on_axis" ? disk
                                                                      : open;
        INFO(name << " at x = " << p.x);
        CHECK(exact(scene, light, p) == Approx(entry.at("visible_fraction").get<double>()).margin(tolerance));
        ++cases;
    }
    CHECK(cases == 14);
}

// Strip |x| ≤ 1/4 and quadrant x, z ≤ 0 at half height: their images are twice as large.
TEST_CASE("exact: a strip and a corner hide what they project onto", "[raytrace][exact]") {
    Scene strip, corner;
    for (Scene* scene : {&strip, &corner}) add_floor(*scene, -8, 8, -8, 8, 0);
    add_floor(strip, -0.25f, 0.25f, -64, 64, 2);
    add_floor(corner, -64, 0, -64, 0, 2);
    for (const double x : {-1.4, -0.9, -0.3, 0.0, 0.2, 0.75, 1.3})
        for (const double z : {-1.2, -0.35, 0.0, 0.6, 1.1}) {
            const vec3 p{float(x), 0, float(z)};
            // The image of blocker coordinate b is 2 b − x.
            const auto length = [](double low, double high) {
                return std::max(0.0, std::min(high, 1.0) - std::max(low, -1.0));
            };
            INFO(x << ", " << z);
            CHECK(exact(strip, square_light(), p) == Approx(1 - length(-0.5 - x, 0.5 - x) / 2).margin(tolerance));
            CHECK(exact(corner, square_light(), p) ==
                  Approx(1 - length(-9e9, -x) * length(-9e9, -z) / 4).margin(tolerance));
        }
}

TEST_CASE("exact: a slanted half plane hides the closed-form part of a rectangle", "[raytrace][exact]") {
    // Edge z = x·slope at height 2 seen from the origin: the line z = slope·x through the light's centre halves it, and
    // moved sideways by d it hides the part of the square below z = slope·x − 2·slope·d.
    for (const float slope : {0.25f, 1.0f, 3.0f})
        for (const float d : {0.0f, 0.1f, 0.4f}) {
            Scene scene;
            add_floor(scene, -8, 8, -8, 8, 0);
            const vec3 along(20, 0, 20 * slope), start(d, 2, 0);
            add_polygon(scene, {start - along, start + along, start + along + vec3(60, 0, -20),
                                start - along + vec3(60, 0, -20)});
            // Area of {z < slope·x − c} in the square [−1,1]², by the integral of the clamped height.
            const double c = 2 * double(slope) * double(d);
            double hidden = 0;
            constexpr int steps = 200000;
            for (int i = 0; i < steps; ++i) {
                const double x = -1 + (i + 0.5) * 2 / steps;
                hidden += (std::clamp(double(slope) * x - c, -1.0, 1.0) + 1) * 2 / steps;
            }
            INFO("slope " << slope << ", shift " << d);
            CHECK(exact(scene, square_light(), {0, 0, 0}) == Approx(1 - hidden / 4).margin(tolerance));
        }
}

TEST_CASE("exact: the horizon cuts the light", "[raytrace][exact]") {
    Scene scene;
    add_polygon(scene, {{0, -8, -8}, {0, 8, -8}, {0, 8, 8}, {0, -8, 8}});
    // A wall in x = 0 that looks along +x: the part of the light with x > 0.
    for (const float shift : {-1.5f, -0.5f, 0.0f, 0.25f, 1.5f}) {
        Light light = square_light();
        light.position.x = shift;
        CHECK(exact(scene, light, {0, 0, 0.1f}, {1, 0, 0}, 0) ==
              Approx(std::clamp((1 + double(shift)) / 2, 0.0, 1.0)).margin(tolerance));
    }
}

TEST_CASE("exact: contact, flush geometry and boxes", "[raytrace][exact]") {
    Scene scene;
    add_floor(scene, -9, 9, -9, 9, 0);
    add_floor(scene, -9, 9, -9, 9, 4); // in the light's plane
    CHECK(exact(scene, square_light(), {0.7f, 0, -2}) == 1.0);
    CHECK(exact(scene, light_at(LightType::Disk, {0, 4, 0}, {2, 2}), {0.7f, 0, -2}) == Approx(1.0).margin(1e-9));
    add_floor(scene, -9, 9, -9, 9, 3.999f);
    CHECK(exact(scene, square_light(), {0.7f, 0, -2}) == 0.0);

    Scene box; // the light inside it, the receivers outside and at its foot
    add_floor(box, -9, 9, -9, 9, 0);
    add_box(box, {-2, 3, -2}, {2, 5, 2});
    for (const float x : {0.0f, 1.9f, 5.0f}) CHECK(exact(box, square_light(), {x, 0, 0.3f}) == 0.0);

    Scene standing; // a wall whose foot is the receiver: it hides the half of the light behind it
    add_floor(standing, -9, 9, -9, 9, 0);
    add_polygon(standing, {{0, 0, -20}, {0, 20, -20}, {0, 20, 20}, {0, 0, 20}});
    CHECK(exact(standing, square_light(), {1e-4f, 0, 0.2f}) == Approx(0.5).margin(1e-4 / 2 + tolerance));
    CHECK(exact(standing, square_light(), {0.5f, 0, 0.2f}) == Approx(0.5).margin(tolerance));
    CHECK(exact(standing, square_light(), {2.0f, 0, 0.2f}) == Approx(0.5).margin(tolerance));
}

TEST_CASE("exact: the same fraction at every scale and place", "[raytrace][exact]") {
    for (const double scale : {1e-3, 1.0, 37.0, 1e3, 1e6}) {
        Scene scene;
        add_floor(scene, -8, 8, -8, 8, 0);
        add_floor(scene, -8, 0, -8, 8, 2);
        Light light = square_light();
        std::vector<vec3> points{{0.3f, 0, 0.2f}, {-0.6f, 0, 0.7f}};
        const std::vector<vec3> original = points;
        transform_scene(scene, light, points, scale, dvec3(0.0));
        for (size_t i = 0; i < points.size(); ++i)
            CHECK(exact(scene, light, points[i]) == Approx(0.5 * (1.0 + double(original[i].x))).margin(tolerance));
    }
    // Far away the vertices themselves are rounded to 2⁻⁷ m, so the scene is as large as that allows: 2¹³ m.
    Scene scene;
    add_floor(scene, -8, 8, -8, 8, 0);
    add_floor(scene, -8, 0, -8, 8, 2);
    Light light = square_light();
    std::vector<vec3> points{{0.25f, 0, 0.125f}, {-0.5f, 0, 0.75f}};
    const std::vector<vec3> original = points;
    transform_scene(scene, light, points, 0x1p13, dvec3(1e5, -1e5, 1e5));
    for (size_t i = 0; i < points.size(); ++i)
        CHECK(exact(scene, light, points[i]) == Approx(0.5 * (1.0 + double(original[i].x))).margin(tolerance));
}

// Random rectangles at random heights: the union's area follows from the grid of their projected edges.
TEST_CASE("exact: overlapping rectangles count once", "[raytrace][exact]") {
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
        std::uint32_t next = 0;
        const auto number = [&] { return to_unit(hash(seed, next++, 5u)); };
        Scene scene;
        add_floor(scene, -8, 8, -8, 8, 0);
        const vec3 p(2 * number() - 1, 0, 2 * number() - 1);
        std::vector<double> cuts[2] = {{-1, 1}, {-1, 1}};
        std::vector<std::array<double, 4>> images;
        for (int i = 0; i < 12; ++i) {
            const float height = 0.5f + 3 * number(), x = 3 * number() - 1.5f, z = 3 * number() - 1.5f, w = number(),
                        d = number();
            add_floor(scene, x, x + w, z, z + d, height);
            const double start = 8 * 0x1p-19, k = (4 - start) / (double(height) - start); // rays start above the floor
            const auto image = [&](float q, float from) {
                return std::clamp(double(from) + (double(q) - double(from)) * k, -1.0, 1.0);
            };
            images.push_back({image(x, p.x), image(x + w, p.x), image(z, p.z), image(z + d, p.z)});
            for (size_t k2 = 0; k2 < 4; ++k2) cuts[k2 / 2].push_back(images.back()[k2]);
        }
        for (auto& list : cuts) std::sort(list.begin(), list.end());
        double hidden = 0;
        for (size_t i = 1; i < cuts[0].size(); ++i)
            for (size_t j = 1; j < cuts[1].size(); ++j) {
                const double x = (cuts[0][i - 1] + cuts[0][i]) / 2, z = (cuts[1][j - 1] + cuts[1][j]) / 2;
                const bool inside = std::any_of(images.begin(), images.end(), [&](const auto& r) {
                    return r[0] < x && x < r[1] && r[2] < z && z < r[3];
                });
                if (inside) hidden += (cuts[0][i] - cuts[0][i - 1]) * (cuts[1][j] - cuts[1][j - 1]);
            }
        INFO("seed " << seed);
        CHECK(exact(scene, square_light(), p) == Approx(1 - hidden / 4).margin(tolerance));
    }
}

TEST_CASE("exact: a sphere is its limb and a mesh the sum of its triangles", "[raytrace][exact]") {
    Scene scene;
    add_floor(scene, -8, 8, -8, 8, 0);
    add_floor(scene, -64, 0, -64, 64, 2);
    CHECK(exact(scene, light_at(LightType::Sphere, {0, 4, 0}, {2, 2}), {0, 0, 0}) == Approx(0.5).margin(tolerance));
    Light mesh;
    mesh.type = LightType::Mesh;
    const vec3 a(-1, 4, -1), b(1, 4, -1), c(1, 4, 1), d(-1, 4, 1);
    set_triangles(mesh, std::vector<vec3>{a, b, c, a, c, d});
    for (const float x : {-0.5f, 0.3f})
        CHECK(exact(scene, mesh, {x, 0, 0}) == Approx(0.5 * (1 + double(x))).margin(tolerance));
    Receivers receivers(1, 1);
    CHECK_THROWS_AS(
        exact_visibility(scene, build_clusters(scene), receivers, light_at(LightType::Point, {0, 4, 0}), nullptr),
        UsageError);
}

TEST_CASE("exact and sampled visibility agree on builtin scenes", "[raytrace][exact]") {
    for (const char* name : {"cornell", "fence", "stacked-plates", "staircase"}) {
        const Scene scene = load_scene(std::string("builtin:") + name);
        const Light& light = scene.lights.front();
        Frame frame(scene, scene.cameras.front(), 48, 27);
        const EmbreeScene rays(scene);
        const Image<float> sampled = area_visibility(rays, frame.receivers(), light, Pattern::Sobol, 4096, 0, nullptr);
        const Image<float> geometric =
            exact_visibility(scene, build_clusters(scene), frame.receivers(), light, nullptr);
        // An outline that crosses the light k times is met within the k·√N cells on it, and what is hidden here has a
        // few outlines; the mean has no bias.
        double largest = 0, sum = 0;
        for (size_t i = 0; i < sampled.size(); ++i) {
            const double difference = double(sampled.values()[i]) - double(geometric.values()[i]);
            largest = std::max(largest, std::abs(difference));
            sum += difference;
        }
        INFO(name << ": largest difference " << largest << ", mean " << sum / double(sampled.size()));
        CHECK(largest < 16.0 / 64.0 / 8.0);
        CHECK(std::abs(sum / double(sampled.size())) < 2e-5);
    }
}

namespace {

// Differences between 65536 samples and the exact answer, in error bars.
struct Differences {
    std::vector<double> penumbra;  // up to so many pixels, evenly spread
    std::vector<double> elsewhere; // as many of those that see all of the light or nothing
};

// Up to `most` of them, evenly spread.
std::vector<size_t> thinned(const std::vector<size_t>& pixels, size_t most) {
    const size_t count = std::min(most, pixels.size());
    std::vector<size_t> chosen;
    for (size_t i = 0; i < count; ++i) chosen.push_back(pixels[i * pixels.size() / count]);
    return chosen;
}

Differences differences_in_bars(const std::string& name, ivec2 size, size_t most) {
    const Scene scene = load_scene("builtin:" + name);
    const Light& light = scene.lights.front();
    Frame frame(scene, scene.cameras.front(), size.x, size.y);
    const Image<float> all = exact_visibility(scene, build_clusters(scene), frame.receivers(), light, nullptr);
    std::vector<size_t> partial, whole;
    for (size_t i = 0; i < all.size(); ++i)
        if (frame.receivers().values()[i].valid())
            (all.values()[i] > 0.0f && all.values()[i] < 1.0f ? partial : whole).push_back(i);
    std::vector<size_t> chosen = thinned(partial, most);
    const size_t partials = chosen.size();
    for (const size_t pixel : thinned(whole, most)) chosen.push_back(pixel);
    Receivers receivers(256, static_cast<int>((chosen.size() + 255) / 256)); // those at the end see nothing
    for (size_t i = 0; i < chosen.size(); ++i) receivers.values()[i] = frame.receivers().values()[chosen[i]];
    TruthSettings settings;
    settings.samples = 65536;
    const EmbreeScene rays(scene);
    const TruthAnswer answer = area_truth(rays, receivers, light, settings);
    Differences differences;
    for (size_t i = 0; i < chosen.size(); ++i)
        (i < partials ? differences.penumbra : differences.elsewhere)
            .push_back((double(answer.visibility.values()[i]) - double(all.values()[chosen[i]])) /
                       double(answer.error.values()[i]));
    return differences;
}

double share_within(const std::vector<double>& differences, double bars) {
    const auto within = std::count_if(differences.begin(), differences.end(),
                                      [&](double difference) { return std::abs(difference) <= bars; });
    return double(within) / double(differences.size());
}

double largest_of(const std::vector<double>& differences) {
    double largest = 0;
    for (const double difference : differences) largest = std::max(largest, std::abs(difference));
    return largest;
}

// The bar is a standard error, and on the safe side (docs/truth.md): within one, two and three of them are at least as
// many pixels as a normal distribution promises, and none is off by five, which would be one in 1.7 million. Where the
// light is seen as a whole or not at all, the bar is what may have fallen between samples that agree, and always holds.
void check_within_bars(const std::string& name, ivec2 size, size_t most) {
    const Differences found = differences_in_bars(name, size, most);
    double sum = 0, squares = 0;
    for (const double difference : found.penumbra) sum += difference, squares += difference * difference;
    const auto count = double(found.penumbra.size());
    double within[3];
    for (size_t i = 0; i < 3; ++i) within[i] = share_within(found.penumbra, double(i + 1));
    INFO(name << ": " << count << " pixels, root mean square " << std::sqrt(squares / count) << ", largest "
              << largest_of(found.penumbra) << ", mean " << sum / count << " error bars; within one, two and three "
              << within[0] << ", " << within[1] << ", " << within[2] << "; on " << found.elsewhere.size()
              << " pixels elsewhere, largest " << largest_of(found.elsewhere));
    CHECK(found.penumbra.size() >= 50);
    CHECK(found.elsewhere.size() >= 50);
    for (size_t i = 0; i < 3; ++i) CHECK(within[i] >= std::erf(double(i + 1) / std::sqrt(2.0)));
    CHECK(largest_of(found.penumbra) < 5.0);
    CHECK(std::sqrt(squares / count) < 1.0);
    CHECK(std::abs(sum / count) < 5.0 / std::sqrt(count));
    CHECK(largest_of(found.elsewhere) < 1.0);
}

} // namespace

TEST_CASE("exact and 65536 samples agree within the error bar", "[raytrace][exact]") {
    for (const char* name : {"cornell", "fence", "stacked-plates", "staircase"}) check_within_bars(name, {96, 54}, 100);
}

TEST_CASE("exact and 65536 samples agree within the error bar on all pixels", "[.long]") {
    for (const char* name : {"cornell", "fence", "stacked-plates", "staircase"})
        check_within_bars(name, {320, 180}, 100'000);
}
