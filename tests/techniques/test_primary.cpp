#include <catch2/catch.hpp>

#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>

#include "tests/support.h"
#include "tests/techniques/shading.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

constexpr int width = 1280, height = 720;

// Distance in pixels from the centre of (x, y) to the nearest edge of a triangle as the camera sees it. Edges that
// reach behind the eye count with their whole line.
double edge_distance(const Frame& frame, std::uint32_t triangle, int x, int y) {
    const Scene& scene = frame.scene();
    const dmat4 to_clip = projection_matrix(frame.camera(), frame.aspect()) * view_matrix(frame.camera());
    const dvec2 center(x + 0.5, y + 0.5);
    dvec3 v[3]; // window x·w, y·w, w
    for (int c = 0; c < 3; ++c) {
        const dvec4 p = to_clip * dvec4(dvec3(scene.positions[scene.triangles[triangle][c]]), 1.0);
        v[c] = {(p.x + p.w) * 0.5 * width, (p.y + p.w) * 0.5 * height, p.w};
    }
    double nearest = 1e30;
    for (int e = 0; e < 3; ++e) {
        const dvec3 a = v[e], b = v[(e + 1) % 3];
        if (a.z > 0 && b.z > 0) {
            const dvec2 p = dvec2(a) / a.z, q = dvec2(b) / b.z, d = q - p;
            const double length2 = glm::dot(d, d);
            const double t = length2 > 0 ? std::clamp(glm::dot(center - p, d) / length2, 0.0, 1.0) : 0.0;
            nearest = std::min(nearest, glm::length(p + d * t - center));
        } else {
            const dvec3 line = glm::cross(a, b);
            const double length = std::hypot(line.x, line.y);
            if (length > 0) nearest = std::min(nearest, std::abs(glm::dot(line, dvec3(center, 1.0))) / length);
        }
    }
    return nearest;
}

// Distance along the pixel's ray to the triangle's plane.
double plane_distance(const Frame& frame, std::uint32_t triangle, int x, int y) {
    const Scene& scene = frame.scene();
    const auto at = [&](int c) { return dvec3(scene.positions[scene.triangles[triangle][c]]); };
    const CameraRay ray = camera_ray(frame.camera(), x + 0.5, y + 0.5, width, height);
    const dvec3 normal = glm::cross(at(1) - at(0), at(2) - at(0));
    return glm::dot(normal, at(0) - ray.origin) / glm::dot(normal, ray.direction);
}

bool explained(const Frame& frame, std::uint32_t a, std::uint32_t b, int x, int y) {
    for (const std::uint32_t triangle : {a, b})
        if (triangle != no_triangle && edge_distance(frame, triangle, x, y) <= 1.0 / 128) return true;
    if (a == no_triangle || b == no_triangle) return false;
    const double da = plane_distance(frame, a, x, y), db = plane_distance(frame, b, x, y);
    return std::abs(da - db) <= 1e-5 * std::max(std::abs(da), std::abs(db));
}

void compare_primary(const std::string& name, const Scene& scene) {
    const Frame raster(scene, scene.cameras[0], width, height, Primary::Raster);
    const Frame rays(scene, scene.cameras[0], width, height, Primary::Ray);
    std::int64_t seen = 0, differ = 0, unexplained = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::uint32_t a = raster.receivers()(x, y).triangle, b = rays.receivers()(x, y).triangle;
            seen += a != no_triangle || b != no_triangle;
            if (a == b) continue;
            ++differ;
            if (explained(raster, a, b, x, y)) continue;
            if (unexplained++ < 3) {
                CAPTURE(x, y, a, b);
                CHECK(false);
            }
        }
    const double agreement = 1.0 - static_cast<double>(differ) / static_cast<double>(width * height);
    WARN(name << ": same triangle on " << 100 * agreement << " % of the pixels, " << differ << " differ, "
              << unexplained << " unexplained");
    CHECK(seen > width * height / 50);
    CHECK(agreement >= 0.999);
    CHECK(unexplained == 0);
}

} // namespace

TEST_CASE("the rasterized and the ray-traced camera see the same triangles: builtin scenes") {
    for (const char* name : {"builtin:default", "builtin:tree", "builtin:fence", "builtin:colonnade"})
        compare_primary(name, load_scene(name));
}

TEST_CASE("the rasterized and the ray-traced camera see the same triangles: real meshes") {
    const std::string index_path = shared_path("scenes/index.json");
    if (index_path.empty()) return;
    const nlohmann::json index = nlohmann::json::parse(std::ifstream(index_path));
    for (const auto& [name, entry] : index.items())
        compare_primary(name, load_scene(shared_path("scenes/" + entry["file"].get<std::string>())));
}

TEST_CASE("every real mesh renders with every technique") {
    const std::string index_path = shared_path("scenes/index.json");
    if (index_path.empty()) return;
    const nlohmann::json index = nlohmann::json::parse(std::ifstream(index_path));
    for (const auto& [name, entry] : index.items()) {
        const Scene scene = load_scene(shared_path("scenes/" + entry["file"].get<std::string>()));
        Frame frame(scene, scene.cameras[0], 160, 90);
        const Light& light = scene.lights[0];
        const Image<float> truth = shade(frame, light, "truth:samples=64").values;
        for (const Entry& technique : techniques()) {
            INFO(name << " with " << technique.info.id);
            const bool is_truth = technique.info.id == "truth";
            const Visibility visibility = shade(frame, light, is_truth ? "truth:samples=4" : technique.info.id);
            for (const float v : visibility.values.values()) REQUIRE((v >= 0.0f && v <= 1.0f));
            // A shadow that has to do with the scene: nearer to the truth than 'everything lit' or 'everything dark'.
            const Image<float> lit(160, 90, 1.0f), dark(160, 90, 0.0f);
            const double error = facing_rmse(frame, light, visibility.values, truth);
            CHECK(error <= facing_rmse(frame, light, dark, truth) + 1e-9);
            CHECK(error < 0.5);
        }
    }
}
