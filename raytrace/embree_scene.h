#pragma once
// The scene as Embree sees it: one triangle mesh of the very same float32 vertices that the rasterizer draws, robust
// traversal, high build quality; far from the origin they are moved there, exactly. Answers whether a receiver sees a
// point, and what a camera ray meets first. Triangles of objects that are light sources are seen by camera rays and
// never cast shadows.

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/receiver.h"
#include "core/scene.h"
#include "raytrace/shadow_origin.h"

namespace gnomon {

class ShadowRays;

class EmbreeScene {
public:
    explicit EmbreeScene(const Scene& scene); // `scene` must outlive this
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    struct Hit {
        std::uint32_t triangle = no_triangle;
        float distance = 0; // metres along the unit direction
    };
    // Of triangles at exactly the same distance (a shared edge) the one of the lowest index.
    Hit first_hit(vec3 origin, vec3 direction, float near_distance, float far_distance) const;

    // 1 where the receiver sees the target point, 0 where not, for up to 16 targets of one receiver. Targets below the
    // horizon of the geometric normal are not seen. Self-hits are excluded by construction: the origin is offset along
    // the normal by a step scaled with the magnitude of the coordinates, and the receiver's own triangle is never an
    // occluder.
    void visible(const Receiver& receiver, std::span<const vec3> targets, std::span<std::uint8_t> seen) const;
    // The same for a direction with no end (directional lights).
    bool visible_direction(const Receiver& receiver, vec3 unit_direction) const;

    // What follows speaks of local coordinates: those of the world minus this, see local_shift. Receivers are local,
    // too.
    vec3 shift() const;

    // The same for any number of targets, given as three arrays of coordinates: target k is bit k % 16 of seen[k / 16].
    // Sixteen neighbours in the arrays share a packet, so targets that lie close together cost less.
    struct SeenCount {
        std::size_t seen = 0;
        std::int64_t rays = 0; // traced: those to targets above the horizon
    };
    SeenCount seen_samples(const Receiver& receiver, std::span<const float> x, std::span<const float> y,
                           std::span<const float> z, std::span<std::uint16_t> seen) const;

    bool seen_direction(const Receiver& receiver, vec3 unit_direction) const;

    // The rays of seen_samples, for who asks packet by packet. The scene must outlive them.
    ShadowRays rays_from(const Receiver& receiver) const;

    ShadowOrigin shadow_origin(const Receiver& receiver) const;
    std::array<vec3, 3> corners(std::uint32_t triangle) const;

    // Bytes that Embree holds.
    std::size_t memory_bytes() const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

} // namespace gnomon
