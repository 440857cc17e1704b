#include "raytrace/embree_scene.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "raytrace/shadow_rays.h"

namespace gnomon {
namespace {

// Of sixteen bits: mostly they are alike, and counting them is a call where the processor is not known to count.
unsigned ones(unsigned word) {
    if (word == 0) return 0;
    return word == 0xffffu ? 16u : static_cast<unsigned>(__builtin_popcount(word));
}

struct CameraQuery {
    QueryContext context;
    float distance;
    std::uint32_t primitive;
};

// Which of two triangles at the same distance Embree keeps depends on how the tree was built; we keep the lower index.
void keep_lower_index(const RTCFilterFunctionNArguments* arguments) {
    auto* query = reinterpret_cast<CameraQuery*>(arguments->context);
    for (unsigned i = 0; i < arguments->N; ++i) {
        if (arguments->valid[i] != -1) continue;
        const float distance = RTCRayN_tfar(arguments->ray, arguments->N, i);
        const std::uint32_t primitive = RTCHitN_primID(arguments->hit, arguments->N, i);
        if (distance > query->distance || (distance == query->distance && primitive > query->primitive)) {
            arguments->valid[i] = 0;
        } else {
            query->distance = distance;
            query->primitive = primitive;
        }
    }
}

} // namespace

struct EmbreeScene::Implementation {
    const Scene& scene;
    RTCDevice device = nullptr;
    ShadowCasters casters;
    RTCScene light_sources = nullptr; // null where the scene has none
    // Primitive to Scene::triangles; empty where every triangle casts shadows.
    std::vector<std::uint32_t> light_source_triangles;
    std::vector<std::uint32_t> primitive_of; // per triangle of the scene: its primitive in whichever of the two has it
    std::atomic<std::ptrdiff_t> bytes{0};

    explicit Implementation(const Scene& s);
    ~Implementation() { release(); }
    void release();
    void check(const char* what) const;
    void separate_light_sources();
    RTCScene build(const std::vector<std::uint32_t>& members);
    void find_steep();

    std::array<vec3, 3> corners_of(std::uint32_t triangle) const;
    ShadowRays shadow_rays(const Receiver& receiver, bool end) const;
};

EmbreeScene::Implementation::Implementation(const Scene& s)
    : scene(s), casters{s, local_shift(s.positions), nullptr, {}, {}} {
    const FloatModeScope mode(FloatMode::FlushZero);
    device = rtcNewDevice(nullptr);
    if (!device)
        throw Error(ExitCode::Internal, "Embree could not be started (error " +
                                            std::to_string(static_cast<int>(rtcGetDeviceError(nullptr))) + ").");
    rtcSetDeviceMemoryMonitorFunction(
        device,
        [](void* counter, ssize_t change, bool) {
            *static_cast<std::atomic<std::ptrdiff_t>*>(counter) += change;
            return true;
        },
        &bytes);
    try {
        separate_light_sources();
        casters.built = build(casters.triangles);
        find_steep();
        if (!light_source_triangles.empty()) light_sources = build(light_source_triangles);
    } catch (...) {
        release(); // no destructor runs after a constructor that throws
        throw;
    }
}

void EmbreeScene::Implementation::release() {
    if (light_sources) rtcReleaseScene(light_sources);
    if (casters.built) rtcReleaseScene(casters.built);
    if (device) rtcReleaseDevice(device);
    light_sources = casters.built = nullptr;
    device = nullptr;
}

void EmbreeScene::Implementation::check(const char* what) const {
    const RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_NONE) return;
    const std::string reason = error == RTC_ERROR_OUT_OF_MEMORY
                                   ? "the memory does not suffice"
                                   : "Embree error " + std::to_string(static_cast<int>(error));
    throw Error(ExitCode::Internal, std::string(what) + " of " + std::to_string(scene.triangles.size()) +
                                        " triangles failed: " + reason + ".");
}

// Light sources get an Embree scene of their own, which shadow rays never enter: cheaper than a mask test on every ray,
// and right whether Embree was built with ray masks or not.
void EmbreeScene::Implementation::separate_light_sources() {
    const auto is_source = [](const Object& object) { return object.light_source && object.triangle_count > 0; };
    if (std::none_of(scene.objects.begin(), scene.objects.end(), is_source)) return;
    primitive_of.resize(scene.triangles.size());
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
        auto& members =
            scene.objects[scene.triangle_objects[t]].light_source ? light_source_triangles : casters.triangles;
        primitive_of[t] = static_cast<std::uint32_t>(members.size());
        members.push_back(t);
    }
}

void EmbreeScene::Implementation::find_steep() {
    float magnitude = 0.0f;
    for (const vec3& p : scene.positions) magnitude = larger(magnitude, largest_component(p - casters.shift));
    casters.steep.resize(primitive_of.empty() ? scene.triangles.size() : casters.triangles.size());
    for (std::uint32_t i = 0; i < casters.steep.size(); ++i)
        casters.steep[i] = steep_hit(casters.corners(i), magnitude);
}

RTCScene EmbreeScene::Implementation::build(const std::vector<std::uint32_t>& members) {
    RTCScene built = rtcNewScene(device);
    rtcSetSceneFlags(built, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | filter_in_query));
    rtcSetSceneBuildQuality(built, RTC_BUILD_QUALITY_HIGH);
    const size_t count = primitive_of.empty() ? scene.triangles.size() : members.size();
    if (count > 0) {
        // Embree reads 16 bytes at each 12-byte vertex, so it gets a copy with room after the last rather than our own
        // array.
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* positions = static_cast<vec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(vec3), scene.positions.size()));
        auto* indices = static_cast<uvec3*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(uvec3), count));
        if (positions && indices) {
            std::transform(scene.positions.begin(), scene.positions.end(), positions,
                           [&](vec3 p) { return p - casters.shift; });
            for (size_t i = 0; i < count; ++i) indices[i] = scene.triangles[primitive_of.empty() ? i : members[i]];
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(built, geometry);
        }
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(built);
    try {
        check("building the ray tracing structure");
    } catch (...) {
        rtcReleaseScene(built);
        throw;
    }
    return built;
}

ShadowRays EmbreeScene::Implementation::shadow_rays(const Receiver& receiver, bool end) const {
    const std::uint32_t own = primitive_of.empty() ? receiver.triangle : primitive_of[receiver.triangle];
    const std::array<vec3, 3> corners = corners_of(receiver.triangle);
    return {casters, receiver, gnomon::shadow_origin(receiver, corners, casters.shift), own, corners, end};
}

std::array<vec3, 3> EmbreeScene::Implementation::corners_of(std::uint32_t triangle) const {
    const uvec3 t = scene.triangles[triangle];
    return {scene.positions[t.x] - casters.shift, scene.positions[t.y] - casters.shift,
            scene.positions[t.z] - casters.shift};
}

EmbreeScene::EmbreeScene(const Scene& scene) : implementation_(std::make_unique<Implementation>(scene)) {}
EmbreeScene::~EmbreeScene() = default;

EmbreeScene::Hit EmbreeScene::first_hit(vec3 origin, vec3 direction, float near_distance, float far_distance) const {
    const Implementation& self = *implementation_;
    origin -= shift();
    Hit nearest;
    nearest.distance = far_distance;
    const auto trace = [&](RTCScene scene, const std::vector<std::uint32_t>& triangles) {
        if (!scene) return;
        CameraQuery query{};
        start_query(query.context);
        query.distance = infinity;
        query.primitive = no_triangle;
        RTCRayHit ray{};
        ray.ray.org_x = origin.x, ray.ray.org_y = origin.y, ray.ray.org_z = origin.z;
        ray.ray.dir_x = direction.x, ray.ray.dir_y = direction.y, ray.ray.dir_z = direction.z;
        ray.ray.tnear = near_distance;
        ray.ray.tfar = nearest.distance;
        ray.ray.mask = 0xffffffffu;
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        intersect(scene, query.context, keep_lower_index, ray);
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
        const std::uint32_t triangle = triangles.empty() ? ray.hit.primID : triangles[ray.hit.primID];
        if (nearest.triangle != no_triangle && ray.ray.tfar == nearest.distance && triangle > nearest.triangle) return;
        nearest = {triangle, ray.ray.tfar};
    };
    trace(self.casters.built, self.casters.triangles);
    trace(self.light_sources, self.light_source_triangles);
    if (nearest.triangle == no_triangle) nearest.distance = 0.0f;
    return nearest;
}

void EmbreeScene::visible(const Receiver& receiver, std::span<const vec3> targets, std::span<std::uint8_t> seen) const {
    constexpr size_t most = ShadowRays::packet_size;
    assert(targets.size() <= most && seen.size() >= targets.size());
    if (targets.empty()) return;
    float x[most], y[most], z[most];
    for (size_t k = 0; k < targets.size(); ++k) {
        const vec3 target = targets[k] - shift();
        x[k] = target.x, y[k] = target.y, z[k] = target.z;
    }
    ShadowRays rays = implementation_->shadow_rays(to_local(receiver, shift()), true);
    const unsigned mask = rays.to_targets(x, y, z, targets.size()).seen;
    for (size_t k = 0; k < targets.size(); ++k) seen[k] = mask >> k & 1u;
}

EmbreeScene::SeenCount EmbreeScene::seen_samples(const Receiver& receiver, std::span<const float> x,
                                                 std::span<const float> y, std::span<const float> z,
                                                 std::span<std::uint16_t> seen) const {
    constexpr size_t packet = ShadowRays::packet_size;
    ShadowRays rays = rays_from(receiver);
    SeenCount answer;
    for (size_t first = 0; first < x.size(); first += packet) {
        const size_t count = std::min(packet, x.size() - first);
        const ShadowRays::Mask mask = rays.to_targets(&x[first], &y[first], &z[first], count);
        seen[first / packet] = static_cast<std::uint16_t>(mask.seen);
        answer.seen += ones(mask.seen);
        answer.rays += ones(mask.traced);
    }
    return answer;
}

ShadowRays EmbreeScene::rays_from(const Receiver& receiver) const {
    return implementation_->shadow_rays(receiver, true);
}

bool EmbreeScene::visible_direction(const Receiver& receiver, vec3 unit_direction) const {
    return seen_direction(to_local(receiver, shift()), unit_direction);
}

vec3 EmbreeScene::shift() const { return implementation_->casters.shift; }

bool EmbreeScene::seen_direction(const Receiver& receiver, vec3 unit_direction) const {
    if (!(glm::dot(receiver.geometric_normal, unit_direction) > 0.0f)) return false;
    return implementation_->shadow_rays(receiver, false).to_direction(unit_direction);
}

ShadowOrigin EmbreeScene::shadow_origin(const Receiver& receiver) const {
    return gnomon::shadow_origin(receiver, corners(receiver.triangle), shift());
}

std::array<vec3, 3> EmbreeScene::corners(std::uint32_t triangle) const { return implementation_->corners_of(triangle); }

size_t EmbreeScene::memory_bytes() const {
    return static_cast<size_t>(std::max<std::ptrdiff_t>(0, implementation_->bytes));
}

} // namespace gnomon
