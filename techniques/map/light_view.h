#pragma once
// How a light looks at the scene: one perspective or orthographic view, or the six faces of a cube around it.

#include <vector>

#include "techniques/frame.h"

namespace gnomon {

enum class Projection { Auto, Single, Cube };
inline constexpr const char* projection_choices = "auto|single|cube"; // in the order of the enumerators

struct LightView {
    mat4 to_clip;                 // world to the light's clip space; product in double, rounded once
    dvec3 origin;                 // the light's position; unused by an orthographic view
    dvec3 right, up, forward;     // unit
    double near_plane, far_plane; // metres along forward
    double half_extent;           // perspective: tan of half the field of view; orthographic: half the width in metres
    bool orthographic;

    // Width in metres of the area that the whole map shows at this distance along forward.
    double width_at(double distance) const { return 2.0 * half_extent * (orthographic ? 1.0 : distance); }
    // Distance along forward in metres, and the same scaled so that near and far are 0 and 1.
    double distance(vec3 p) const { return glm::dot(dvec3(p) - origin, forward); }
    float linear_depth(vec3 p) const {
        return static_cast<float>((distance(p) - near_plane) / (far_plane - near_plane));
    }
};

// The views of a light, seen as a point at its centre: orthographic around the casters for a directional light, the
// cone for a spot, and for the others one perspective view of all casters where they fit into 120°, or six faces in the
// order and orientation of OpenGL's cube maps [Navrátil 2015, 2.3]. Projection::Single and Cube force the one or the
// other; `near_plane` > 0 (metres) replaces the nearest plane that cuts no caster. Throws UsageError for a view that
// cannot be: a single one of casters all around the light, or a cube of a directional light.
// `gutter` widens cube faces by so many texels of `size` on every side, for filters that reach that far across an edge.
struct ViewOptions {
    Projection projection = Projection::Auto;
    float near_plane = 0.0f;
    int size = 1;
    int gutter = 0;
};
std::vector<LightView> light_views(const Frame& frame, const Light& light, const ViewOptions& options);

// The cube face that a direction meets, by its largest coordinate; x before y before z on ties.
int cube_face(dvec3 direction);

// Index of the view that sees p: 0, or the cube face.
int view_of(const std::vector<LightView>& views, vec3 p);

} // namespace gnomon
