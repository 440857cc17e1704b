#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/random.h"
#include "core/scene.h"
#include "tests/core/gltf_builder.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

Scene load(const std::string& text, const std::string& folder = temporary_folder()) {
    write_file(folder + "/scene.json", text);
    return load_scene(folder + "/scene.json");
}

std::string error_of(const std::string& text) {
    const std::string path = temporary_folder() + "/scene.json";
    write_file(path, text);
    try {
        load_scene(path);
    } catch (const InputError& error) {
        const std::string message = error.what();
        CHECK(message.find('\n') == std::string::npos);
        REQUIRE(message.starts_with(path + ": "));
        return message.substr(path.size() + 2);
    }
    return "no error";
}

// A document with a floor, and more members.
std::string with(const std::string& members) { return R"({"objects": [{"shape": "plane"}], )" + members + "}"; }
std::string object(const std::string& text) { return R"({"objects": [)" + text + "]}"; }

bool near(vec3 a, vec3 b, float tolerance = 1e-5f) { return glm::length(a - b) <= tolerance; }

} // namespace

TEST_CASE("a scene document: shapes, materials and transforms") {
    const Scene scene = load(R"({
        "name": "yard", "description": "free text",
        "materials": {"brick": {"base_color": [0.6, 0.2, 0.1]}, "glow": {"base_color": 0, "emission": [1, 2, 3]}},
        "objects": [
            {"shape": "plane", "size": [10, 6], "segments": 2, "material": "brick", "name": "floor"},
            {"shape": "box", "size": [1, 2, 3], "translate": [5, 0, 0], "rotate": [0, 90, 0], "material": "glow"},
            {"shape": "sphere", "radius": 2, "slices": 8, "stacks": 4, "scale": 0.5, "material": {"base_color": 0.25}},
            {"shape": "cylinder", "bottom_radius": 1, "top_radius": 0, "height": 2, "segments": 8},
            {"shape": "torus", "radius": 1, "tube_radius": 0.25, "segments": 8, "sides": 6},
            {"shape": "tube", "points": [[0, 0, 0], [0, 1, 0], [1, 1, 0]], "radius": 0.1, "sides": 5},
            {"shape": "grid", "size": 4, "segments": 3, "height": 1, "bump_size": 1, "seed": 9},
            {"shape": "box", "matrix": [0,1,0,0, -1,0,0,0, 0,0,1,0, 7,8,9,1]},
            {"shape": "box", "rotate": {"axis": [0, 0, 2], "angle": 90}, "scale": [1, 1, 2]}
        ]})");
    CHECK(scene.name == "yard");
    REQUIRE(scene.objects.size() == 9);
    CHECK(scene.objects[0].name == "floor");
    CHECK(scene.objects[0].triangle_count == 8);
    CHECK(near(scene.objects[0].bounds.maximum, {5, 0, 3}));
    CHECK(scene.materials[scene.objects[0].material].base_color == vec3(0.6f, 0.2f, 0.1f));
    CHECK(scene.objects[1].name == "box-1");
    CHECK(near(scene.objects[1].bounds.minimum, {3.5f, 0, -0.5f}));
    CHECK(near(scene.objects[1].bounds.maximum, {6.5f, 2, 0.5f}));
    CHECK(scene.materials[scene.objects[1].material].emission == vec3(1, 2, 3));
    CHECK(near(scene.objects[2].bounds.maximum, {1, 1, 1}));
    CHECK(scene.materials[scene.objects[2].material].base_color == vec3(0.25f));
    CHECK(scene.materials[scene.objects[3].material].base_color == Material{}.base_color);
    CHECK(scene.objects[3].bounds.maximum.y == 2.0f);
    CHECK(scene.objects[6].triangle_count == 18);
    // x goes to y, y to −x: the box on its base lies on its side.
    CHECK(near(scene.objects[7].bounds.minimum, {6, 7.5f, 8.5f}));
    CHECK(near(scene.objects[8].bounds.minimum, {-1, -0.5f, -1}));
    CHECK(scene.cameras.at(0).name == "default");
    CHECK(scene.lights.at(0).name == "default");
}

TEST_CASE("a scene document: lights of every type") {
    const Scene scene = load(with(R"("lights": [
        {"type": "point", "position": [1, 2, 3], "intensity": 7, "range": 20},
        {"type": "spot", "position": [0, 4, 0], "target": [0, 0, 4], "inner_cone": 10, "outer_cone": 30, "intensity": [1, 2, 3]},
        {"type": "directional", "direction": [0, -2, 0]},
        {"type": "rectangle", "name": "lamp", "position": [0, 5, 0], "size": [2, 3], "tangent": [0, 0.5, 1], "visible": true, "intensity": 4},
        {"type": "disk", "name": "lamp", "position": [0, 5, 0], "diameter": 2},
        {"type": "sphere", "position": [0, 5, 0], "diameter": 3}])"));
    REQUIRE(scene.lights.size() == 6);
    CHECK(scene.lights[0].type == LightType::Point);
    CHECK(scene.lights[0].range == 20.0f);
    CHECK(scene.lights[0].intensity == vec3(7));
    CHECK(near(scene.lights[1].direction, glm::normalize(vec3(0, -1, 1))));
    CHECK(scene.lights[1].outer_cone == Approx(pi / 6));
    CHECK(scene.lights[2].direction == vec3(0, -1, 0));
    CHECK(scene.lights[3].size == vec2(2, 3));
    CHECK(scene.lights[3].tangent == vec3(0, 0, 1));
    CHECK(scene.lights[3].direction == vec3(0, -1, 0));
    CHECK(scene.lights[4].name == "lamp-2");
    CHECK(scene.lights[4].size == vec2(2, 2));
    CHECK(scene.lights[5].type == LightType::Sphere);
    REQUIRE(scene.objects.size() == 2); // the visible surface of the rectangle
    CHECK(scene.objects[0].light_source);
    CHECK(near(scene.objects[0].bounds.minimum, {-1.5f, 5, -1}));
    CHECK(geometric_normal(scene, 0) == vec3(0, -1, 0));
    CHECK(scene.material_of(0).emission == vec3(4));
}

TEST_CASE("a scene document: an object that shines is a mesh light") {
    const Scene scene = load(object(
        R"({"shape": "sphere", "radius": 0.5, "translate": [0, 2, 0], "name": "globe", "light": true,
            "material": {"emission": [4, 2, 1], "roughness": 0.25, "metallic": 0.5}}, {"shape": "plane"})"));
    REQUIRE(scene.lights.size() == 1);
    const Light& light = scene.lights[0];
    CHECK(light.name == "globe");
    CHECK(light.type == LightType::Mesh);
    CHECK(light.intensity == vec3(4, 2, 1));
    CHECK(near(light.position, {0, 2, 0}));
    CHECK(light.triangles.size() == scene.objects[0].triangle_count);
    CHECK(surface_area(light) == Approx(4 * pi * 0.25).epsilon(0.01));
    for (const LightTriangle& t : light.triangles) CHECK(glm::dot(t.normal, t.a - light.position) > 0.0f);
    CHECK(scene.objects[0].light_source);
    CHECK_FALSE(scene.objects[1].light_source);
    CHECK(scene.materials[0].roughness == 0.25f);
    CHECK(scene.materials[0].metallic == 0.5f);
    CHECK(error_of(object(R"({"shape": "box", "light": true})")) ==
          "objects[0].light needs a material with an 'emission' above 0");
    // Points lie on the triangles, as many on each as its share of the area: the lower half gets half of them, to 5
    // standard deviations of 32.
    int low = 0;
    for (std::uint32_t i = 0; i < 4096; ++i) {
        const vec3 p = light_point(light, to_unit(hash(i, 1)), to_unit(hash(i, 2)), vec3(0));
        CHECK(std::abs(glm::length(p - light.position) - 0.5f) < 0.01f);
        low += p.y < 2.0f;
    }
    CHECK(low == Approx(2048).margin(160));
}

TEST_CASE("a scene document: cameras") {
    const Scene scene = load(with(R"("cameras": [
        {"name": "eye", "position": [0, 3, 8], "target": [0, 0, 0], "fov": 40},
        {"position": [0, 9, 0], "direction": [0, -1, 0], "up": [1, 0, 0], "view_height": 5, "near": 1, "far": 20},
        {"position": [0, 1, 8], "near": 2}, {"position": [0, 1, 8], "far": 100}])"));
    REQUIRE(scene.cameras.size() == 4);
    CHECK(scene.cameras[0].name == "eye");
    CHECK(scene.cameras[0].vertical_fov == Approx(40 * pi / 180));
    CHECK(near(scene.cameras[0].forward, glm::normalize(vec3(0, -3, -8))));
    CHECK(scene.cameras[0].near_plane < scene.cameras[0].far_plane);
    CHECK(scene.cameras[1].orthographic);
    CHECK(scene.cameras[1].view_height == 5.0f);
    CHECK(scene.cameras[1].up == vec3(1, 0, 0));
    CHECK(scene.cameras[1].near_plane == 1.0f);
    CHECK(scene.cameras[1].far_plane == 20.0f);
    CHECK(scene.cameras[2].forward == vec3(0, 0, -1));
    CHECK(scene.cameras[2].near_plane == 2.0f);
    CHECK(scene.cameras[3].far_plane == 100.0f);
    CHECK(scene.cameras[3].near_plane > 1.0f);
}

TEST_CASE("a scene document places glTF files, relative to itself, and builtin scenes") {
    const std::string folder = temporary_folder();
    std::filesystem::create_directory(folder + "/models");
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
    nlohmann::json light = {{"name", "bulb"}, {"translation", {0, 1, 0}}};
    light["extensions"]["KHR_lights_punctual"]["light"] = 0;
    builder.node(light);
    builder.write(folder + "/models/a.glb");
    const std::string objects =
        R"("objects": [{"gltf": "models/a.glb", "translate": [0, 0, 5]}, {"builtin": "cornell", "scale": 2}])";
    const Scene scene = load("{" + objects + "}", folder);
    CHECK(scene.name == "scene.json");
    CHECK(scene.triangles.size() == 37);
    CHECK(scene.positions[0] == vec3(0, 0, 5));
    REQUIRE(scene.lights.size() == 2);
    CHECK(scene.lights[0].name == "bulb");
    CHECK(scene.lights[0].position == vec3(0, 1, 5));
    CHECK(near({scene.lights[1].size, 0}, {2.6f, 2.1f, 0}));
    CHECK(scene.objects.back().light_source);
    REQUIRE(scene.cameras.size() == 1);
    CHECK(near(scene.cameras[0].position, {5.56f, 5.46f, -16}));
    CHECK(scene.materials[scene.objects[1].material].name == "white");

    // A document with lights of its own leaves those of its parts behind, unless asked; a lamp that is off casts a
    // shadow.
    const std::string own = R"("lights": [{"type": "point", "position": [0, 9, 0], "name": "own"}], )";
    const Scene lit = load("{" + own + objects + "}", folder);
    REQUIRE(lit.lights.size() == 1);
    CHECK(lit.lights[0].name == "own");
    CHECK_FALSE(lit.objects.back().light_source);
    const Scene both =
        load("{" + own + R"("objects": [{"builtin": "cornell", "lights": true, "cameras": false}]})", folder);
    CHECK(both.lights.size() == 2);
    CHECK(both.cameras[0].name == "default");
}

TEST_CASE("errors in scene documents name the place and what would be right") {
    CHECK(error_of(with(R"("lights": [{"type": "rectangle", "position": [0, 1, 0], "sise": 1}])")) ==
          "lights[0].sise is not a known key; did you mean 'size'?");
    CHECK(error_of(with(R"("light": [])")) == "light is not a known key; did you mean 'lights'?");
    CHECK(error_of(with(R"("lights": [{"type": "rectangel"}])")) ==
          "lights[0].type is 'rectangel', which is no type of light; did you mean 'rectangle'?");
    CHECK(error_of(with(R"("lights": [{"type": "rectangle", "position": [0, 1, 0]}])")) == "lights[0] has no 'size'");
    CHECK(error_of(with(R"("lights": [{"type": "point"}])")) == "lights[0] has no 'position'");
    CHECK(error_of(with(R"("lights": [{"type": "point", "position": [0, 1]}])")) ==
          "lights[0].position must be an array of three numbers");
    CHECK(error_of(with(R"("lights": [{"type": "disk", "position": [0, 1, 0], "diameter": -1}])")) ==
          "lights[0].diameter must be a number between 1e-06 and 1e+09");
    CHECK(error_of(with(R"("lights": [{"type": "directional", "position": [0, 1, 0]}])"))
              .starts_with("lights[0].position is not a known key"));
    CHECK(error_of(with(R"("lights": [{"type": "spot", "position": [0, 1, 0], "target": [0, 1, 0]}])")) ==
          "lights[0].target must differ from the position");
    CHECK(
        error_of(
            with(
                R"("lights": [{"type": "textured-rectangle", "position": [0, 1, 0], "size": 1, "image": "none.png"}])"))
            .starts_with("lights[0].image"));
    CHECK(error_of(with(R"("cameras": [{"position": [0, 1, 0], "up": [0, 0, -3]}])")) ==
          "cameras[0].up must not be zero or along the view");
    CHECK(error_of(with(R"("cameras": [{"position": [0, 1, 0], "fov": 180}])")) ==
          "cameras[0].fov must be a number between 0.1 and 179");
    CHECK(error_of("{}") == "the document has no 'objects'");
    CHECK(error_of(R"({"objects": []})") == "the scene is empty: it has no triangle with an area; add a mesh to it");
    CHECK(error_of(object(R"({"shape": "spere"})")) ==
          "objects[0].shape is 'spere', which is no shape; did you mean 'sphere'?");
    CHECK(error_of(object(R"({"name": "x"})")) == "objects[0] must have one of 'shape', 'gltf' and 'builtin'");
    CHECK(error_of(object(R"({"shape": "box", "radius": 1})")).starts_with("objects[0].radius is not a known key"));
    CHECK(error_of(object(R"({"shape": "box", "material": "gold"})")) ==
          "objects[0].material is 'gold', which is not among the materials");
    CHECK(error_of(object(R"({"shape": "box", "scale": [1, 0, 1]})")) == "objects[0].scale must not be zero");
    CHECK(error_of(object(R"({"shape": "box", "rotate": "left"})")) ==
          "objects[0].rotate must be an array of three numbers");
    CHECK(error_of(object(R"({"shape": "sphere", "slices": 2.5})")) ==
          "objects[0].slices must be a whole number between 3 and 4096");
    CHECK(error_of(object(R"({"shape": "box", "matrix": [1], "scale": 2})")) ==
          "objects[0].scale cannot stand beside 'matrix'; leave one of them out");
    CHECK(error_of(object(R"({"builtin": "fense"})")) ==
          "objects[0].builtin: there is no builtin scene 'fense'; did you mean 'fence'?");
    const std::string missing = error_of(object(R"({"gltf": "none.glb"})"));
    CHECK(missing.starts_with("objects[0].gltf: "));
    CHECK(missing.ends_with("none.glb: there is no such file; check the path"));
    CHECK(error_of("{\"objects\": [\n  {\"shape\": box}]}").starts_with("not valid JSON: line 2, column 13"));
    CHECK(error_of(R"({"objects": [{"shape": "box", "translate": [1e999, 0, 0]}]})").starts_with("not valid JSON"));
}

TEST_CASE("the example documents load without warnings") {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(std::string(GNOMON_SOURCE) + "/data/scenes")) {
        if (entry.path().extension() != ".json") continue;
        CAPTURE(entry.path());
        const Scene scene = load_scene(entry.path().string());
        CHECK(scene.warnings.empty());
        CHECK(scene.cameras[0].name != "default");
        CHECK(scene.lights[0].name != "default");
        ++count;
    }
    CHECK(count >= 3);
}
