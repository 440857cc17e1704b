#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "core/primitives.h"
#include "core/scene.h"
#include "core/scene_load.h"

using namespace gnomon;

namespace {

MeshData triangle() {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 2}};
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

Scene with_box(vec3 minimum, vec3 maximum) {
    Scene scene;
    scene.materials.emplace_back();
    add_object(scene, "box", box_mesh(minimum, maximum), dmat4(1.0), 0);
    finish_scene(scene, "test");
    return scene;
}

bool near(vec3 a, vec3 b, float tolerance = 1e-6f) { return glm::length(a - b) <= tolerance; }

} // namespace

TEST_CASE("add_object transforms in double and rounds once, the identity keeps every bit") {
    Scene scene;
    MeshData mesh = triangle();
    mesh.positions[1] = {0.1f, -0.0f, 1e-42f};
    add_object(scene, "a", mesh, dmat4(1.0), 0);
    CHECK(std::signbit(scene.positions[1].y));
    CHECK(scene.positions[1].z == 1e-42f);
    add_object(scene, "b", mesh, translation({1e6, 0, 0}) * scaling({3, 3, 3}), 0);
    CHECK(scene.positions[4].x == static_cast<float>(3.0 * static_cast<double>(0.1f) + 1e6));
    CHECK(scene.triangles[1] == uvec3(3, 4, 5));
    CHECK(scene.objects[1].first_triangle == 1);
}

TEST_CASE("add_object: normals follow the inverse transpose and stay outward under mirroring and flattening") {
    Scene scene;
    MeshData mesh = triangle();
    for (vec3& normal : mesh.normals) normal = glm::normalize(vec3(1, 1, 0));
    add_object(scene, "stretched", mesh, scaling({2, 1, 1}), 0);
    CHECK(near(scene.normals[0], glm::normalize(vec3(0.5f, 1, 0))));
    add_object(scene, "mirrored", mesh, scaling({-1, 1, 1}), 0);
    CHECK(near(scene.normals[3], glm::normalize(vec3(-1, 1, 0))));
    CHECK(near(geometric_normal(scene, 1), {0, 0, 1})); // as before: its corners are listed the other way around
    add_object(scene, "flattened", mesh, scaling({1, 1, 0}), 0);
    CHECK(scene.normals[6] == vec3(0)); // nothing is left of a normal in the plane: flat shading
    add_object(scene, "without", {mesh.positions, {}, {}, mesh.triangles}, dmat4(1.0), 0);
    CHECK(scene.normals.size() == scene.positions.size());
    CHECK(scene.normals.back() == vec3(0));
}

TEST_CASE("add_object refuses indices out of range and positions that are not finite, naming the object") {
    Scene scene;
    MeshData mesh = triangle();
    mesh.triangles.push_back({0, 1, 3});
    CHECK_THROWS_WITH(add_object(scene, "kettle", mesh, dmat4(1.0), 0),
                      "triangle 1 of 'kettle' uses vertex 3, but there are only 3 vertices; "
                      "repair the index buffer");
    mesh = triangle();
    mesh.positions[2].y = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH(add_object(scene, "kettle", mesh, dmat4(1.0), 0),
                      "the position of vertex 2 of 'kettle' is not finite; repair the mesh or its transform");
    CHECK_THROWS_AS(add_object(scene, "kettle", triangle(), scaling({1e300, 1, 1}), 0), InputError);
}

TEST_CASE("geometric normals are unit for triangles of any size and zero for degenerate ones") {
    for (const double size : {1e-30, 1e-6, 1.0, 1e18}) {
        Scene scene;
        add_object(scene, "t", triangle(), scaling({size, size, size}), 0);
        CHECK(geometric_normal(scene, 0) == vec3(0, 0, 1));
    }
    Scene scene;
    MeshData mesh = triangle();
    mesh.positions[2] = {2, 0, 0};
    add_object(scene, "t", mesh, dmat4(1.0), 0);
    CHECK(geometric_normal(scene, 0) == vec3(0));
}

TEST_CASE("textures are sampled bilinearly in linear colour, row 0 at v = 0, under their wrap modes") {
    Texture texture;
    texture.image = Image<glm::u8vec4>(2, 2, glm::u8vec4(0, 0, 0, 255));
    texture.image(1, 0) = {255, 188, 0, 255}; // right of the top row
    CHECK(sample_texture(texture, {0.75f, 0.25f}).x == Approx(1.0));
    CHECK(sample_texture(texture, {0.75f, 0.25f}).y == Approx(std::pow((188.0 / 255 + 0.055) / 1.055, 2.4)));
    CHECK(sample_texture(texture, {0.5f, 0.25f}).x == Approx(0.5)); // half way, after conversion to linear
    CHECK(sample_texture(texture, {0.75f, 0.75f}).x == Approx(0.0));
    CHECK(sample_texture(texture, {-0.25f, 3.25f}).x == Approx(1.0)); // repeats
    CHECK(sample_texture(texture, {1.0f, 0.25f}).x == Approx(0.5));   // across the seam
    texture.wrap_u = Texture::Wrap::Clamp;
    CHECK(sample_texture(texture, {9.0f, 0.25f}).x == Approx(1.0));
    CHECK(sample_texture(texture, {-9.0f, 0.25f}).x == Approx(0.0));
    texture.wrap_u = Texture::Wrap::Mirror;
    CHECK(sample_texture(texture, {1.25f, 0.25f}).x == Approx(1.0));
    CHECK(sample_texture(texture, {-0.75f, 0.25f}).x == Approx(1.0));
    for (const float odd : {1e30f, -1e30f, infinity, std::numeric_limits<float>::quiet_NaN()})
        CHECK(std::isfinite(sample_texture(texture, {odd, odd}).x));
    CHECK(sample_texture(Texture{}, {0, 0}) == vec4(1));
}

TEST_CASE("the default camera sees the whole scene between its planes, the default light gives an irradiance of pi") {
    for (const auto& [minimum, maximum] : std::vector<std::pair<vec3, vec3>>{{{-1, 0, -1}, {1, 2, 1}},
                                                                             {{100, 100, 100}, {101, 150, 100.5f}},
                                                                             {{-5000, 0, -3}, {5000, 1, 3}},
                                                                             {{0, 0, 0}, {1e-3f, 1e-3f, 1e-3f}}}) {
        const Scene scene = with_box(minimum, maximum);
        REQUIRE(scene.cameras.size() == 1);
        const Camera& camera = scene.cameras[0];
        const dmat4 clip = projection_matrix(camera, 1.0) * view_matrix(camera);
        for (int i = 0; i < 8; ++i) {
            const dvec4 p = clip * dvec4(dvec3(scene.bounds.corner(i)), 1.0);
            for (int axis = 0; axis < 3; ++axis) CHECK(std::abs(p[axis]) < p.w);
        }
        CHECK(camera.near_plane >= 0.9999e-4f * camera.far_plane);
        REQUIRE(scene.lights.size() == 1);
        const Light& light = scene.lights[0];
        const vec3 center = scene.bounds.center();
        CHECK(unshadowed_irradiance(light, center, -light.direction).x == Approx(pi).epsilon(1e-3));
        CHECK(near(light.direction, direction_to_light(light, center) * -1.0f, 1e-4f));
        CHECK(light.position.y > scene.bounds.maximum.y);
        CHECK(light.size.x / scene.bounds.diagonal() == Approx(0.18));
    }
}

TEST_CASE("fitted planes hold the scene, and a camera that looks away gets a valid range all the same") {
    const Scene scene = with_box({-1, -1, -1}, {1, 1, 1});
    Camera camera = look_at({0, 0, 11}, {0, 0, 0}, 0.5f);
    fit_planes(camera, scene.bounds);
    CHECK(camera.near_plane < 10.0f);
    CHECK(camera.near_plane > 9.9f);
    CHECK(camera.far_plane > 12.0f);
    CHECK(camera.far_plane < 12.1f);
    camera.position = {0, 0, 0.5f};
    fit_planes(camera, scene.bounds);
    CHECK(camera.near_plane == Approx(1e-4f * camera.far_plane));
    camera.forward = {0, 0, 1};
    camera.position = {0, 0, 50};
    fit_planes(camera, scene.bounds);
    CHECK(camera.near_plane > 0.0f);
    CHECK(camera.near_plane < camera.far_plane);
}

TEST_CASE("transformed lights turn, move and grow with their frame") {
    Light light;
    light.type = LightType::Rectangle;
    light.size = {1, 2};
    const Light moved = transformed(light, translation({1, 2, 3}) * rotation(90, {0, 0, 1}) * scaling({3, 1, 5}));
    CHECK(near(moved.position, {1, 2, 3}));
    CHECK(near(moved.direction, {1, 0, 0}));
    CHECK(near(moved.tangent, {0, 1, 0}));
    CHECK(near({moved.size, 0}, {3, 10, 0}, 1e-5f));
}
