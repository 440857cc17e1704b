#include "raytrace/embree_scene.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#if __has_include(<embree3/rtcore.h>)
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include "core/error.h"
#include "core/parallel.h"
#include "core/vector_clones.h"
#include "raytrace/false_hits.h"

namespace gnomon {
namespace {

constexpr size_t packet_size = 16;

// The two Embree generations differ in where a query's flags and filter go; the rest of this file knows neither.
#if RTC_VERSION_MAJOR >= 4
using QueryContext = RTCRayQueryContext;
constexpr RTCSceneFlags filter_in_query = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
void start_query(QueryContext& context) { rtcInitRayQueryContext(&context); }
void occluded(const int* valid, RTCScene scene, QueryContext& context, RTCFilterFunctionN filter, RTCRay16& rays) {
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context;
    arguments.filter = filter;
    arguments.flags =
        static_cast<RTCRayQueryFlags>(RTC_RAY_QUERY_FLAG_INCOHERENT | RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);
    rtcOccluded16(valid, scene, &rays, &arguments);
}
void intersect(RTCScene scene, QueryContext& context, RTCFilterFunctionN filter, RTCRayHit& ray) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    arguments.filter = filter;
    arguments.flags =
        static_cast<RTCRayQueryFlags>(RTC_RAY_QUERY_FLAG_INCOHERENT | RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);
    rtcIntersect1(scene, &ray, &arguments);
}
#else
using QueryContext = RTCIntersectContext;
constexpr RTCSceneFlags filter_in_query = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
void start_query(QueryContext& context) { rtcInitIntersectContext(&context); }
void occluded(const int* valid, RTCScene scene, QueryContext& context, RTCFilterFunctionN filter, RTCRay16& rays) {
    context.filter = filter;
    rtcOccluded16(valid, scene, &context, &rays);
}
void intersect(RTCScene scene, QueryContext& context, RTCFilterFunctionN filter, RTCRayHit& ray) {
    context.filter = filter;
    rtcIntersect1(scene, &context, &ray);
}
#endif

// Embree hands the context back to a filter, so what the filter needs to know follows it in memory.
struct ShadowQuery {
    QueryContext context;
    bool ends; // whether its rays have an end: lights at a distance
    std::uint32_t own_primitive;
    std::array<dvec3, 3> own_corners;
    const Scene* scene;
    const std::vector<std::uint32_t>* members; // primitive to triangle; empty where they are the same
    const float* steep;                        // per primitive, see steep_hit
    float nearest;                             // see ShadowOrigin::rounding
    std::uint32_t looked_at;                   // primitive of `triangle`: neighbouring packets meet it again
    HitTriangle triangle;
};

std::array<vec3, 3> corners_of(const ShadowQuery& query, std::uint32_t primitive) {
    const uvec3 corners = query.scene->triangles[query.members->empty() ? primitive : (*query.members)[primitive]];
    return {query.scene->positions[corners.x], query.scene->positions[corners.y], query.scene->positions[corners.z]};
}

// A hit is no false one where the ray meets the triangle steeply and starts well off its plane, which the hit itself
// tells; the others are looked at one by one.
inline bool is_doubtful(vec3 normal, vec3 way, float distance, float steep, float nearest) {
    const float across = std::abs(normal.x * way.x + normal.y * way.y + normal.z * way.z);
    const float away = nearest * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z));
    return !((across > steep * largest_component(way)) & (distance * across > away));
}

GNOMON_VECTOR_CLONES
void find_doubtful(const float* normals, const float* rays, size_t n, float steep, float nearest,
                   int* __restrict doubtful) {
    const float *way = rays + 4 * n, *distance = rays + 8 * n;
    for (size_t i = 0; i < n; ++i)
        doubtful[i] = is_doubtful({normals[i], normals[n + i], normals[2 * n + i]},
                                  {way[i], way[n + i], way[2 * n + i]}, distance[i], steep, nearest)
                          ? -1
                          : 0;
}

// All lanes that Embree asks about have met the same triangle, or there is one lane.
void reject_false_hits(const RTCFilterFunctionNArguments* arguments) {
    auto* query = reinterpret_cast<ShadowQuery*>(arguments->context);
    const unsigned count = arguments->N;
    int* const valid = arguments->valid;
    unsigned first = 0;
    while (first + 1 < count && valid[first] != -1) ++first;
    const std::uint32_t primitive = RTCHitN_primID(arguments->hit, count, first);
    if (primitive == query->own_primitive) {
        std::fill_n(valid, count, 0);
        return;
    }
    int doubtful[packet_size];
    const float steep = query->ends ? query->steep[primitive] : infinity;
    find_doubtful(&RTCHitN_Ng_x(arguments->hit, count, 0), &RTCRayN_org_x(arguments->ray, count, 0), count, steep,
                  query->nearest, doubtful);
    for (unsigned i = first; i < count; ++i) {
        if ((valid[i] & doubtful[i]) == 0) continue;
        if (query->looked_at != primitive) {
            query->looked_at = primitive;
            query->triangle = hit_triangle(corners_of(*query, primitive), query->own_corners);
        }
        RTCRayN* rays = arguments->ray;
        const vec3 start(RTCRayN_org_x(rays, count, i), RTCRayN_org_y(rays, count, i), RTCRayN_org_z(rays, count, i));
        const vec3 way(RTCRayN_dir_x(rays, count, i), RTCRayN_dir_y(rays, count, i), RTCRayN_dir_z(rays, count, i));
        if (is_false_hit(query->triangle, start, way, query->ends)) valid[i] = 0;
    }
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

// A receiver's position is a float32 point that was computed to lie on its triangle: it is off the triangle's plane by
// a few units in the last place of the largest coordinate that took part (those of the point and of the triangle's
// vertices), and Embree's distance to the plane is wrong by about as much again. 2⁻¹⁹ of that coordinate is 8 to 16
// such units: enough for both, and 20 µm in a scene of 10 m. The receiver's own triangle is excluded as well, because
// the plane of a sliver is known less well.
ShadowOrigin shadow_origin(const Scene& scene, const Receiver& receiver) {
    float magnitude = largest_component(receiver.position);
    const uvec3 corners = scene.triangles[receiver.triangle];
    for (int k = 0; k < 3; ++k) magnitude = larger(magnitude, largest_component(scene.positions[corners[k]]));
    const float rounding = magnitude * relative_step;
    return {receiver.position + receiver.geometric_normal * rounding, rounding};
}

struct EmbreeScene::Implementation {
    const Scene& scene;
    RTCDevice device = nullptr;
    RTCScene casters = nullptr;
    RTCScene light_sources = nullptr; // null where the scene has none
    // Primitive of a scene to Scene::triangles; both empty where every triangle casts shadows and the numbers are the
    // same.
    std::vector<std::uint32_t> caster_triangles, light_source_triangles;
    std::vector<float> steep;                // per caster: see steep_hit
    std::vector<std::uint32_t> primitive_of; // per triangle of the scene: its primitive in whichever of the two has it
    std::atomic<std::ptrdiff_t> bytes{0};

    explicit Implementation(const Scene& s);
    ~Implementation() { release(); }
    void release();
    void check(const char* what) const;
    void separate_light_sources();
    RTCScene build(const std::vector<std::uint32_t>& members);
    void find_steep();

    std::uint32_t primitive(std::uint32_t triangle) const {
        return primitive_of.empty() ? triangle : primitive_of[triangle];
    }

    ShadowQuery shadow_query(const Receiver& receiver, const ShadowOrigin& origin, bool ends) const;
    struct Mask {
        unsigned seen, traced; // bit k: target k
    };
    Mask seen_mask(const ShadowOrigin& origin, ShadowQuery& query, const Receiver& receiver, const float* x,
                   const float* y, const float* z, size_t count) const;
};

EmbreeScene::Implementation::Implementation(const Scene& s) : scene(s) {
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
        casters = build(caster_triangles);
        find_steep();
        if (!light_source_triangles.empty()) light_sources = build(light_source_triangles);
    } catch (...) {
        release(); // no destructor runs after a constructor that throws
        throw;
    }
}

void EmbreeScene::Implementation::release() {
    if (light_sources) rtcReleaseScene(light_sources);
    if (casters) rtcReleaseScene(casters);
    if (device) rtcReleaseDevice(device);
    light_sources = casters = nullptr;
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
            scene.objects[scene.triangle_objects[t]].light_source ? light_source_triangles : caster_triangles;
        primitive_of[t] = static_cast<std::uint32_t>(members.size());
        members.push_back(t);
    }
}

void EmbreeScene::Implementation::find_steep() {
    float magnitude = 0.0f;
    for (const vec3& p : scene.positions) magnitude = larger(magnitude, largest_component(p));
    steep.resize(primitive_of.empty() ? scene.triangles.size() : caster_triangles.size());
    for (size_t i = 0; i < steep.size(); ++i) {
        const uvec3 t = scene.triangles[primitive_of.empty() ? i : caster_triangles[i]];
        steep[i] = steep_hit({scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]}, magnitude);
    }
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
            std::copy(scene.positions.begin(), scene.positions.end(), positions);
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

ShadowQuery EmbreeScene::Implementation::shadow_query(const Receiver& receiver, const ShadowOrigin& origin,
                                                      bool ends) const {
    ShadowQuery query{{},
                      ends,
                      primitive(receiver.triangle),
                      {},
                      &scene,
                      &caster_triangles,
                      steep.data(),
                      4 * origin.rounding,
                      no_triangle,
                      {}};
    const uvec3 corners = scene.triangles[receiver.triangle];
    for (int k = 0; k < 3; ++k) query.own_corners[static_cast<size_t>(k)] = dvec3(scene.positions[corners[k]]);
    start_query(query.context);
    return query;
}

// Fills a packet with the ways from the origin to 16 targets; lanes are valid where the target is above the receiver's
// horizon.
GNOMON_VECTOR_CLONES
void aim(const Receiver& receiver, vec3 origin, float origin_rounding, const float* x, const float* y, const float* z,
         RTCRay16& rays, int* __restrict valid) {
    for (size_t k = 0; k < packet_size; ++k) {
        const vec3 target(x[k], y[k], z[k]);
        const vec3 way = target - origin;
        valid[k] = faces(receiver, target) ? -1 : 0;
        rays.org_x[k] = origin.x;
        rays.org_y[k] = origin.y;
        rays.org_z[k] = origin.z;
        rays.tnear[k] = 0.0f;
        rays.dir_x[k] = way.x;
        rays.dir_y[k] = way.y;
        rays.dir_z[k] = way.z;
        rays.time[k] = 0.0f;
        // The way is not normalised, so 1 is the target. The ray ends short of it by the rounding of its coordinates,
        // so that what touches the light from behind does not hide it.
        const float rounding = larger(origin_rounding, largest_component(target) * relative_step);
        rays.tfar[k] = larger(0.0f, 1.0f - rounding / largest_component(way));
        rays.mask[k] = 0xffffffffu;
        rays.id[k] = 0;
        rays.flags[k] = 0;
    }
}

// For up to 16 targets.
EmbreeScene::Implementation::Mask EmbreeScene::Implementation::seen_mask(const ShadowOrigin& origin, ShadowQuery& query,
                                                                         const Receiver& receiver, const float* x,
                                                                         const float* y, const float* z,
                                                                         size_t count) const {
    RTCRay16 rays;
    alignas(64) int valid[packet_size];
    if (count == packet_size) {
        aim(receiver, origin.position, origin.rounding, x, y, z, rays, valid);
    } else {
        float padded[3][packet_size] = {};
        std::copy_n(x, count, padded[0]);
        std::copy_n(y, count, padded[1]);
        std::copy_n(z, count, padded[2]);
        aim(receiver, origin.position, origin.rounding, padded[0], padded[1], padded[2], rays, valid);
        std::fill(valid + count, valid + packet_size, 0);
    }
    unsigned facing = 0, hidden = 0;
    for (unsigned k = 0; k < packet_size; ++k) facing |= (valid[k] ? 1u : 0u) << k;
    if (facing == 0) return {0, 0};
    occluded(valid, casters, query.context, reject_false_hits, rays);
    for (unsigned k = 0; k < packet_size; ++k) hidden |= (rays.tfar[k] < 0.0f ? 1u : 0u) << k;
    return {facing & ~hidden, facing};
}

EmbreeScene::EmbreeScene(const Scene& scene) : implementation_(std::make_unique<Implementation>(scene)) {}
EmbreeScene::~EmbreeScene() = default;

EmbreeScene::Hit EmbreeScene::first_hit(vec3 origin, vec3 direction, float near_distance, float far_distance) const {
    const Implementation& self = *implementation_;
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
    trace(self.casters, self.caster_triangles);
    trace(self.light_sources, self.light_source_triangles);
    if (nearest.triangle == no_triangle) nearest.distance = 0.0f;
    return nearest;
}

void EmbreeScene::visible(const Receiver& receiver, std::span<const vec3> targets, std::span<std::uint8_t> seen) const {
    assert(targets.size() <= packet_size && seen.size() >= targets.size());
    if (targets.empty()) return;
    float x[packet_size], y[packet_size], z[packet_size];
    for (size_t k = 0; k < targets.size(); ++k) x[k] = targets[k].x, y[k] = targets[k].y, z[k] = targets[k].z;
    const ShadowOrigin origin = gnomon::shadow_origin(implementation_->scene, receiver);
    ShadowQuery query = implementation_->shadow_query(receiver, origin, true);
    const unsigned mask = implementation_->seen_mask(origin, query, receiver, x, y, z, targets.size()).seen;
    for (size_t k = 0; k < targets.size(); ++k) seen[k] = mask >> k & 1u;
}

EmbreeScene::SeenCount EmbreeScene::seen_samples(const Receiver& receiver, std::span<const float> x,
                                                 std::span<const float> y, std::span<const float> z,
                                                 std::span<std::uint16_t> seen) const {
    const ShadowOrigin origin = gnomon::shadow_origin(implementation_->scene, receiver);
    ShadowQuery query = implementation_->shadow_query(receiver, origin, true);
    SeenCount answer;
    for (size_t first = 0; first < x.size(); first += packet_size) {
        const size_t count = std::min(packet_size, x.size() - first);
        const auto mask = implementation_->seen_mask(origin, query, receiver, &x[first], &y[first], &z[first], count);
        seen[first / packet_size] = static_cast<std::uint16_t>(mask.seen);
        answer.seen += static_cast<size_t>(__builtin_popcount(mask.seen));
        answer.rays += __builtin_popcount(mask.traced);
    }
    return answer;
}

bool EmbreeScene::visible_direction(const Receiver& receiver, vec3 unit_direction) const {
    if (!(glm::dot(receiver.geometric_normal, unit_direction) > 0.0f)) return false;
    const ShadowOrigin origin = gnomon::shadow_origin(implementation_->scene, receiver);
    ShadowQuery query = implementation_->shadow_query(receiver, origin, false);
    RTCRay16 rays{};
    alignas(64) int valid[packet_size] = {-1};
    rays.org_x[0] = origin.position.x, rays.org_y[0] = origin.position.y, rays.org_z[0] = origin.position.z;
    rays.dir_x[0] = unit_direction.x, rays.dir_y[0] = unit_direction.y, rays.dir_z[0] = unit_direction.z;
    rays.tfar[0] = infinity;
    rays.mask[0] = 0xffffffffu;
    occluded(valid, implementation_->casters, query.context, reject_false_hits, rays);
    return !(rays.tfar[0] < 0.0f);
}

ShadowOrigin EmbreeScene::shadow_origin(const Receiver& receiver) const {
    return gnomon::shadow_origin(implementation_->scene, receiver);
}

std::array<vec3, 3> EmbreeScene::corners(std::uint32_t triangle) const {
    const Scene& scene = implementation_->scene;
    const uvec3 t = scene.triangles[triangle];
    return {scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]};
}

size_t EmbreeScene::memory_bytes() const {
    return static_cast<size_t>(std::max<std::ptrdiff_t>(0, implementation_->bytes));
}

} // namespace gnomon
