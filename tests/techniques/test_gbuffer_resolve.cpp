#include <catch2/catch.hpp>

#include <cmath>

#include "techniques/gbuffer_resolve.h"

using namespace gnomon;

namespace {

// One triangle in the plane z = −2 seen from the origin, wider than the view.
Scene wall(bool reversed) {
    Scene scene;
    MeshData mesh;
    mesh.positions = {{-20, -20, -2}, {20, -20, -2}, {0, 40, -2}};
    mesh.triangles = {reversed ? uvec3(0, 2, 1) : uvec3(0, 1, 2)};
    scene.materials.push_back({});
    add_object(scene, "wall", mesh, dmat4(1.0), 0);
    return scene;
}

Camera camera_at_origin() { return look_at(vec3(0), vec3(0, 0, -1), 1.0f); }

} // namespace

TEST_CASE("A receiver lies where the pixel's central ray meets its triangle") {
    for (const bool reversed : {false, true}) {
        const Scene scene = wall(reversed);
        GBuffer gbuffer;
        resolve_gbuffer(gbuffer, scene, camera_at_origin(), Image<std::uint32_t>(8, 6, 0u));
        for (int y = 0; y < 6; ++y)
            for (int x = 0; x < 8; ++x) {
                const CameraRay ray = camera_ray(camera_at_origin(), x + 0.5, y + 0.5, 8, 6);
                const vec3 expected(ray.direction * (-2.0 / ray.direction.z));
                CHECK(glm::length(gbuffer.receivers(x, y).position - expected) < 1e-6f);
                CHECK(gbuffer.receivers(x, y).geometric_normal == vec3(0, 0, 1));
                CHECK(gbuffer.shading_normal(x, y) == vec3(0, 0, 1));
                CHECK(gbuffer.depth(x, y) == 2.0f);
            }
    }
}

TEST_CASE("A pixel centre outside its triangle gets a receiver on the edge") {
    Scene scene;
    MeshData mesh;
    // The right edge is x = 0 in the plane z = −2; pixel centres of a 2×2 image lie at x ≠ 0.
    mesh.positions = {{0, -20, -2}, {0, 20, -2}, {-20, 0, -2}};
    mesh.triangles = {{0, 1, 2}};
    scene.materials.push_back({});
    add_object(scene, "half", mesh, dmat4(1.0), 0);
    GBuffer gbuffer;
    resolve_gbuffer(gbuffer, scene, camera_at_origin(), Image<std::uint32_t>(2, 2, 0u));
    CHECK(gbuffer.receivers(1, 0).position.x == 0.0f);
    CHECK(gbuffer.receivers(1, 0).position.z == -2.0f);
    CHECK(gbuffer.receivers(0, 0).position.x < -0.1f);
}

TEST_CASE("Shading normals are on the viewer's side, and a zero normal means flat") {
    Scene scene = wall(false);
    const vec3 tilted = glm::normalize(vec3(0.6f, 0, -1));
    scene.normals.assign(scene.positions.size(), tilted);
    GBuffer gbuffer;
    resolve_gbuffer(gbuffer, scene, camera_at_origin(), Image<std::uint32_t>(2, 2, 0u));
    CHECK(glm::length(gbuffer.shading_normal(0, 0) + tilted) < 1e-6f);
    scene.normals[1] = vec3(0);
    resolve_gbuffer(gbuffer, scene, camera_at_origin(), Image<std::uint32_t>(2, 2, 0u));
    CHECK(gbuffer.shading_normal(0, 0) == vec3(0, 0, 1));
}

TEST_CASE("A pixel without a triangle is empty") {
    GBuffer gbuffer;
    resolve_gbuffer(gbuffer, wall(false), camera_at_origin(), Image<std::uint32_t>(2, 2, no_triangle));
    CHECK_FALSE(gbuffer.receivers(0, 0).valid());
    CHECK(std::isinf(gbuffer.depth(0, 0)));
    CHECK(gbuffer.albedo(1, 1) == vec3(0));
}

TEST_CASE("The ray-traced camera pass shows the nearest triangle between the planes") {
    const Scene scene = wall(false);
    const EmbreeScene rays(scene);
    Camera camera = camera_at_origin();
    GBuffer gbuffer;
    trace_gbuffer(gbuffer, scene, camera, rays, 8, 6);
    CHECK(gbuffer.receivers(7, 5).triangle == 0);
    CHECK(gbuffer.depth(7, 5) == 2.0f);
    camera.near_plane = 2.5f;
    trace_gbuffer(gbuffer, scene, camera, rays, 8, 6);
    CHECK_FALSE(gbuffer.receivers(7, 5).valid());
}
