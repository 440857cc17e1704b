#pragma once
// A viewer: perspective or orthographic, looking along `forward`. The aspect ratio is that of the image, so a camera
// from a file keeps its vertical field of view whatever the size of the output.

#include <string>

#include "core/math.h"

namespace gnomon {

struct Camera {
    std::string name = "camera";
    vec3 position{0.0f};
    vec3 forward{0.0f, 0.0f, -1.0f}; // unit
    vec3 up{0.0f, 1.0f, 0.0f};       // unit, orthogonal to forward
    bool orthographic = false;
    float vertical_fov = 0.7853982f; // radians, perspective only
    float view_height = 2.0f;        // metres, orthographic only
    float near_plane = 0.1f;         // metres
    float far_plane = 1000.0f;       // metres
};

// A camera at `eye` looking at `target`; world y is up unless the view is vertical, then −z.
Camera look_at(vec3 eye, vec3 target, float vertical_fov_radians);

// Near and far planes around a box as seen from the camera: near as large as is safe and at least 1e-4 of far, which
// bounds the loss of depth precision where the camera stands inside the box.
void fit_planes(Camera& camera, const Bounds& bounds);

// World to eye space: x right, y up, looking along −z.
dmat4 view_matrix(const Camera& camera);

// Eye to OpenGL clip space (−w ≤ x, y, z ≤ w).
dmat4 projection_matrix(const Camera& camera, double aspect);

// As projection_matrix, with the far plane at infinity: points at infinity land at z = w exactly. [Forest 2008, 2.0.1]
// For an orthographic camera, which has no such limit, the far plane stays.
dmat4 infinite_projection_matrix(const Camera& camera, double aspect);

// The ray through window position (x, y), pixel centres at .5: origin on the eye (perspective) or on the plane through
// it (orthographic); direction unit, in double.
struct CameraRay {
    dvec3 origin;
    dvec3 direction;
};
CameraRay camera_ray(const Camera& camera, double x, double y, int width, int height);

// OpenGL matrices in double: perspective with any depth range, and orthographic.
dmat4 perspective_matrix(double vertical_fov, double aspect, double near_plane, double far_plane);
dmat4 orthographic_matrix(double half_width, double half_height, double near_plane, double far_plane);
// Rows right, up, −forward: world to a frame at `origin`. The three are unit and orthogonal.
dmat4 frame_matrix(dvec3 origin, dvec3 right, dvec3 up, dvec3 forward);

} // namespace gnomon
