// The truth: our rays beside a bare loop over the same rays, and proofs beside rays alone.

#include <atomic>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#if __has_include(<embree3/rtcore.h>)
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include "bench/bench.h"
#include "bench/scenes.h"
#include "core/parallel.h"
#include "core/primitives.h"
#include "raytrace/truth.h"
#include "techniques/frame.h"

namespace gnomon_bench {
namespace {

constexpr int samples = 1024;
constexpr int every =
    8; // one row of tiles in so many is traced: an eighth of the image's time, and its mixture of work

double mean(const Image<float>& image) {
    return std::accumulate(image.values().begin(), image.values().end(), 0.0) / static_cast<double>(image.size());
}

// What a researcher would write around Embree: sixteen light samples of a pixel in one packet, no filter, no accounts.
class BareLoop {
public:
    explicit BareLoop(const Scene& scene) : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* positions = static_cast<vec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3), scene.positions.size()));
        auto* indices = static_cast<uvec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(uvec3), scene.triangles.size()));
        std::copy(scene.positions.begin(), scene.positions.end(), positions);
        std::copy(scene.triangles.begin(), scene.triangles.end(), indices);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene_, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(scene_);
    }
    ~BareLoop() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    BareLoop(const BareLoop&) = delete;
    BareLoop& operator=(const BareLoop&) = delete;

    // Mean visibility, for the same samples and origins as ours.
    double run(const EmbreeScene& rays, const Receivers& receivers, const Light& light) const {
        const PreparedPattern pattern = prepare_pattern(Pattern::Sobol, samples, SampleOrder::Packed);
        std::atomic<long> seen{0};
        const auto rows = [&](size_t begin, size_t) {
            const int y = static_cast<int>(begin);
            std::vector<float> u(samples), v(samples), x(samples), y_of(samples), z(samples);
            long seen_here = 0;
            for (int column = 0; column < receivers.width(); ++column) {
                const Receiver& receiver = receivers(column, y);
                if (!receiver.valid()) {
                    seen_here += samples;
                    continue;
                }
                fill_pattern(pattern, static_cast<std::uint32_t>(y * receivers.width() + column), 0, u, v);
                light_points(light, receiver.position, u, v, x, y_of, z);
                const vec3 origin = rays.shadow_origin(receiver).position;
                for (size_t first = 0; first < samples; first += 16)
                    seen_here += packet(receiver, origin, &x[first], &y_of[first], &z[first]);
            }
            seen += seen_here;
        };
        parallel_for(static_cast<size_t>(receivers.height()), 1, rows, FloatMode::FlushZero);
        return static_cast<double>(seen) / samples / static_cast<double>(receivers.size());
    }

private:
    int packet(const Receiver& receiver, vec3 origin, const float* x, const float* y, const float* z) const {
        RTCRay16 rays;
        alignas(64) int valid[16];
        int any = 0;
        for (int k = 0; k < 16; ++k) {
            const vec3 target(x[k], y[k], z[k]);
            valid[k] = faces(receiver, target) ? -1 : 0;
            any |= valid[k];
            rays.org_x[k] = origin.x, rays.org_y[k] = origin.y, rays.org_z[k] = origin.z;
            rays.dir_x[k] = x[k] - origin.x, rays.dir_y[k] = y[k] - origin.y, rays.dir_z[k] = z[k] - origin.z;
            rays.tnear[k] = 0.0f, rays.tfar[k] = 0.99999f, rays.time[k] = 0.0f;
            rays.mask[k] = 0xffffffffu, rays.id[k] = 0, rays.flags[k] = 0;
        }
        if (!any) return 0;
#if RTC_VERSION_MAJOR >= 4
        rtcOccluded16(valid, scene_, &rays);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded16(valid, scene_, &context, &rays);
#endif
        int seen = 0;
        for (int k = 0; k < 16; ++k) seen += (valid[k] != 0) & !(rays.tfar[k] < 0.0f);
        return seen;
    }

    RTCDevice device_;
    RTCScene scene_;
};

Receivers some_rows(const Receivers& all) {
    Receivers some = all;
    for (int y = 0; y < all.height(); ++y)
        if (y / truth_tile_side % every != every / 2) std::fill(some.row(y).begin(), some.row(y).end(), Receiver{});
    return some;
}

double penumbra_share(const Image<float>& visibility) {
    const auto partial = std::count_if(visibility.values().begin(), visibility.values().end(),
                                       [](float v) { return v > 0.0f && v < 1.0f; });
    return every * static_cast<double>(partial) / static_cast<double>(visibility.size());
}

void bench_scene(Bench& bench, const Scene& scene, ivec2 size) {
    const std::string rays_name = fmt::format("truth rays {} {}x{}", scene.name, size.x, size.y),
                      proofs_name = fmt::format("truth shortcuts {} {}x{}", scene.name, size.x, size.y);
    if (!bench.wanted(rays_name) && !bench.wanted(proofs_name)) return;
    Frame frame(scene, scene.cameras.front(), size.x, size.y);
    const Receivers receivers = some_rows(frame.receivers());
    const Light& light = scene.lights.front();
    Image<float> alone(1, 1, 0.0f), proven(1, 1, 0.0f);
    const auto trace = [&] {
        alone = area_visibility(frame.rays(), receivers, light, Pattern::Sobol, samples, 0, nullptr);
    };
    if (bench.wanted(rays_name)) {
        const BareLoop bare(scene);
        double their_mean = 0;
        bench.run(rays_name, trace, "bare rtcOccluded16",
                  [&] { their_mean = bare.run(frame.rays(), receivers, light); });
        bench.agree(rays_name, mean(alone), their_mean, 1e-3);
    }
    if (bench.wanted(proofs_name)) {
        const TriangleClusters& clusters = frame.clusters();
        const auto prove = [&] {
            proven = area_visibility(frame.rays(), receivers, light, Pattern::Sobol, samples, 0, nullptr, &clusters);
        };
        bench.run(proofs_name, prove, "without shortcuts", trace);
        const bool same = std::equal(alone.values().begin(), alone.values().end(), proven.values().begin());
        bench.agree(proofs_name, same ? 1.0 : 0.0, 1.0, 0.0);
        fmt::print(stderr, "{}: {:.1f} % of the pixels are in penumbra\n", proofs_name, 100 * penumbra_share(proven));
    }
}

std::optional<Scene> bunny_on_floor() {
    std::optional<Scene> scene = shared_scene("bunny_closed");
    if (!scene) return std::nullopt;
    add_object(*scene, "floor", plane_mesh(vec2(8.0f), 1, 1), dmat4(1.0), 0);
    scene->lights = {rectangle({2.5f, 4, 1.5f}, {0, 0.8f, 0}, 3.0f)};
    scene->cameras = {look_at({0.2f, 3.4f, 3.6f}, {-0.3f, 0.5f, -0.2f}, 0.7853982f)};
    fit_planes(scene->cameras.front(), scene->bounds);
    return scene;
}

} // namespace

// 1024 samples a pixel; lights that put about a fifth of the pixels into penumbra, and the worst case: a tree under a
// light so large that all is penumbra.
void bench_truth(Bench& bench) {
    if (const auto bunny = bunny_on_floor()) bench_scene(bench, *bunny, {1280, 720});
    if (auto sponza = shared_scene("sponza")) {
        sponza->lights = {rectangle(sponza->bounds.center() + vec3(0, 0.6f, 0) * sponza->bounds.extent(),
                                    sponza->bounds.center(), 0.11f * sponza->bounds.diagonal())};
        bench_scene(bench, *sponza, {1280, 720});
    }
    Scene tree = load_scene("builtin:tree");
    tree.name = "tree";
    tree.lights.front().size = vec2(30.0f);
    bench_scene(bench, tree, {640, 360});
    bench_cycles(bench);
}

} // namespace gnomon_bench
