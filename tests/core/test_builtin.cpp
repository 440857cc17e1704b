#include <catch2/catch.hpp>

#include <set>

#include "core/adjacency.h"
#include "core/builtin/builtin.h"
#include "core/primitives.h"

using namespace gnomon;

namespace {

double signed_volume(const MeshData& mesh) {
    double sum = 0;
    for (const uvec3 t : mesh.triangles)
        sum +=
            glm::dot(dvec3(mesh.positions[t.x]), glm::cross(dvec3(mesh.positions[t.y]), dvec3(mesh.positions[t.z]))) /
            6;
    return sum;
}

MeshData mesh_of(const Scene& scene, const Object& object) {
    MeshData mesh;
    mesh.positions = scene.positions;
    mesh.triangles.assign(scene.triangles.begin() + object.first_triangle,
                          scene.triangles.begin() + object.first_triangle + object.triangle_count);
    return mesh;
}

Adjacency adjacency_of(const MeshData& mesh) {
    Scene scene;
    scene.materials.emplace_back();
    add_object(scene, "mesh", mesh, dmat4(1.0), 0);
    return build_adjacency(scene);
}

bool same_geometry(const Scene& a, const Scene& b) { return a.positions == b.positions && a.triangles == b.triangles; }

} // namespace

TEST_CASE("closed primitives are watertight, wound outwards and of the right volume") {
    const auto check = [](const MeshData& mesh, double volume, double tolerance) {
        CHECK(adjacency_of(mesh).closed_manifold());
        CHECK(signed_volume(mesh) == Approx(volume).epsilon(tolerance));
        CHECK((mesh.normals.empty() || mesh.normals.size() == mesh.positions.size()));
        for (const vec3& normal : mesh.normals) CHECK(glm::length(normal) == Approx(1.0f));
    };
    check(box_mesh({-1, 0, 2}, {1, 3, 4}), 12.0, 1e-6);
    check(sphere_mesh(2.0f, 128, 64), 4.0 / 3.0 * pi * 8.0, 0.01);
    check(sphere_mesh(1.0f, 3, 2), 0.866, 0.01); // two tetrahedra on an equilateral triangle
    check(cylinder_mesh(0.5f, 0.5f, 2.0f, 128), pi * 0.5, 0.01);
    check(cylinder_mesh(1.0f, 0.0f, 3.0f, 128), pi, 0.01);
    check(cylinder_mesh(0.0f, 1.0f, 3.0f, 128), pi, 0.01);
    check(torus_mesh(2.0f, 0.5f, 128, 64), 2 * pi * pi * 2.0 * 0.25, 0.01);
    check(rod_mesh({1, 2, 3}, {1, 2, 7}, 0.5f, 128), pi, 0.01);
    const std::vector<vec3> bend = {{0, 0, 0}, {0, 2, 0}, {2, 2, 0}};
    const std::vector<float> radii(3, 0.1f);
    CHECK(adjacency_of(tube_mesh(bend, radii, 16)).closed_manifold());
    CHECK(signed_volume(tube_mesh(bend, radii, 16)) > 0.08);
}

TEST_CASE("smooth primitives have normals on the side that their faces show") {
    for (const MeshData& mesh : {sphere_mesh(1, 16, 8), cylinder_mesh(1, 0.5f, 2, 16), torus_mesh(1, 0.3f, 24, 12),
                                 rod_mesh({0, 0, 0}, {1, 1, 1}, 0.1f, 12)})
        for (const uvec3 t : mesh.triangles) {
            const vec3 a = mesh.positions[t.x], face = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
            for (int corner = 0; corner < 3; ++corner) CHECK(glm::dot(face, mesh.normals[t[corner]]) > 0.0f);
        }
}

TEST_CASE("sheets face up, a grid's heights stay in range and depend on its seed alone") {
    const MeshData plane = plane_mesh({4, 2}, 3, 5);
    CHECK(plane.triangles.size() == 30);
    for (const uvec3 t : plane.triangles) {
        const vec3 a = plane.positions[t.x];
        CHECK(glm::cross(plane.positions[t.y] - a, plane.positions[t.z] - a).y > 0.0f);
    }
    const MeshData grid = grid_mesh({4, 4}, 20, 0.5f, 0.7f, 3);
    for (const vec3& p : grid.positions) CHECK((p.y >= 0.0f && p.y <= 0.5f));
    CHECK(grid.positions == grid_mesh({4, 4}, 20, 0.5f, 0.7f, 3).positions);
    CHECK(grid.positions != grid_mesh({4, 4}, 20, 0.5f, 0.7f, 4).positions);
}

TEST_CASE(
    "every builtin scene is deterministic, lit by an area light, seen by a camera, and closed except for its sheets") {
    const std::set<std::string> sheets = {"ground",  "floor",     "pavement",  "leaves",     "half-plane",
                                          "ceiling", "back wall", "left wall", "right wall", "lamp"};
    std::set<std::string> names;
    for (const BuiltinScene& builtin : builtin_scenes()) {
        CAPTURE(builtin.name);
        CHECK(names.insert(builtin.name).second);
        CHECK_FALSE(builtin.title.empty());
        CHECK_FALSE(builtin.parameters.empty());
        const Scene scene = load_scene("builtin:" + builtin.name);
        CHECK(scene.name == "builtin:" + builtin.name);
        CHECK(scene.warnings.empty());
        CHECK(scene.cameras.size() == 1);
        REQUIRE(scene.lights.size() == 1);
        CHECK(is_area(scene.lights[0]));
        CHECK(same_geometry(scene, load_scene("builtin:" + builtin.name)));
        for (const Object& object : scene.objects) {
            CAPTURE(object.name);
            const MeshData mesh = mesh_of(scene, object);
            if (sheets.contains(object.name)) continue;
            CHECK(adjacency_of(mesh).closed_manifold());
            CHECK(signed_volume(mesh) > 0.0);
        }
        // The camera looks at something lit: its middle ray's target lies in front of it, and the light above the
        // scene's middle.
        const Camera& camera = scene.cameras[0];
        CHECK(glm::dot(scene.bounds.center() - camera.position, camera.forward) > 0.0f);
    }
    CHECK(names.size() == 9);
}

TEST_CASE("builtin scenes take parameters, a misspelt one or a wrong value is a usage error") {
    CHECK(load_scene("builtin:wire-ball:meridians=3,parallels=0").triangles.size() <
          load_scene("builtin:wire-ball").triangles.size());
    CHECK_FALSE(same_geometry(load_scene("builtin:tree:seed=2"), load_scene("builtin:tree")));
    CHECK_THROWS_WITH(load_scene("builtin:fense"), "there is no builtin scene 'fense'; did you mean 'fence'?");
    CHECK_THROWS_WITH(load_scene("builtin:tree:sed=1"),
                      "builtin scene 'tree' has no parameter 'sed'; did you mean 'seed'?");
    CHECK_THROWS_AS(load_scene("builtin:tree:levels=99"), UsageError);
    CHECK_THROWS_AS(load_scene("builtin:half-plane:edge_height=5"), UsageError);
    // The low end of every range builds.
    for (const BuiltinScene& builtin : builtin_scenes())
        for (const ParameterInfo& parameter : builtin.parameters) {
            CAPTURE(builtin.name, parameter.name);
            const std::string low = detail::to_text(parameter, parameter.minimum);
            if (parameter.name != "light_height")
                CHECK_NOTHROW(load_scene("builtin:" + builtin.name + ":" + parameter.name + "=" + low));
        }
}

TEST_CASE("builtin:half-plane is the configuration of the closed forms") {
    const Scene scene = load_scene("builtin:half-plane");
    const Light& light = scene.lights[0];
    CHECK(light.type == LightType::Rectangle);
    CHECK(light.position == vec3(0, 4, 0));
    CHECK(light.direction == vec3(0, -1, 0));
    CHECK(light.size == vec2(2, 2));
    CHECK(light.intensity == vec3(1));
    CHECK(unshadowed_irradiance(light, vec3(0), {0, 1, 0}).x == Approx(0.23083679773017057).epsilon(2e-3));
    REQUIRE(scene.objects[1].name == "half-plane");
    CHECK(scene.objects[1].bounds.maximum.x == 0.0f);
    CHECK(scene.objects[1].bounds.minimum.y == 2.0f);
    CHECK(scene.objects[1].bounds.maximum.y == 2.0f);
    // With a slope, the edge runs through (slope·z, b, z), and the blocker lies at smaller x.
    const Scene sloped = load_scene("builtin:half-plane:slope=0.25");
    int on_edge = 0;
    for (const vec3& p : mesh_of(sloped, sloped.objects[1]).positions)
        if (p.y == 2.0f) {
            CHECK(p.x <= 0.25f * p.z);
            on_edge += p.x == 0.25f * p.z;
        }
    CHECK(on_edge == 2);
}

TEST_CASE("builtin:cornell has the published lamp, visible and not casting") {
    const Scene scene = load_scene("builtin:cornell");
    const Object& lamp = scene.objects.back();
    CHECK(lamp.light_source);
    CHECK(scene.materials[lamp.material].emission == scene.lights[0].intensity);
    CHECK(glm::length(lamp.bounds.minimum - vec3(2.13f, 5.487f, 2.27f)) < 1e-5f);
    CHECK(glm::length(lamp.bounds.maximum - vec3(3.43f, 5.487f, 3.32f)) < 1e-5f);
    CHECK(geometric_normal(scene, lamp.first_triangle) == vec3(0, -1, 0));
    // Walls face inward.
    const vec3 middle(2.75f, 2.7f, 2.8f);
    for (const Object& object : scene.objects)
        if (object.name.find("wall") != std::string::npos || object.name == "floor" || object.name == "ceiling")
            CHECK(glm::dot(geometric_normal(scene, object.first_triangle), middle - object.bounds.center()) > 0.0f);
}
