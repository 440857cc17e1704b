#include <catch2/catch.hpp>

#include <fstream>
#include <limits>

#include <nlohmann/json.hpp>

#include "core/adjacency.h"
#include "core/primitives.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

Scene scene_of(const MeshData& mesh) {
    Scene scene;
    scene.materials.emplace_back();
    add_object(scene, "mesh", mesh, dmat4(1.0), 0);
    return scene;
}

// The objects of a scene whose names are `name`, or all of them for "whole scene", as a scene of their own.
Scene part_of(const Scene& scene, const std::string& name) {
    if (name == "whole scene") return scene;
    Scene part = scene;
    part.triangles.clear();
    for (const Object& object : scene.objects)
        if (object.name == name)
            part.triangles.insert(part.triangles.end(), scene.triangles.begin() + object.first_triangle,
                                  scene.triangles.begin() + object.first_triangle + object.triangle_count);
    return part;
}

} // namespace

TEST_CASE("adjacency of a box: twelve faces, eighteen edges, two triangles at each") {
    const Adjacency box = build_adjacency(scene_of(box_mesh({0, 0, 0}, {1, 2, 3})));
    CHECK(box.positions.size() == 8);
    CHECK(box.triangles.size() == 12);
    REQUIRE(box.edges.size() == 18);
    CHECK(box.edge_triangles.size() == 36);
    CHECK(box.closed_manifold());
    for (size_t i = 0; i < box.edges.size(); ++i) {
        const Adjacency::Edge& edge = box.edges[i];
        CHECK(edge.start < edge.end);
        REQUIRE(edge.triangle_count == 2);
        for (std::uint32_t k = 0; k < 2; ++k) {
            const uvec3 t = box.triangles[box.edge_triangles[edge.first_triangle + k]];
            CHECK((t.x == edge.start || t.y == edge.start || t.z == edge.start));
            CHECK((t.x == edge.end || t.y == edge.end || t.z == edge.end));
        }
        if (i > 0) CHECK(std::pair(box.edges[i - 1].start, box.edges[i - 1].end) < std::pair(edge.start, edge.end));
    }
}

TEST_CASE("adjacency welds equal positions, negative zero included, and tells apart what is not equal") {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0f, 0, -0.0f}, {0, -1, 0}, {1, -0.0f, 0}, {1, 1e-30f, 0}};
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {3, 6, 2}};
    const Adjacency adjacency = build_adjacency(scene_of(mesh));
    CHECK(adjacency.positions.size() == 5);
    CHECK(adjacency.triangles[0].x == adjacency.triangles[1].x);
    CHECK(adjacency.triangles[0].y == adjacency.triangles[1].z);
    CHECK(adjacency.triangles[2].y != adjacency.triangles[0].y);
}

TEST_CASE("adjacency counts boundary, non-manifold and misoriented edges") {
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
    mesh.triangles = {{0, 1, 2}, {0, 3, 1}};
    Adjacency adjacency = build_adjacency(scene_of(mesh));
    CHECK(adjacency.boundary_edges == 4);
    CHECK(adjacency.misoriented_edges == 0);
    mesh.triangles[1] = {0, 1, 3};
    CHECK(build_adjacency(scene_of(mesh)).misoriented_edges == 1);
    mesh.triangles.push_back({0, 1, 4});
    adjacency = build_adjacency(scene_of(mesh));
    CHECK(adjacency.nonmanifold_edges == 1);
    CHECK(adjacency.boundary_edges == 6);
    CHECK(adjacency.misoriented_edges == 0);
}

TEST_CASE("degenerate triangles are marked and have no edges") {
    CHECK(zero_area({0, 0, 0}, {1, 1, 1}, {3, 3, 3}));
    CHECK(zero_area({0, 0, 0}, {1, 0, 0}, {0, 0, 0}));
    CHECK(zero_area({0, 0, 0}, {-0.0f, 0, 0}, {0, 1, 0}));
    // An area whose square underflows float.
    CHECK_FALSE(zero_area({0, 0, 0}, {1e-20f, 0, 0}, {0, 1e-20f, 0}));
    MeshData mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {1, 1, 3}};
    const Adjacency adjacency = build_adjacency(scene_of(mesh));
    CHECK(adjacency.degenerate == std::vector<std::uint8_t>{1, 0, 1});
    CHECK(adjacency.edges.size() == 3);
    CHECK(adjacency.triangles.size() == 3);
}

TEST_CASE("the fourteen shared meshes have the triangles, bounds and topology that their index states") {
    const std::string index_path = shared_path("scenes/index.json");
    if (index_path.empty()) return;
    const nlohmann::json index = nlohmann::json::parse(std::ifstream(index_path));
    CHECK(index.size() == 14);
    for (const auto& [name, facts] : index.items()) {
        CAPTURE(name);
        const Scene scene = load_scene(shared_path("scenes/" + facts["file"].get<std::string>()));
        // The index counts what the files store; triangles of zero area are left out at loading and reported.
        size_t dropped = 0;
        for (const std::string& warning : scene.warnings) {
            CAPTURE(warning);
            REQUIRE(warning.find("triangles of zero area") != std::string::npos);
            dropped += std::stoul(warning.substr(warning.find(": ") + 2));
        }
        CHECK(scene.triangles.size() + dropped == facts["triangles"].get<size_t>());
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(scene.bounds.minimum[axis] ==
                  Approx(facts["bbox_min"][static_cast<size_t>(axis)].get<double>()).margin(6e-6));
            CHECK(scene.bounds.maximum[axis] ==
                  Approx(facts["bbox_max"][static_cast<size_t>(axis)].get<double>()).margin(6e-6));
        }
        for (const auto& [part, topology] : facts["topology"].items()) {
            CAPTURE(part);
            const Scene object = part_of(scene, part);
            const Adjacency adjacency = build_adjacency(object);
            // In sponza one triangle has three collinear corners that differ: the index counts it, a shadow does not.
            // Its three neighbours gain a boundary there.
            const bool collinear = name == "sponza";
            CHECK(object.triangles.size() + (collinear ? 1u : 0u) == topology["triangles"].get<size_t>());
            CHECK(adjacency.boundary_edges == topology["boundary_edges"].get<std::uint32_t>() + (collinear ? 3u : 0u));
            CHECK(adjacency.nonmanifold_edges == topology["nonmanifold_edges"].get<std::uint32_t>());
            CHECK(adjacency.misoriented_edges == topology["misoriented_edges"].get<std::uint32_t>());
            CHECK(adjacency.closed_manifold() == topology["closed_2_manifold"].get<bool>());
            if (part == "whole scene" || facts["topology"].size() == 1)
                CHECK(adjacency.positions.size() == topology["welded_vertices"].get<size_t>());
        }
    }
}
