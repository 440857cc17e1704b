#pragma once
// Shadow volumes as geometry, for any triangles whatever: closed or open, with edges that any number of triangles
// share, wound either way. Each triangle contributes its own volume, turned towards the light; where volumes share a
// face the two cancel in the counting and are never built, so what remains are the quads of silhouette edges with their
// multiplicities. The count that a stencil buffer ends with is the number of triangles between receiver and light.
// [Navrátil 2015, 2.2.2; Milet et al. 2014]

#include <vector>

#include "raster/target.h"
#include "techniques/frame.h"

namespace gnomon {

struct ShadowVolume {
    // Vertex i < finite.size() is finite[i]; vertex finite.size() + i is the same pushed to infinity away from the
    // light, and has w = 0.
    std::span<const vec3> finite;
    vec4 light;                                    // homogeneous: (position, 1), or (direction to the light, 0)
    std::vector<uvec3> sides, near_caps, far_caps; // counter-clockwise from outside the volume

    // Clip position of vertex i.
    vec4 vertex(std::uint32_t i, const mat4& to_clip) const {
        const auto n = static_cast<std::uint32_t>(finite.size());
        if (i < n) return transform(to_clip, finite[i]);
        return transform(to_clip, light.w > 0 ? finite[i - n] - vec3(light) : -vec3(light), 0.0f);
    }
};

// The volume of all casters for the light, seen as a point at its centre. Far caps are left out for a directional
// light: they shrink to a point at infinity. Sides and caps are watertight on any input: which way a triangle faces is
// decided once, in double, and all three of its edges use that sign.
ShadowVolume build_shadow_volume(Frame& frame, const Light& light);

enum class StencilBits { S32, S8 };

// The passes that all stencil techniques share: depth of the scene, the volume two-sided into the stencil buffer under
// the given state, and V = (stencil = 0).
enum class VolumeTest { DepthPass, DepthFail };
Image<float> stencil_shadows(Frame& frame, const Light& light, const ShadowVolume& volume, VolumeTest test,
                             StencilBits bits, std::uint32_t initial_count);

// The number of casters between the eye and the light: what the stencil buffer starts with for the depth-pass test.
std::uint32_t count_volumes_around_eye(Frame& frame, const ShadowVolume& volume);

} // namespace gnomon
