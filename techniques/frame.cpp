#include "techniques/frame.h"

#include <algorithm>
#include <chrono>

#include "core/parallel.h"
#include "raster/draw.h"
#include "techniques/gbuffer_resolve.h"

namespace gnomon {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// OpenGL clip space to reversed depth: z' = (w − z)/2, so that z'/w runs from 1 at the near plane to 0 at the far
// plane. A float depth is then as precise far away as near by, and the triangle a pixel shows is the nearest one to
// 10⁻⁷ of its distance.
dmat4 reversed_depth(dmat4 projection) {
    for (int column = 0; column < 4; ++column)
        projection[column][2] = 0.5 * (projection[column][3] - projection[column][2]);
    return projection;
}

Image<std::uint32_t> draw_triangle_ids(PassLog& log, const Scene& scene, const Camera& camera, int width, int height) {
    Pass pass(log, "triangle ids");
    Target ids(Format::R32UI, width, height, 1, log.memory), depth(Format::D32F, width, height, 1, log.memory);

    PipelineState state;
    state.clip_depth = ClipDepth::ZeroToOne;
    state.depth = {.test = Compare::Greater, .write = true};
    const double aspect = static_cast<double>(width) / height;
    const mat4 to_clip(reversed_depth(projection_matrix(camera, aspect)) * view_matrix(camera));
    const Geometry geometry = {static_cast<std::uint32_t>(scene.positions.size()), scene.triangles};
    draw(
        pass, geometry, state, [&](std::uint32_t i) { return transform(to_clip, scene.positions[i]); },
        FragmentProgram{[](const Fragment<NoVaryings>& fragment, FragmentOutput& output) {
                            output.color[0].x = glm::uintBitsToFloat(fragment.primitive);
                        },
                        {.visible_only = true}},
        Targets{.depth = &depth,
                .color = {&ids},
                .clear_depth = 0.0f,
                .clear_color = vec4(glm::uintBitsToFloat(no_triangle))});

    Image<std::uint32_t> triangles(width, height);
    for (int y = 0; y < height; ++y) std::copy_n(ids.row<std::uint32_t>(y), width, triangles.row(y).data());
    return triangles;
}

} // namespace

Frame::Frame(const Scene& scene, const Camera& camera, int width, int height, Primary primary)
    : scene_(scene), camera_(camera), width_(width), height_(height) {
    check_image_size(width, height, "image");
    some_emit_ =
        std::any_of(scene.objects.begin(), scene.objects.end(), [](const Object& o) { return o.light_source; });
    if (some_emit_)
        for (size_t i = 0; i < scene.triangles.size(); ++i)
            if (!scene.objects[scene.triangle_objects[i]].light_source) casters_.push_back(scene.triangles[i]);
    if (primary == Primary::Ray) {
        const EmbreeScene& scene_rays = rays();
        const Pass pass(gbuffer_log_, "camera rays");
        trace_gbuffer(gbuffer_, scene, camera, scene_rays, width, height);
    } else {
        const Image<std::uint32_t> triangles = draw_triangle_ids(gbuffer_log_, scene, camera, width, height);
        const Pass pass(gbuffer_log_, "resolve");
        resolve_gbuffer(gbuffer_, scene, camera, triangles);
    }
}

Frame::~Frame() = default;

const Adjacency& Frame::adjacency() {
    if (!adjacency_) {
        const auto start = std::chrono::steady_clock::now();
        adjacency_ = std::make_unique<Adjacency>(build_adjacency(scene_));
        adjacency_seconds_ = seconds_since(start);
    }
    return *adjacency_;
}

const EmbreeScene& Frame::rays() {
    if (!rays_) {
        const auto start = std::chrono::steady_clock::now();
        rays_ = std::make_unique<EmbreeScene>(scene_);
        rays_seconds_ = seconds_since(start);
    }
    return *rays_;
}

const TriangleClusters& Frame::clusters() {
    if (!clusters_) {
        const auto start = std::chrono::steady_clock::now();
        clusters_ = std::make_unique<TriangleClusters>(build_clusters(scene_));
        rays_seconds_ += seconds_since(start);
    }
    return *clusters_;
}

Image<vec3> ambient_and_emission(const GBuffer& gbuffer, vec3 ambient) {
    Image<vec3> radiance(gbuffer.albedo.width(), gbuffer.albedo.height(), vec3(0.0f));
    const vec3 scale = ambient / static_cast<float>(pi);
    for (size_t i = 0; i < radiance.size(); ++i)
        if (gbuffer.receivers.data()[i].valid())
            radiance.data()[i] = gbuffer.emission.data()[i] + gbuffer.albedo.data()[i] * scale;
    return radiance;
}

void add_direct_light(Image<vec3>& radiance, const GBuffer& gbuffer, const Light& light,
                      const Image<float>& visibility) {
    parallel_for(radiance.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const Receiver& receiver = gbuffer.receivers.data()[i];
            const float v = visibility.data()[i];
            if (!receiver.valid() || v == 0.0f) continue;
            const vec3 irradiance = unshadowed_irradiance(light, receiver.position, gbuffer.shading_normal.data()[i]);
            radiance.data()[i] += gbuffer.albedo.data()[i] * irradiance * (v / static_cast<float>(pi));
        }
    });
}

} // namespace gnomon
