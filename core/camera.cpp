#include "core/camera.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

Camera look_at(vec3 eye, vec3 target, float vertical_fov_radians) {
    Camera camera;
    camera.position = eye;
    const dvec3 forward = glm::normalize(dvec3(target) - dvec3(eye));
    const dvec3 world_up = std::abs(forward.y) < 0.9999 ? dvec3(0, 1, 0) : dvec3(0, 0, -1);
    const dvec3 right = glm::normalize(glm::cross(forward, world_up));
    camera.forward = vec3(forward);
    camera.up = vec3(glm::cross(right, forward));
    camera.vertical_fov = vertical_fov_radians;
    return camera;
}

void fit_planes(Camera& camera, const Bounds& bounds) {
    float nearest = infinity, farthest = -infinity;
    for (int i = 0; i < 8; ++i) {
        const float depth = glm::dot(bounds.corner(i) - camera.position, camera.forward);
        nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
    }
    const float margin = 0.01f * std::max(bounds.diagonal(), 1e-6f);
    // A camera that looks away from the scene still needs a valid range.
    camera.far_plane = farthest > 0.0f ? farthest + margin : std::max(bounds.diagonal(), 1e-3f);
    camera.near_plane = std::max(nearest - margin, 1e-4f * camera.far_plane);
    if (camera.near_plane >= camera.far_plane) camera.near_plane = 1e-4f * camera.far_plane;
}

dmat4 frame_matrix(dvec3 origin, dvec3 right, dvec3 up, dvec3 forward) {
    const dvec3 back = -forward;
    return {dvec4(right.x, up.x, back.x, 0), dvec4(right.y, up.y, back.y, 0), dvec4(right.z, up.z, back.z, 0),
            dvec4(-glm::dot(right, origin), -glm::dot(up, origin), -glm::dot(back, origin), 1)};
}

namespace {
struct Axes {
    dvec3 right, up, forward;
};
Axes axes(const Camera& camera) {
    const dvec3 forward = glm::normalize(dvec3(camera.forward));
    const dvec3 right = glm::normalize(glm::cross(forward, dvec3(camera.up)));
    return {right, glm::cross(right, forward), forward};
}
} // namespace

dmat4 view_matrix(const Camera& camera) {
    const Axes a = axes(camera);
    return frame_matrix(dvec3(camera.position), a.right, a.up, a.forward);
}

dmat4 perspective_matrix(double vertical_fov, double aspect, double n, double f) {
    const double focal = 1.0 / std::tan(vertical_fov * 0.5);
    return {dvec4(focal / aspect, 0, 0, 0), dvec4(0, focal, 0, 0), dvec4(0, 0, -(f + n) / (f - n), -1),
            dvec4(0, 0, -2.0 * f * n / (f - n), 0)};
}

dmat4 orthographic_matrix(double half_width, double half_height, double n, double f) {
    return {dvec4(1.0 / half_width, 0, 0, 0), dvec4(0, 1.0 / half_height, 0, 0), dvec4(0, 0, -2.0 / (f - n), 0),
            dvec4(0, 0, -(f + n) / (f - n), 1)};
}

dmat4 projection_matrix(const Camera& camera, double aspect) {
    const double n = camera.near_plane, f = camera.far_plane;
    if (camera.orthographic) {
        const double half_height = 0.5 * camera.view_height;
        return orthographic_matrix(half_height * aspect, half_height, n, f);
    }
    return perspective_matrix(camera.vertical_fov, aspect, n, f);
}

dmat4 infinite_projection_matrix(const Camera& camera, double aspect) {
    dmat4 projection = projection_matrix(camera, aspect);
    if (!camera.orthographic) {
        projection[2][2] = -1.0;
        projection[3][2] = -2.0 * camera.near_plane;
    }
    return projection;
}

CameraRay camera_ray(const Camera& camera, double x, double y, int width, int height) {
    const Axes a = axes(camera);
    const double aspect = static_cast<double>(width) / height;
    const double ndc_x = 2.0 * x / width - 1.0, ndc_y = 2.0 * y / height - 1.0;
    const double half_height =
        camera.orthographic ? 0.5 * camera.view_height : std::tan(0.5 * static_cast<double>(camera.vertical_fov));
    const dvec3 offset = a.right * (ndc_x * half_height * aspect) + a.up * (ndc_y * half_height);
    if (camera.orthographic) return {dvec3(camera.position) + offset, a.forward};
    return {dvec3(camera.position), glm::normalize(a.forward + offset)};
}

} // namespace gnomon
