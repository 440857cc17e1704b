#pragma once
// A scene: world-space triangles, the objects they belong to, materials, lights and cameras. Instances are flattened
// when a scene is loaded (transform in double, rounded once), so that the rasterizer, the ray tracer and the volume
// builder see the very same float32 vertices.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/light.h"
#include "core/math.h"

namespace gnomon {

// An 8-bit sRGB image with alpha, row 0 at the top as glTF's v = 0 is.
struct Texture {
    enum class Wrap : std::uint8_t { Repeat, Clamp, Mirror };
    std::string name;
    Image<glm::u8vec4> image;
    Wrap wrap_u = Wrap::Repeat;
    Wrap wrap_v = Wrap::Repeat;
};

// Linear colour of a texture at uv, bilinear between texels (converted to linear first).
vec4 sample_texture(const Texture& texture, vec2 uv);

struct Material {
    std::string name = "default";
    vec3 base_color{0.8f};       // linear, diffuse albedo
    vec3 emission{0.0f};         // W/(m² sr), emissiveFactor × emissiveStrength
    int base_color_texture = -1; // index into Scene::textures, multiplies base_color
    // Of glTF's metallic-roughness model, 0 to 1: for the truth's radiance with the GGX BRDF; all else is diffuse.
    float roughness = 1.0f, metallic = 0.0f;
};

// A run of triangles that came from one node: what culling and static/dynamic splits work on.
struct Object {
    std::string name;
    std::uint32_t first_triangle = 0;
    std::uint32_t triangle_count = 0;
    std::uint32_t material = 0; // index into Scene::materials
    Bounds bounds;
    // The visible surface of an area light: the camera sees it, but it is no shadow caster. Its triangles coincide with
    // the light's sample points, so they would block the very rays that leave the light, and fill its shadow map from
    // edge to edge.
    bool light_source = false;
};

struct Scene {
    std::string name; // file name without folder, or builtin:…
    std::vector<vec3> positions;
    std::vector<vec3>
        normals;           // per vertex, unit; empty, or as many as positions; a zero normal means flat shading there
    std::vector<vec2> uvs; // per vertex; empty, or as many as positions
    std::vector<uvec3> triangles;                // counter-clockwise seen from outside
    std::vector<std::uint32_t> triangle_objects; // per triangle, index into objects
    std::vector<Object> objects;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<Light> lights;
    std::vector<Camera> cameras;
    Bounds bounds;                     // of all triangles
    std::vector<std::string> warnings; // what the loader had to leave out, one sentence each

    const Material& material_of(std::uint32_t triangle) const {
        return materials[objects[triangle_objects[triangle]].material];
    }
};

// Unit geometric normal of a triangle by its winding, evaluated in double; zero for a degenerate triangle.
vec3 geometric_normal(const Scene& scene, std::uint32_t triangle);

// Appends a mesh as one object, transformed into the world. Normals go with the inverse transpose; a mirroring
// transform flips the winding so that triangles stay counter-clockwise from outside. Throws InputError (naming `name`)
// on an index out of range, a position that is not finite after the transform, or more than 2³¹ triangles in all.
struct MeshData {
    std::vector<vec3> positions;
    std::vector<vec3> normals;
    std::vector<vec2> uvs;
    std::vector<uvec3> triangles;
};
void add_object(Scene& scene, const std::string& name, const MeshData& mesh, const dmat4& transform,
                std::uint32_t material);

// What a file without lights or cameras gets. Both depend on the bounds only.
Camera default_camera(const Scene& scene);
Light default_light(const Scene& scene);

// Loads a .gltf, .glb or .json file, or builds builtin:NAME[:key=value,…]. Afterwards the scene has at least one
// triangle, one camera and one light. Throws InputError or UsageError.
Scene load_scene(const std::string& specification);

// Writes a scene as binary glTF 2.0, area lights included; load_scene reads back the same triangles, lights and
// cameras.
void export_glb(const Scene& scene, const std::string& path);

} // namespace gnomon
