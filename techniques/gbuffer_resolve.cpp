#include "techniques/gbuffer_resolve.h"

#include "core/parallel.h"

namespace gnomon {
namespace {

struct Corners {
    dvec3 a, b, c;
};

// Where the ray meets the triangle, as weights of its corners. Each weight is the volume between the ray and the
// opposite edge, that is the edge's function in screen space: clamping a negative one moves the point to the edge that
// it lies outside of, however grazing the view, where clamping the point on the plane could move it anywhere.
dvec3 barycentrics(const Corners& corners, const CameraRay& ray) {
    const dvec3 a = corners.a - ray.origin, b = corners.b - ray.origin, c = corners.c - ray.origin;
    dvec3 weights(glm::dot(ray.direction, glm::cross(b, c)), glm::dot(ray.direction, glm::cross(c, a)),
                  glm::dot(ray.direction, glm::cross(a, b)));
    if (weights.x + weights.y + weights.z < 0) weights = -weights; // seen from behind
    weights = glm::max(weights, dvec3(0));
    const double sum = weights.x + weights.y + weights.z;
    return sum > 0 ? weights / sum : dvec3(1.0 / 3.0); // edge-on
}

// The interpolated normal on the viewer's side, or the geometric one where there is none.
vec3 shading_normal(const Scene& scene, const uvec3& corners, dvec3 weights, vec3 geometric) {
    if (scene.normals.empty()) return geometric;
    const vec3 a = scene.normals[corners.x], b = scene.normals[corners.y], c = scene.normals[corners.z];
    if (a == vec3(0) || b == vec3(0) || c == vec3(0)) return geometric;
    const dvec3 sum = dvec3(a) * weights.x + dvec3(b) * weights.y + dvec3(c) * weights.z;
    const double length = glm::length(sum);
    if (!(length > 1e-12)) return geometric;
    const vec3 normal(sum / length);
    return glm::dot(normal, geometric) < 0 ? -normal : normal;
}

vec3 surface_albedo(const Scene& scene, const Material& material, const uvec3& corners, dvec3 weights) {
    if (material.base_color_texture < 0 || scene.uvs.empty()) return material.base_color;
    const dvec2 uv = dvec2(scene.uvs[corners.x]) * weights.x + dvec2(scene.uvs[corners.y]) * weights.y +
                     dvec2(scene.uvs[corners.z]) * weights.z;
    const Texture& texture = scene.textures[static_cast<size_t>(material.base_color_texture)];
    return material.base_color * vec3(sample_texture(texture, vec2(uv)));
}

} // namespace

void clear_gbuffer(GBuffer& gbuffer, int width, int height) {
    gbuffer.receivers = Receivers(width, height);
    gbuffer.shading_normal = Image<vec3>(width, height, vec3(0));
    gbuffer.albedo = Image<vec3>(width, height, vec3(0));
    gbuffer.emission = Image<vec3>(width, height, vec3(0));
    gbuffer.depth = Image<float>(width, height, infinity);
}

void resolve_receiver(GBuffer& gbuffer, int x, int y, const Scene& scene, const Camera& camera,
                      std::uint32_t triangle) {
    Receiver& receiver = gbuffer.receivers(x, y);
    receiver = Receiver{};
    if (triangle == no_triangle) {
        gbuffer.shading_normal(x, y) = gbuffer.albedo(x, y) = gbuffer.emission(x, y) = vec3(0);
        gbuffer.depth(x, y) = infinity;
        return;
    }
    const uvec3 corners = scene.triangles[triangle];
    const Corners points = {dvec3(scene.positions[corners.x]), dvec3(scene.positions[corners.y]),
                            dvec3(scene.positions[corners.z])};
    const CameraRay ray = camera_ray(camera, x + 0.5, y + 0.5, gbuffer.receivers.width(), gbuffer.receivers.height());
    const dvec3 weights = barycentrics(points, ray);
    const dvec3 position = points.a * weights.x + points.b * weights.y + points.c * weights.z;

    // A sliver that only rounding made visible has no normal of its own; it then faces the viewer.
    vec3 normal = geometric_normal(scene, triangle);
    if (normal == vec3(0)) normal = vec3(-ray.direction);
    if (glm::dot(dvec3(normal), ray.direction) > 0) normal = -normal;

    const Material& material = scene.material_of(triangle);
    receiver.position = vec3(position);
    receiver.geometric_normal = normal;
    receiver.triangle = triangle;
    gbuffer.shading_normal(x, y) = shading_normal(scene, corners, weights, normal);
    gbuffer.albedo(x, y) = surface_albedo(scene, material, corners, weights);
    gbuffer.emission(x, y) = material.emission;
    gbuffer.depth(x, y) =
        static_cast<float>(glm::dot(position - dvec3(camera.position), glm::normalize(dvec3(camera.forward))));
}

void resolve_gbuffer(GBuffer& gbuffer, const Scene& scene, const Camera& camera,
                     const Image<std::uint32_t>& triangles) {
    const int width = triangles.width();
    clear_gbuffer(gbuffer, width, triangles.height());
    parallel_for(static_cast<size_t>(triangles.height()), 1, [&](size_t begin, size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < width; ++x) resolve_receiver(gbuffer, x, y, scene, camera, triangles(x, y));
    });
}

} // namespace gnomon
