// The camera pass by ray tracing (`--primary ray`).

#include "core/parallel.h"
#include "techniques/gbuffer_resolve.h"

namespace gnomon {

void trace_gbuffer(GBuffer& gbuffer, const Scene& scene, const Camera& camera, const EmbreeScene& rays, int width,
                   int height) {
    const dvec3 forward = glm::normalize(dvec3(camera.forward));
    Image<std::uint32_t> triangles(width, height, no_triangle);
    const auto trace_rows = [&](size_t begin, size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < width; ++x) {
                const CameraRay ray = camera_ray(camera, x + 0.5, y + 0.5, width, height);
                // The planes lie at a distance along `forward`, Embree's interval along the ray.
                const double stretch = 1.0 / glm::dot(ray.direction, forward);
                triangles(x, y) = rays.first_hit(vec3(ray.origin), vec3(ray.direction),
                                                 static_cast<float>(camera.near_plane * stretch),
                                                 static_cast<float>(camera.far_plane * stretch))
                                      .triangle;
            }
    };
    parallel_for(static_cast<size_t>(height), 1, trace_rows, FloatMode::FlushZero);
    resolve_gbuffer(gbuffer, scene, camera, triangles);
}

} // namespace gnomon
