#include <catch2/catch.hpp>

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/scene.h"
#include "tests/core/gltf_builder.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

Scene load(GltfBuilder& builder) { return load_scene(builder.write(temporary_folder() + "/test.glb")); }

std::vector<vec3> corners(const Scene& scene, std::uint32_t triangle) {
    const uvec3 t = scene.triangles[triangle];
    return {scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]};
}

bool near(vec3 a, vec3 b, float tolerance = 1e-6f) { return glm::length(a - b) <= tolerance; }

// A rectangle of 2 by 3 in the plane z = 0, counter-clockwise seen from +z, as its own node with an emissive material.
GltfBuilder lamp(const std::vector<vec3>& positions = {{-1, 0, 0}, {1, 0, 0}, {1, 3, 0}, {-1, 3, 0}}) {
    GltfBuilder builder = GltfBuilder::triangle();
    const int position = builder.positions(positions);
    const int index = builder.indices(std::vector<std::uint8_t>{0, 1, 2, 0, 2, 3});
    const int mesh = builder.mesh(position, index);
    builder.document["materials"] = {
        {{"emissiveFactor", {0.5, 0.25, 1.0}},
         {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 8.0}}}}}}};
    builder.document["meshes"][static_cast<size_t>(mesh)]["primitives"][0]["material"] = 0;
    builder.node({{"name", "lamp"}, {"mesh", mesh}});
    return builder;
}

} // namespace

TEST_CASE("glTF nodes: translation, rotation, scale and matrix down the hierarchy, one mesh under several nodes") {
    GltfBuilder builder = GltfBuilder::triangle();
    // A quarter turn about y takes x to −z; the child is moved in its parent's frame.
    builder.node({{"rotation", {0, std::sqrt(0.5), 0, std::sqrt(0.5)}},
                  {"translation", {10, 0, 0}},
                  {"scale", {2, 2, 2}},
                  {"children", {2}}});
    builder.node({{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1}}}, false);
    const Scene scene = load(builder);
    REQUIRE(scene.triangles.size() == 2);
    REQUIRE(scene.objects.size() == 2);
    CHECK(corners(scene, 0) == std::vector<vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    CHECK(near(corners(scene, 1)[0], {10, 0, -10}));
    CHECK(near(corners(scene, 1)[1], {10, 0, -12}));
    CHECK(near(corners(scene, 1)[2], {10, 2, -10}));
    CHECK(scene.objects[0].name == "triangle");
    CHECK(scene.triangle_objects == std::vector<std::uint32_t>{0, 1});
    CHECK(scene.name == "test.glb");
}

TEST_CASE("glTF: a mirroring node keeps triangles counter-clockwise from outside and normals outward") {
    GltfBuilder builder = GltfBuilder::triangle();
    const int normals = builder.positions({{0, 0, 1}, {0, 0, 1}, {0, 0, 1}});
    builder.document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = normals;
    builder.document["nodes"][0]["scale"] = {1, 1, -1};
    const Scene scene = load(builder);
    CHECK(near(geometric_normal(scene, 0), {0, 0, -1}));
    CHECK(near(scene.normals[0], {0, 0, -1}));
}

TEST_CASE("glTF: indices of 8, 16 and 32 bits, none at all, strips and fans") {
    const std::vector<vec3> square = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    GltfBuilder builder;
    const int position = builder.positions(square);
    const auto add = [&](int index, int mode) { builder.node({{"mesh", builder.mesh(position, index, mode)}}); };
    add(builder.indices(std::vector<std::uint8_t>{0, 1, 2}), 4);
    add(builder.indices(std::vector<std::uint16_t>{0, 1, 2}), 4);
    add(builder.indices(std::vector<std::uint32_t>{0, 1, 2}), 4);
    add(-1, 4);
    add(-1, 5);
    add(builder.indices(std::vector<std::uint8_t>{0, 1, 3, 2}), 6);
    add(-1, 0); // points
    const Scene scene = load(builder);
    REQUIRE(scene.triangles.size() == 8);
    for (std::uint32_t i = 0; i < 8; ++i) CHECK(near(geometric_normal(scene, i), {0, 0, 1}));
    for (std::uint32_t i = 0; i < 5; ++i)
        CHECK(corners(scene, i) == std::vector<vec3>{square[0], square[1], square[2]});
    CHECK(corners(scene, 5) == std::vector<vec3>{square[1], square[3], square[2]}); // second of the strip
    REQUIRE(scene.warnings.size() == 1);
    CHECK(scene.warnings[0].ends_with("test.glb: 1 primitives of points or lines are left out"));
}

TEST_CASE("glTF: interleaved vertices, normalized texture coordinates, integer positions and sparse replacement") {
    GltfBuilder builder;
    // 12 bytes of position, 4 bytes of texture coordinates as normalized u16, 16 apart.
    std::vector<std::uint32_t> interleaved;
    const std::vector<vec3> positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    for (const vec3& p : positions) {
        for (int i = 0; i < 3; ++i) interleaved.push_back(std::bit_cast<std::uint32_t>(p[i]));
        interleaved.push_back(0x0000ffffu); // u = 1, v = 0
    }
    const int view = builder.view(interleaved, 16);
    const int position = builder.accessor(view, 5126, 3, "VEC3"), uv = builder.accessor(view, 5123, 3, "VEC2", 12);
    builder.document["accessors"][static_cast<size_t>(uv)]["normalized"] = true;
    const int mesh = builder.mesh(position, -1);
    builder.document["meshes"][static_cast<size_t>(mesh)]["primitives"][0]["attributes"]["TEXCOORD_0"] = uv;
    builder.node({{"mesh", mesh}});

    const int quantized = builder.accessor(
        builder.view(std::vector<std::int16_t>{0, 0, 0, 0, 100, 0, 0, 0, 0, -100, 0, 0}, 8), 5122, 3, "VEC3");
    builder.node({{"mesh", builder.mesh(quantized, -1)}, {"scale", {0.01, 0.01, 0.01}}});

    const int sparse =
        builder.accessor(builder.document["accessors"][static_cast<size_t>(quantized)]["bufferView"], 5122, 3, "VEC3");
    const int which = builder.view(std::vector<std::uint8_t>{2}),
              value = builder.view(std::vector<std::int16_t>{0, 7, 0});
    builder.document["accessors"][static_cast<size_t>(sparse)]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", which}, {"componentType", 5121}}},
        {"values", {{"bufferView", value}}}};
    builder.node({{"mesh", builder.mesh(sparse, -1)}});

    const int zeros = builder.accessor(-1, 5126, 3, "VEC3"); // no bytes but the sparse ones
    const int two = builder.view(std::vector<std::uint16_t>{1, 2}),
              values = builder.view(std::vector<vec3>{{4, 0, 0}, {0, 4, 0}});
    builder.document["accessors"][static_cast<size_t>(zeros)]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", two}, {"componentType", 5123}}},
        {"values", {{"bufferView", values}}}};
    builder.node({{"mesh", builder.mesh(zeros, -1)}});

    const Scene scene = load(builder);
    REQUIRE(scene.triangles.size() == 4);
    CHECK(corners(scene, 0) == positions);
    CHECK(scene.uvs[0] == vec2(1, 0));
    CHECK(near(corners(scene, 1)[1], {1, 0, 0}));
    CHECK(near(corners(scene, 1)[2], {0, -1, 0}));
    CHECK(corners(scene, 2)[2] == vec3(0, 7, 0));
    CHECK(corners(scene, 3) == std::vector<vec3>{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}});
}

TEST_CASE("glTF: primitives that share one vertex buffer keep only their own vertices") {
    GltfBuilder builder;
    std::vector<vec3> positions;
    for (int i = 0; i < 30; ++i) positions.emplace_back(i, i % 3 == 1 ? 1 : 0, i % 3 == 2 ? 1 : 0);
    const int position = builder.positions(positions);
    for (std::uint8_t i = 0; i < 10; ++i) {
        const auto first = static_cast<std::uint8_t>(3 * i);
        const std::vector<std::uint8_t> triangle = {first, static_cast<std::uint8_t>(first + 1),
                                                    static_cast<std::uint8_t>(first + 2)};
        builder.node({{"mesh", builder.mesh(position, builder.indices(triangle))}});
    }
    const Scene scene = load(builder);
    CHECK(scene.positions == positions);
    for (std::uint32_t i = 0; i < 10; ++i)
        CHECK(corners(scene, i) == std::vector<vec3>{positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]});
}

TEST_CASE("glTF: punctual lights shine along −z of their node") {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"color", {1, 0.5, 0.25}}, {"intensity", 40}, {"range", 12}},
        {{"type", "spot"}, {"name", "torch"}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}},
        {{"type", "directional"}, {"intensity", 3}}};
    const auto light_node = [&](int light, nlohmann::json node) {
        node["extensions"]["KHR_lights_punctual"]["light"] = light;
        builder.node(node);
    };
    light_node(0, {{"name", "bulb"}, {"translation", {1, 2, 3}}});
    light_node(1, {{"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}, {"translation", {0, 5, 0}}});
    light_node(2, {{"name", "bulb"}});
    const Scene scene = load(builder);
    REQUIRE(scene.lights.size() == 3);
    const Light &point = scene.lights[0], &spot = scene.lights[1], &sun = scene.lights[2];
    CHECK(point.type == LightType::Point);
    CHECK(point.name == "bulb");
    CHECK(point.position == vec3(1, 2, 3));
    CHECK(point.intensity == vec3(40, 20, 10));
    CHECK(point.range == 12.0f);
    CHECK(spot.type == LightType::Spot);
    CHECK(spot.name == "torch");
    CHECK(near(spot.direction, {0, -1, 0}));
    CHECK(spot.inner_cone == 0.25f);
    CHECK(spot.outer_cone == 0.5f);
    CHECK(spot.range == infinity);
    CHECK(sun.type == LightType::Directional);
    CHECK(sun.name == "bulb-2"); // names tell lights apart
    CHECK(sun.direction == vec3(0, 0, -1));
    CHECK(sun.intensity == vec3(3));
}

TEST_CASE("glTF: extras.area makes an area light of a punctual one and wins over its type") {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}, {"intensity", 5}}};
    const auto add = [&](nlohmann::json area) {
        nlohmann::json node = {{"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}, {"scale", {2, 2, 2}}};
        node["extensions"]["KHR_lights_punctual"]["light"] = 0;
        node["extras"]["area"] = std::move(area);
        builder.node(node);
    };
    add({{"shape", "rectangle"}, {"size", {1.5, 0.5}}});
    add({{"shape", "disk"}, {"diameter", 0.75}});
    add({{"shape", "sphere"}, {"size", {0.5, 0.5}}});
    const Scene scene = load(builder);
    REQUIRE(scene.lights.size() == 3);
    CHECK(scene.lights[0].type == LightType::Rectangle);
    CHECK(near({scene.lights[0].size, 0}, {3, 1, 0}, 1e-5f)); // the node's scale counts
    CHECK(near(scene.lights[0].direction, {0, -1, 0}));
    CHECK(near(scene.lights[0].tangent, {1, 0, 0}));
    CHECK(scene.lights[0].intensity == vec3(5));
    CHECK(scene.lights[1].type == LightType::Disk);
    CHECK(near({scene.lights[1].size, 0}, {1.5f, 1.5f, 0}, 1e-5f));
    CHECK(scene.lights[2].type == LightType::Sphere);
    CHECK(near({scene.lights[2].size, 0}, {1, 1, 0}, 1e-5f));
}

TEST_CASE("glTF: an emissive quad is a rectangle light, seen but not casting") {
    GltfBuilder builder = lamp();
    builder.document["nodes"][1]["translation"] = {0, 0, 4};
    const Scene scene = load(builder);
    REQUIRE(scene.lights.size() == 1);
    const Light& light = scene.lights[0];
    CHECK(light.type == LightType::Rectangle);
    CHECK(light.name == "lamp");
    CHECK(near(light.position, {0, 1.5f, 4}));
    CHECK(near(light.direction, {0, 0, 1}));
    CHECK(std::abs(glm::dot(light.direction, light.tangent)) < 1e-6f);
    CHECK(light.size == (std::abs(light.tangent.x) > 0.5f ? vec2(2, 3) : vec2(3, 2)));
    CHECK(light.intensity == vec3(4, 2, 8));
    CHECK_FALSE(scene.objects[0].light_source);
    CHECK(scene.objects[1].light_source);
    CHECK(scene.warnings.empty());
    // The corners of the light's parametrization are those of the quad.
    std::vector<vec3> ends;
    for (const vec2 uv : {vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 1)})
        ends.push_back(light_point(light, uv.x, uv.y, vec3(0)));
    for (const vec3 corner : {vec3(-1, 0, 4), vec3(1, 0, 4), vec3(1, 3, 4), vec3(-1, 3, 4)})
        CHECK(std::any_of(ends.begin(), ends.end(), [&](vec3 end) { return near(end, corner, 1e-5f); }));
}

TEST_CASE("glTF: an emissive mesh whose node asks for it is a light") {
    GltfBuilder builder = lamp({{-1, 0, 0}, {1, 0, 0}, {2, 3, 0}, {0, 3, 0}});
    builder.document["nodes"][1]["extras"]["mesh_light"] = true;
    builder.document["nodes"][1]["translation"] = {0, 0, 4};
    builder.document["nodes"][1]["scale"] = {-1, 1, 1}; // mirrored: its front stays in front
    const Scene scene = load(builder);
    REQUIRE(scene.lights.size() == 1);
    const Light& light = scene.lights[0];
    CHECK(light.type == LightType::Mesh);
    CHECK(light.name == "lamp");
    CHECK(light.intensity == vec3(4, 2, 8));
    CHECK(light.triangles.size() == 2);
    CHECK(surface_area(light) == Approx(6));
    CHECK(near(light.position, {-0.5f, 1.5f, 4}));
    CHECK(near(light.direction, {0, 0, 1}));
    CHECK(scene.objects[1].light_source);
    CHECK(scene.warnings.empty());
}

TEST_CASE("glTF: an emissive mesh that is no rectangle is seen but gives no light") {
    for (const std::vector<vec3>& shape :
         std::vector<std::vector<vec3>>{{{-1, 0, 0}, {1, 0, 0}, {2, 3, 0}, {0, 3, 0}},      // a parallelogram
                                        {{-1, 0, 0}, {1, 0, 0}, {1, 3, 0.5f}, {-1, 3, 0}},  // not planar
                                        {{-1, 0, 0}, {1, 0, 0}, {0.5f, 3, 0}, {-1, 3, 0}}}) // a trapezoid
    {
        GltfBuilder builder = lamp(shape);
        const Scene scene = load(builder);
        REQUIRE(scene.lights.size() == 1);
        CHECK(scene.lights[0].name == "default");
        CHECK_FALSE(scene.objects[1].light_source);
        REQUIRE(scene.warnings.size() == 1);
        CHECK(scene.warnings[0].find("'lamp' is emissive but not a rectangle") != std::string::npos);
    }
}

TEST_CASE("glTF: perspective and orthographic cameras look along −z, planes are fitted where the file has none") {
    GltfBuilder builder = GltfBuilder::triangle();
    builder.document["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.75}, {"znear", 0.5}}}},
                                   {{"type", "orthographic"},
                                    {"name", "plan"},
                                    {"orthographic", {{"xmag", 2}, {"ymag", 1.5}, {"znear", 1}, {"zfar", 50}}}},
                                   {{"type", "perspective"}, {"perspective", {{"yfov", 0.75}, {"znear", 1e-9}}}}};
    builder.node({{"name", "eye"}, {"camera", 0}, {"translation", {0, 0, 8}}});
    builder.node({{"camera", 1}, {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}}, {"translation", {0, 20, 0}}});
    builder.node({{"camera", 2}, {"translation", {0, 0, 8}}});
    const Scene scene = load(builder);
    REQUIRE(scene.cameras.size() == 3);
    CHECK(scene.cameras[0].name == "eye");
    CHECK(scene.cameras[0].position == vec3(0, 0, 8));
    CHECK(scene.cameras[0].forward == vec3(0, 0, -1));
    CHECK(scene.cameras[0].up == vec3(0, 1, 0));
    CHECK(scene.cameras[0].vertical_fov == 0.75f);
    CHECK(scene.cameras[0].near_plane == 0.5f);
    CHECK(scene.cameras[0].far_plane > 8.0f);
    CHECK(scene.cameras[0].far_plane < 8.5f);
    CHECK(scene.cameras[1].name == "plan");
    CHECK(scene.cameras[1].orthographic);
    CHECK(scene.cameras[1].view_height == 3.0f);
    CHECK(near(scene.cameras[1].forward, {0, -1, 0}));
    CHECK(near(scene.cameras[1].up, {0, 0, -1}));
    CHECK(scene.cameras[1].near_plane == 1.0f);
    CHECK(scene.cameras[1].far_plane == 50.0f);
    CHECK(scene.cameras[2].near_plane >= 1e-4f * scene.cameras[2].far_plane);
}

TEST_CASE("glTF: base colour textures with their wrap modes, transparency and undecodable images warn") {
    GltfBuilder builder = GltfBuilder::triangle();
    // A PNG of 2 by 1 texels: red, and half-transparent blue.
    const std::string png =
        "data:image/"
        "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAADklEQVR4nGP4z8AAQg0AD3oDfnfpf5cAAAAASUVORK5CYII=";
    builder.document["images"] = {{{"uri", png}, {"name", "checks"}}, {{"uri", "data:image/png;base64,AAAA"}}};
    builder.document["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
    builder.document["textures"] = {{{"source", 0}, {"sampler", 0}}, {{"source", 1}}};
    builder.document["materials"] = {
        {{"name", "paint"},
         {"alphaMode", "BLEND"},
         {"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 1, 1}}, {"baseColorTexture", {{"index", 0}}}}}},
        {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 1}}}}}}};
    builder.document["meshes"][0]["primitives"][0]["material"] = 0;
    const Scene scene = load(builder);
    const Material& material = scene.material_of(0);
    CHECK(material.name == "paint");
    CHECK(material.base_color == vec3(0.5f, 0.25f, 1));
    REQUIRE(material.base_color_texture == 0);
    CHECK(scene.materials[1].base_color_texture == -1);
    const Texture& texture = scene.textures[0];
    CHECK(texture.wrap_u == Texture::Wrap::Clamp);
    CHECK(texture.wrap_v == Texture::Wrap::Mirror);
    REQUIRE(texture.image.width() == 2);
    REQUIRE(texture.image.height() == 1);
    CHECK(texture.image(0, 0) == glm::u8vec4(255, 0, 0, 255));
    REQUIRE(scene.warnings.size() == 2);
    CHECK(scene.warnings[0].find("images[1] cannot be decoded") != std::string::npos);
    CHECK(scene.warnings[1].find("1 materials with alphaMode") != std::string::npos);
}
