#pragma once
// The parts that load_scene is put together from. Scenes made by these functions are raw: degenerate triangles, missing
// lights and cameras and camera planes are settled once, in finish_scene.

#include <string>
#include <vector>

#include "core/math.h"
#include "core/scene.h"

namespace gnomon {

// A .gltf or .glb file. Throws InputError with one line that names the file and the place in it.
Scene load_gltf(const std::string& path);

// A scene document; its keys are described in docs/scenes.md.
Scene load_scene_json(const std::string& path);

// Any specification that load_scene takes, before finish_scene.
Scene load_raw_scene(const std::string& specification);

// Drops triangles of zero area (with a warning that counts them), computes bounds, adds the default camera and light
// where there are none, and gives near and far planes to cameras that ask for them by far_plane = 0. Throws InputError
// where no triangle is left.
void finish_scene(Scene& scene, const std::string& specification);

// Which of another scene's lights and cameras come along.
struct AppendOptions {
    bool lights = true;
    bool cameras = true;
};
// Appends another scene's objects, materials, textures and warnings, transformed into the world. Where its lights stay
// behind, their visible surfaces become ordinary objects that cast shadows.
void append_scene(Scene& scene, const Scene& other, const dmat4& transform, AppendOptions options);

// The same light or camera seen through a transform; sizes follow the lengths of the axes that they lie along.
Light transformed(Light light, const dmat4& transform);
Camera transformed(Camera camera, const dmat4& transform);

// Makes a rectangular light visible: appends its surface as a light_source object of the light's name and radiance.
void add_light_surface(Scene& scene, const Light& light);

// Makes an emissive object a light: its triangles, which cast no shadow from then on, under its name. False where its
// material does not shine or no triangle has area.
bool add_mesh_light(Scene& scene, Object& object);

// `v` as a unit vector: as it is where that is already so to float precision, which keeps what was unit bit for bit.
inline constexpr double unit_tolerance = 1e-6; // a few roundings of float vectors and their cross products
vec3 unit(dvec3 v);
// `v` without its part along unit `n`, as a unit vector, by the same rule.
vec3 unit_orthogonal(dvec3 v, vec3 n);

// `wanted`, or `wanted`-2, -3, … where a light or camera of that name exists already.
std::string unique_light_name(const Scene& scene, const std::string& wanted);
std::string unique_camera_name(const Scene& scene, const std::string& wanted);

} // namespace gnomon
