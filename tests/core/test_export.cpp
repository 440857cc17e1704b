#include <catch2/catch.hpp>

#include <bit>
#include <fstream>
#include <sstream>

#include "core/builtin/builtin.h"
#include "core/primitives.h"
#include "core/scene.h"
#include "core/scene_load.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

std::string slurp(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

template <class Vector> bool same_bits(Vector a, Vector b) {
    bool same = true;
    for (int i = 0; i < Vector::length(); ++i)
        same = same && std::bit_cast<std::uint32_t>(a[i]) == std::bit_cast<std::uint32_t>(b[i]);
    return same;
}
bool same_bits(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }

// Exactly equal; a direction's −0 may come back as 0.
void check_same(const Light& a, const Light& b) {
    CAPTURE(a.name);
    CHECK(a.name == b.name);
    CHECK(a.type == b.type);
    CHECK(a.position == b.position);
    CHECK(a.direction == b.direction);
    CHECK(a.tangent == b.tangent);
    CHECK(same_bits(a.intensity, b.intensity));
    CHECK(same_bits(a.size, b.size));
    CHECK(same_bits(a.range, b.range));
    if (a.type == LightType::Spot) {
        CHECK(same_bits(a.inner_cone, b.inner_cone));
        CHECK(same_bits(a.outer_cone, b.outer_cone));
    }
    REQUIRE(a.triangles.size() == b.triangles.size());
    for (size_t i = 0; i < a.triangles.size(); ++i) {
        CHECK(same_bits(a.triangles[i].a, b.triangles[i].a));
        CHECK(same_bits(a.triangles[i].b, b.triangles[i].b));
        CHECK(same_bits(a.triangles[i].c, b.triangles[i].c));
        CHECK(same_bits(a.triangles[i].area_up_to, b.triangles[i].area_up_to));
    }
    REQUIRE(a.texture.size() == b.texture.size());
    for (size_t i = 0; i < a.texture.size(); ++i) CHECK(same_bits(a.texture.data()[i], b.texture.data()[i]));
}

void check_same(const Camera& a, const Camera& b) {
    CHECK(a.name == b.name);
    CHECK(a.orthographic == b.orthographic);
    CHECK(a.position == b.position);
    CHECK(a.forward == b.forward);
    CHECK(a.up == b.up);
    if (a.orthographic)
        CHECK(same_bits(a.view_height, b.view_height));
    else
        CHECK(same_bits(a.vertical_fov, b.vertical_fov));
    CHECK(same_bits(a.near_plane, b.near_plane));
    CHECK(same_bits(a.far_plane, b.far_plane));
}

void check_same(const Scene& a, const Scene& b) {
    REQUIRE(a.triangles.size() == b.triangles.size());
    size_t different = 0;
    for (size_t i = 0; i < a.triangles.size(); ++i)
        for (int corner = 0; corner < 3; ++corner) {
            const std::uint32_t v = a.triangles[i][corner], w = b.triangles[i][corner];
            different += !same_bits(a.positions[v], b.positions[w]);
            if (!a.normals.empty()) different += !same_bits(a.normals[v], b.normals[w]);
            if (!a.uvs.empty()) different += !same_bits(a.uvs[v], b.uvs[w]);
        }
    CHECK(different == 0);
    CHECK(a.triangle_objects == b.triangle_objects);
    CHECK(same_bits(a.bounds.minimum, b.bounds.minimum));
    CHECK(same_bits(a.bounds.maximum, b.bounds.maximum));
    REQUIRE(a.objects.size() == b.objects.size());
    for (size_t i = 0; i < a.objects.size(); ++i) {
        const Object &x = a.objects[i], &y = b.objects[i];
        CHECK(x.name == y.name);
        CHECK(x.first_triangle == y.first_triangle);
        CHECK(x.triangle_count == y.triangle_count);
        CHECK(x.light_source == y.light_source);
        const Material &m = a.materials[x.material], &n = b.materials[y.material];
        CHECK(m.name == n.name);
        CHECK(same_bits(m.base_color, n.base_color));
        CHECK(same_bits(m.emission, n.emission));
        CHECK(same_bits(m.roughness, n.roughness));
        CHECK(same_bits(m.metallic, n.metallic));
        CHECK(m.base_color_texture == n.base_color_texture);
    }
    REQUIRE(a.lights.size() == b.lights.size());
    for (size_t i = 0; i < a.lights.size(); ++i) check_same(a.lights[i], b.lights[i]);
    REQUIRE(a.cameras.size() == b.cameras.size());
    for (size_t i = 0; i < a.cameras.size(); ++i) check_same(a.cameras[i], b.cameras[i]);
    CHECK(b.warnings.empty());
}

void check_round_trip(const Scene& scene) {
    const std::string path = temporary_folder() + "/scene.glb", again = temporary_folder() + "/again.glb";
    export_glb(scene, path);
    const Scene loaded = load_scene(path);
    check_same(scene, loaded);
    export_glb(loaded, again);
    CHECK((slurp(path) == slurp(again)));
}

} // namespace

TEST_CASE("every builtin scene survives export and loading bit for bit") {
    for (const BuiltinScene& builtin : builtin_scenes()) {
        CAPTURE(builtin.name);
        check_round_trip(load_scene("builtin:" + builtin.name));
    }
}

TEST_CASE("the shared meshes survive export and loading bit for bit") {
    for (const char* name : {"robot", "columns", "cornell_box", "sponza", "house"}) {
        const std::string path = shared_path("scenes/" + std::string(name) + "/" + name + ".glb");
        if (path.empty()) return;
        check_round_trip(load_scene(path));
    }
}

TEST_CASE("all lights, cameras, textures and awkward numbers survive export and loading") {
    Scene scene;
    scene.textures.push_back(
        {"paint", Image<glm::u8vec4>(3, 2, {10, 20, 30, 40}), Texture::Wrap::Mirror, Texture::Wrap::Clamp});
    scene.textures[0].image(2, 1) = {255, 0, 1, 254};
    scene.materials.push_back({"plain \"quoted\" ü", {0.1f, 1.0f, 1e-7f}, vec3(0), -1});
    scene.materials.push_back({"painted", vec3(0.3f), vec3(0), 0, 0.123f, 0.7f});
    scene.materials.push_back({"glowing", vec3(0), {1e-3f, 123.456f, 7e5f}, -1});
    MeshData mesh = box_mesh({-0.0f, 0.1f, 1e-40f}, {1, 2, 3});
    for (const vec3& p : mesh.positions) mesh.uvs.emplace_back(p.x * 0.3f, p.y);
    add_object(scene, "box", mesh, dmat4(1.0), 1);
    add_object(scene, "ball", sphere_mesh(0.37f, 20, 10), translation({0.1, 5, 7}) * rotation(33, {1, 2, 3}), 2);
    add_object(scene, "bare", plane_mesh({1, 1}), translation({0, -1, 0}), 0);
    int count = 0;
    for (const LightType type : {LightType::Point, LightType::Spot, LightType::Directional, LightType::Rectangle,
                                 LightType::Disk, LightType::Sphere, LightType::TexturedRectangle, LightType::Mesh}) {
        Light light;
        light.name = light_type_name(type);
        light.type = type;
        light.position = {0.1f * static_cast<float>(++count), 7.3f, -1e5f};
        light.direction = glm::normalize(vec3(0.3f, -1.0f, 0.1f * static_cast<float>(count)));
        light.tangent = any_tangent(light.direction);
        light.intensity = {1.1f, 1e-3f * static_cast<float>(count), 3e4f};
        if (is_area(type) && type != LightType::Mesh)
            light.size = vec2(0.7f, type == LightType::Disk || type == LightType::Sphere ? 0.7f : 1.3f);
        if (type == LightType::Spot) light.inner_cone = 0.123f, light.outer_cone = 0.456f;
        if (type == LightType::Point) light.range = 12.3f;
        if (type == LightType::TexturedRectangle) {
            light.texture = Image<vec3>(2, 3, vec3(0.25f));
            light.texture(1, 2) = {1e-9f, 2.5f, 1e9f};
        }
        if (type == LightType::Mesh)
            set_triangles(light,
                          std::vector<vec3>{
                              {0.1f, 2, 3}, {1e-3f, 2.5f, 3}, {0.7f, 9, -1e4f}, {0, 0, 0}, {0, 1, 0}, {1, 1, 0.3f}});
        scene.lights.push_back(light);
    }
    scene.cameras.push_back(look_at({1, 2, 9}, {0.3f, 0.1f, 0}, 0.77f));
    scene.cameras.push_back(look_at({0, 20, 0}, {0, 0, 0}, 0.77f));
    scene.cameras.back().name = "plan";
    scene.cameras.back().orthographic = true;
    scene.cameras.back().view_height = 3.3f;
    finish_scene(scene, "test");
    const std::string path = temporary_folder() + "/all.glb";
    export_glb(scene, path);
    const Scene loaded = load_scene(path);
    check_same(scene, loaded);
    REQUIRE(loaded.textures.size() == 1);
    CHECK(loaded.textures[0].wrap_u == Texture::Wrap::Mirror);
    CHECK(loaded.textures[0].wrap_v == Texture::Wrap::Clamp);
    REQUIRE(loaded.textures[0].image.size() == 6);
    for (size_t i = 0; i < 6; ++i) CHECK(loaded.textures[0].image.data()[i] == scene.textures[0].image.data()[i]);
}

TEST_CASE("an export that cannot be written is an input error and leaves nothing behind") {
    CHECK_THROWS_AS(export_glb(load_scene("builtin:half-plane"), temporary_folder() + "/missing/scene.glb"),
                    InputError);
}
