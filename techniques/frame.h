#pragma once
// What a GPU program would have: the scene, the camera, the G-buffer, named and counted passes, and, built when first
// asked for, the structures over the scene that several techniques share.

#include <memory>
#include <span>
#include <string>

#include "core/adjacency.h"
#include "core/receiver.h"
#include "core/scene.h"
#include "raster/counters.h"
#include "raster/full_screen.h"
#include "raster/target.h"
#include "raytrace/embree_scene.h"
#include "raytrace/triangle_clusters.h"
#include "raytrace/truth.h"

namespace gnomon {

class Progress;

enum class Primary { Raster, Ray };

// What the camera sees, one value a pixel.
struct GBuffer {
    Receivers receivers;        // world position, geometric normal, triangle
    Image<vec3> shading_normal; // unit, interpolated, on the viewer's side
    Image<vec3> albedo;         // linear base colour
    Image<vec3> emission;       // W/(m² sr)
    Image<float> depth;         // distance from the eye plane in metres; +∞ where nothing is seen
};

class Frame {
public:
    // Renders the G-buffer. `scene` must outlive the frame. Throws UsageError for an impossible size.
    Frame(const Scene& scene, const Camera& camera, int width, int height, Primary primary = Primary::Raster);
    ~Frame();

    const Scene& scene() const { return scene_; }
    const Camera& camera() const { return camera_; }
    int width() const { return width_; }
    int height() const { return height_; }
    double aspect() const { return static_cast<double>(width_) / height_; }
    const GBuffer& gbuffer() const { return gbuffer_; }
    const Receivers& receivers() const { return gbuffer_.receivers; }
    // The triangles that cast shadows: all but the surfaces of area lights.
    std::span<const uvec3> casters() const { return some_emit_ ? casters_ : scene_.triangles; }

    // Built on first use, then kept for all techniques of this frame.
    const Adjacency& adjacency();
    const EmbreeScene& rays();
    const TriangleClusters& clusters();

    // A render target whose memory counts for the current technique.
    Target target(Format format, int width, int height, int layers = 1) {
        return Target(format, width, height, layers, log_.memory);
    }
    // A named pass of the current technique.
    Pass pass(std::string name) { return Pass(log_, std::move(name)); }

    // The log that passes of the current technique write to: `begin_technique` starts a new, empty one.
    PassLog& log() { return log_; }
    void begin_technique() { log_ = PassLog(); }
    const PassLog& gbuffer_log() const { return gbuffer_log_; }
    double adjacency_seconds() const { return adjacency_seconds_; }
    double rays_seconds() const { return rays_seconds_; }

    // Long techniques report to it, by pixels; null: no progress.
    Progress* progress = nullptr;
    // Where and which part of its work the truth keeps; its progress is the one above.
    TruthRun truth_run;

private:
    const Scene& scene_;
    Camera camera_;
    int width_, height_;
    GBuffer gbuffer_;
    bool some_emit_ = false;
    std::vector<uvec3> casters_; // filled only where some_emit_
    PassLog gbuffer_log_, log_;
    std::unique_ptr<Adjacency> adjacency_;
    std::unique_ptr<EmbreeScene> rays_;
    std::unique_ptr<TriangleClusters> clusters_;
    double adjacency_seconds_ = 0, rays_seconds_ = 0;
};

// The full-screen pass that answers every receiver: program(const Receiver&, Pixel&) -> visibility in [0, 1]. Pixels
// that show nothing are 1 and run no program.
template <class Program>
Image<float> for_each_receiver(Frame& frame, const std::string& pass_name, const Program& program) {
    Pass pass = frame.pass(pass_name);
    const Receivers& receivers = frame.receivers();
    Image<float> visibility(frame.width(), frame.height(), 1.0f);
    constexpr std::int64_t gbuffer_bytes = sizeof(vec3) * 2; // position and geometric normal
    full_screen(pass, visibility, [&](Pixel& pixel) {
        const Receiver& receiver = receivers(pixel.x, pixel.y);
        pixel.counters.bytes_read += gbuffer_bytes;
        return receiver.valid() ? program(receiver, pixel) : 1.0f;
    });
    return visibility;
}

// Outgoing radiance towards the camera: emission + albedo/π × (ambient + Σ unshadowed irradiance × visibility); the
// background is black. `ambient` is W/m².
void add_direct_light(Image<vec3>& radiance, const GBuffer& gbuffer, const Light& light,
                      const Image<float>& visibility);
Image<vec3> ambient_and_emission(const GBuffer& gbuffer, vec3 ambient);

} // namespace gnomon
