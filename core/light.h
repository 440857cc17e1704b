#pragma once
// Lights: punctual ones as in KHR_lights_punctual, and area lights. A hard-shadow technique sees an area light as a
// point at `position`, its centre. Area lights emit on the side that `direction` points to; a sphere emits everywhere.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/math.h"

namespace gnomon {

enum class LightType : std::uint8_t { Point, Spot, Directional, Rectangle, Disk, Sphere, TexturedRectangle, Mesh };

// A triangle of a Mesh light; it shines to the side from which a, b, c run counter-clockwise.
struct LightTriangle {
    vec3 a{0.0f}, b{0.0f}, c{0.0f}; // world, metres
    vec3 normal{0.0f};              // unit
    float area_up_to = 0;           // metres², of this and all triangles before it
};

struct Light {
    std::string name = "light";
    LightType type = LightType::Point;
    vec3 position{0.0f};               // metres; the centre of an area light; unused by Directional
    vec3 direction{0.0f, -1.0f, 0.0f}; // unit, the way the light shines; unused by Point and Sphere
    vec3 tangent{1.0f, 0.0f, 0.0f};    // unit, orthogonal to direction: the axis of size.x; the other is bitangent()
    vec2 size{0.0f};               // metres: width and height of a rectangle; the diameter twice for a disk or sphere
    vec3 intensity{1.0f};          // point, spot: W/sr; directional: W/m²; area: radiance W/(m² sr)
    float inner_cone = 0.0f;       // radians from the axis, spot only: full intensity inside
    float outer_cone = 0.7853982f; // radians from the axis, spot only: none outside
    float range = infinity;        // metres, KHR_lights_punctual's smooth cut-off; point and spot only
    Image<vec3> texture;           // linear radiance factor of a TexturedRectangle; row 0 at −bitangent
    std::vector<LightTriangle> triangles; // of a Mesh, see set_triangles
};

bool is_area(LightType type);
inline bool is_area(const Light& light) { return is_area(light.type); }
const char* light_type_name(LightType type); // "point", "spot", … "textured-rectangle"

// Set of light types, for what a technique supports.
using LightTypes = std::uint32_t;
constexpr LightTypes bit(LightType type) { return LightTypes{1} << static_cast<int>(type); }
inline constexpr LightTypes punctual_lights =
    bit(LightType::Point) | bit(LightType::Spot) | bit(LightType::Directional);
inline constexpr LightTypes area_lights =
    bit(LightType::Rectangle) | bit(LightType::Disk) | bit(LightType::Sphere) | bit(LightType::TexturedRectangle);
inline constexpr LightTypes all_lights = punctual_lights | area_lights | bit(LightType::Mesh);

std::vector<std::string> light_type_names(LightTypes types); // in the order of the enumerators

inline vec3 bitangent(const Light& light) { return glm::cross(light.direction, light.tangent); }

// Any unit vector orthogonal to unit `n`, the same for the same n: world x made orthogonal, or z where n is along x.
vec3 any_tangent(vec3 n);

// Gives a Mesh its triangles, three corners each, of which those without area are left out, and puts `position` at the
// centroid of their surface and `direction` along its mean normal (down where it has none).
void set_triangles(Light& light, std::span<const vec3> corners);

// Metres²: the one-sided surface of a rectangle, disk or mesh, the whole surface of a sphere, 0 for punctual lights.
float surface_area(const Light& light);

// The point of the light for (u, v) in [0,1)²: area-preserving on rectangle and disk (concentric map, Shirley and Chiu
// 1997). A sphere is sampled as the disk that faces `receiver`, through its centre, with the sphere's limb as seen from
// there: radius r·sqrt(1 − r²/d²) at the limb plane [Forest 2008, 2.0.6]. A mesh is sampled by
// area: u chooses the triangle and its rest, with v, the place in it [Heitz 2019, "A Low-Distortion Map Between
// Triangle and Square"]. Punctual lights return `position`.
vec3 light_point(const Light& light, float u, float v, vec3 receiver);
// The same for arrays of (u, v), bit for bit, into arrays of coordinates of the same length.
void light_points(const Light& light, vec3 receiver, std::span<const float> u, std::span<const float> v,
                  std::span<float> x, std::span<float> y, std::span<float> z);

// A point of an area light with what it sends: `radiance` to the side that `facing` points to. The point stands for the
// light's share of `area` metres² that a sample is of all samples. Radiance is 0 where a sphere contains the receiver.
struct LightSample {
    vec3 position{0.0f}, facing{0.0f};
    vec3 radiance{0.0f}; // W/(m² sr)
    float area = 0;      // surface_area, or of the limb disk that stands for a sphere
};
LightSample light_sample(const Light& light, float u, float v, vec3 receiver);

// Unit vector from `p` to the light's centre, or against the direction of a directional light.
vec3 direction_to_light(const Light& light, vec3 p);

// Unshadowed irradiance W/m² at p with unit normal n. Area lights: midpoint quadrature over 8×8 cells of light_point,
// horizon included, so that every shape is treated alike; a mesh is sampled at 64 places along its triangles.
vec3 unshadowed_irradiance(const Light& light, vec3 p, vec3 n);

} // namespace gnomon
