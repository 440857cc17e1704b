#include <catch2/catch.hpp>

#include <functional>
#include <limits>

#include "core/scene.h"
#include "tests/core/gltf_builder.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

// What load_scene says about a file, which must be one line that names it.
std::string error_of_file(const std::string& name, const std::string& bytes) {
    static const std::string folder = temporary_folder();
    const std::string path = folder + "/" + name;
    write_file(path, bytes);
    try {
        load_scene(path);
    } catch (const InputError& error) {
        const std::string message = error.what();
        CHECK(message.find('\n') == std::string::npos);
        CHECK(message.starts_with(path + ": "));
        return message.substr(std::min(message.size(), path.size() + 2));
    }
    return "no error";
}

// The same, about a good file with one thing changed.
std::string error_of(const std::function<void(GltfBuilder&)>& damage) {
    GltfBuilder builder = GltfBuilder::triangle();
    damage(builder);
    return error_of_file("broken.glb", builder.glb());
}

using nlohmann::json;

} // namespace

TEST_CASE("a missing file and an unknown extension are errors that name the file") {
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.glb"), "/nowhere/scene.glb: there is no such file; check the path");
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.obj"),
                      "/nowhere/scene.obj: a scene is a file ending in .gltf, .glb or .json, or builtin:NAME");
    CHECK_THROWS_AS(load_scene(temporary_folder()), InputError);
}

TEST_CASE("a GLB file cut short at any byte is an error, never a crash") {
    const std::string whole = GltfBuilder::triangle().glb();
    for (size_t length = 0; length < whole.size(); ++length) {
        const std::string message = error_of_file("cut.glb", whole.substr(0, length));
        CHECK(message != "no error");
    }
    CHECK(error_of_file("cut.glb", whole.substr(0, whole.size() - 7)).starts_with("the file ends after "));
    CHECK(error_of_file("cut.glb", "glTF\x02") ==
          "the file ends inside its header, after 5 bytes; copy or export it again");
}

TEST_CASE("any single byte of a GLB file may be wrong without a crash") {
    const std::string whole = GltfBuilder::triangle().glb();
    const std::string path = temporary_folder() + "/flipped.glb";
    for (size_t i = 0; i < whole.size(); ++i) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ "\x01\x80\xff"[i % 3]);
        write_file(path, damaged);
        try {
            const Scene scene = load_scene(path);
            CHECK(scene.triangles.size() == 1);
        } catch (const InputError& error) {
            CHECK(std::string(error.what()).find('\n') == std::string::npos);
        }
    }
}

TEST_CASE("files that are not what their name says are errors") {
    CHECK(error_of_file("text.glb", "{\"asset\": {\"version\": \"2.0\"}}") ==
          "not a binary glTF file (it does not start with 'glTF'); a text file needs the extension .gltf");
    CHECK(error_of_file("noise.glb", std::string(100, '\xfe')) ==
          "not a binary glTF file (it does not start with 'glTF'); export it again");
    CHECK(
        error_of_file("text.gltf", "{\"asset\": {\n \"version\" 2}}").starts_with("not valid JSON: line 2, column 12"));
    CHECK(error_of_file("empty.gltf", "").starts_with("not valid JSON: line 1, column 1"));
    CHECK(error_of_file("deep.gltf", std::string(100000, '[')) ==
          "the JSON is nested deeper than 200 levels; flatten it");
    CHECK(error_of_file("list.gltf", "[]") == "the document must be an object");
}

TEST_CASE("glTF references that point at nothing name their place") {
    CHECK(error_of([](GltfBuilder& b) { b.document["nodes"][0]["mesh"] = 7; }) ==
          "nodes[0].mesh is 7, but there are only 1 meshes");
    CHECK(error_of([](GltfBuilder& b) { b.document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9; }) ==
          "meshes[0].primitives[0].attributes.POSITION is 9, but there are only 2 accessors");
    CHECK(error_of([](GltfBuilder& b) { b.document["meshes"][0]["primitives"][0]["indices"] = -1; }) ==
          "meshes[0].primitives[0].indices must be a whole number that is not negative");
    CHECK(error_of([](GltfBuilder& b) { b.document["meshes"][0]["primitives"][0]["material"] = 0; }) ==
          "meshes[0].primitives[0].material is 0, but there are only 0 materials");
    CHECK(error_of([](GltfBuilder& b) { b.document["accessors"][0]["bufferView"] = 5; }) ==
          "accessors[0].bufferView is 5, but there are only 2 bufferViews");
    CHECK(error_of([](GltfBuilder& b) { b.document["bufferViews"][1]["buffer"] = 1; }) ==
          "bufferViews[1].buffer is 1, but there are only 1 buffers");
    CHECK(error_of([](GltfBuilder& b) { b.document["nodes"][0]["children"] = {4}; }) ==
          "nodes[0].children[0] is 4, but there are only 1 nodes");
    CHECK(error_of([](GltfBuilder& b) {
              b.document["images"] = {{{"bufferView", 8}, {"mimeType", "image/png"}}};
          }) == "images[0].bufferView is 8, but there are only 2 bufferViews");
    CHECK(error_of([](GltfBuilder& b) { b.document["scene"] = 3; }) == "scene is 3, but there are only 1 scenes");
    CHECK(error_of([](GltfBuilder& b) { b.document["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0; }) ==
          "the document has no 'extensions'");
}

TEST_CASE("glTF ranges that leave their buffer are errors") {
    CHECK(error_of([](GltfBuilder& b) { b.document["accessors"][0]["count"] = 4; })
              .starts_with("accessors[0] reads 4 elements of 12 bytes from byte 0 on, which reaches beyond the 36 "
                           "bytes of bufferViews[0]"));
    CHECK(error_of([](GltfBuilder& b) {
              b.document["accessors"][0]["count"] = 9007199254740992.0;
          }).starts_with("accessors[0] reads "));
    CHECK(error_of([](GltfBuilder& b) {
              b.document["accessors"][0]["byteOffset"] = 4;
          }).starts_with("accessors[0] reads 3 elements"));
    CHECK(error_of([](GltfBuilder& b) {
              b.document["bufferViews"][0]["byteLength"] = 4000;
          }).starts_with("bufferViews[0] covers bytes 0 to 4000, but buffers[0] has 42 bytes"));
    CHECK(error_of([](GltfBuilder& b) { b.document["bufferViews"][0]["byteStride"] = 8; }) ==
          "accessors[0] does not fit the byteStride 8 of bufferViews[0]");
    CHECK(error_of([](GltfBuilder& b) {
              b.document["accessors"][0]["sparse"] = {
                  {"count", 1},
                  {"indices", {{"bufferView", 1}, {"byteOffset", 6}, {"componentType", 5123}}},
                  {"values", {{"bufferView", 0}}}};
          }).starts_with("accessors[0].sparse reads 1 elements of 2 bytes"));
    CHECK(error_of([](GltfBuilder& b) {
              const int index = b.view(std::vector<std::uint16_t>{3});
              b.document["accessors"][0]["sparse"] = {{"count", 1},
                                                      {"indices", {{"bufferView", index}, {"componentType", 5123}}},
                                                      {"values", {{"bufferView", 0}}}};
          }) == "meshes[0].primitives[0].attributes.POSITION.sparse replaces element 3 of 3");
}

TEST_CASE("glTF meshes that cannot be drawn are errors") {
    CHECK(error_of([](GltfBuilder& b) {
              b.document["meshes"][0]["primitives"][0]["indices"] = b.indices(std::vector<std::uint16_t>{0, 1, 3});
          }) == "meshes[0].primitives[0]: triangle 0 of 'triangle' uses vertex 3, but there are only 3 vertices; "
                "repair the index buffer");
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
        CHECK(error_of([&](GltfBuilder& b) {
                  b.document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
                      b.positions({{0, 0, 0}, {1, bad, 0}, {0, 1, 0}});
              }) == "meshes[0].primitives[0]: the position of vertex 1 of 'triangle' is not finite; repair the mesh or "
                    "its transform");
    CHECK(error_of([](GltfBuilder& b) {
              b.document["nodes"][0]["scale"] = {1e30, 1e30, 1e30};
              b.document["nodes"][0]["name"] = "big";
              b.document["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
                  b.positions({{0, 0, 0}, {1e20f, 0, 0}, {0, 1, 0}});
          }).find("the position of vertex 1 of 'big' is not finite") != std::string::npos);
    CHECK(error_of([](GltfBuilder& b) {
              b.document["meshes"][0]["primitives"][0]["attributes"].erase("POSITION");
              b.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 0;
          }) == "meshes[0].primitives[0] has no POSITION; export it again");
    CHECK(error_of([](GltfBuilder& b) {
              b.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = b.positions({{0, 0, 1}});
          }) == "meshes[0].primitives[0].attributes.NORMAL (accessors[2]) has 1 elements for 3 positions");
    CHECK(error_of([](GltfBuilder& b) { b.document["nodes"][0].erase("mesh"); }) ==
          "the scene is empty: it has no triangle with an area; add a mesh to it");
    CHECK(error_of([](GltfBuilder& b) {
              b.document["nodes"][0]["scale"] = {0, 1, 1};
          }) == "the scene is empty: it has no triangle with an area; add a mesh to it");
    CHECK(error_of([](GltfBuilder& b) { b.document["nodes"][0]["children"] = {0}; }) ==
          "nodes[0] is reached twice; the nodes of glTF must form a tree, export the file again");
}

TEST_CASE("names with line breaks do not break messages into lines") {
    CHECK(error_of([](GltfBuilder& b) {
              b.document["nodes"][0]["name"] = "two\nlines";
              b.document["meshes"][0]["primitives"][0]["indices"] = b.indices(std::vector<std::uint16_t>{0, 1, 3});
          }).find("of 'two lines' uses vertex 3") != std::string::npos);
    CHECK(error_of_file("keys.json", "{\"a\\nb\": 1}").starts_with("a b is not a known key"));
}

TEST_CASE("glTF features that would change the geometry are refused by name") {
    CHECK(error_of([](GltfBuilder& b) { b.document["extensionsRequired"] = {"KHR_draco_mesh_compression"}; }) ==
          "extensionsRequired[0] is 'KHR_draco_mesh_compression', which is not supported; export the file again "
          "without mesh compression");
    CHECK(error_of([](GltfBuilder& b) {
              b.document["extensionsRequired"] = {"KHR_materials_unlit", "EXT_mesh_gpu_instancing"};
          }) == "extensionsRequired[1] is 'EXT_mesh_gpu_instancing', which is not supported; export the file again "
                "without this extension");
    CHECK(error_of([](GltfBuilder& b) { b.document["asset"]["version"] = "1.0"; }) ==
          "asset.version is '1.0', which is not supported; export it as glTF 2.0");
}

TEST_CASE("broken lights in glTF name their place") {
    const auto with_light = [](const json& light, const json& area) {
        return [=](GltfBuilder& b) {
            b.document["extensions"]["KHR_lights_punctual"]["lights"] = json::array({light});
            b.document["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
            if (!area.is_null()) b.document["nodes"][0]["extras"]["area"] = area;
        };
    };
    CHECK(error_of(with_light({{"type", "area"}}, nullptr)) ==
          "extensions.KHR_lights_punctual.lights[0].type must be 'point', 'spot' or 'directional'");
    CHECK(error_of(with_light({{"type", "point"}, {"intensity", -1}}, nullptr)) ==
          "extensions.KHR_lights_punctual.lights[0].intensity must be a number between 0 and 1e+30");
    CHECK(error_of(with_light({{"type", "point"}}, {{"shape", "rectangel"}})) ==
          "nodes[0].extras.area.shape must be 'rectangle', 'disk', 'sphere', 'textured-rectangle' or 'mesh'");
    CHECK(error_of(with_light({{"type", "point"}}, {{"shape", "rectangle"}, {"sise", {1, 1}}})) ==
          "nodes[0].extras.area.sise is not a known key; did you mean 'size'?");
    CHECK(error_of(with_light({{"type", "point"}}, {{"shape", "disk"}, {"diameter", 0}})) ==
          "nodes[0].extras.area.diameter must be a number between 1e-06 and 1e+30");
}

TEST_CASE("triangles of zero area are left out and counted") {
    GltfBuilder builder = GltfBuilder::triangle();
    const int position = builder.positions({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}});
    builder.node(
        {{"name", "slivers"},
         {"mesh", builder.mesh(position, builder.indices(std::vector<std::uint8_t>{0, 1, 2, 0, 1, 3, 1, 1, 3}))}});
    builder.node({{"name", "only slivers"},
                  {"mesh", builder.mesh(position, builder.indices(std::vector<std::uint8_t>{0, 1, 2}))}});
    const Scene scene = load_scene(builder.write(temporary_folder() + "/slivers.glb"));
    CHECK(scene.triangles.size() == 2);
    REQUIRE(scene.objects.size() == 2);
    CHECK(scene.objects[1].name == "slivers");
    CHECK(scene.objects[1].first_triangle == 1);
    CHECK(scene.objects[1].triangle_count == 1);
    CHECK(scene.objects[1].bounds.maximum == vec3(1, 1, 0));
    CHECK(scene.triangle_objects == std::vector<std::uint32_t>{0, 1});
    CHECK(scene.warnings == std::vector<std::string>{"slivers.glb: 3 triangles of zero area are left out"});
}
