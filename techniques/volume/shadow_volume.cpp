#include "techniques/volume/shadow_volume.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <optional>

#include "core/parallel.h"
#include "raster/draw.h"

namespace gnomon {
namespace {

int sign(double value) { return (value > 0) - (value < 0); }

// +1 where the light sees p, q, r counter-clockwise, −1 clockwise, 0 edge-on.
int light_side(dvec3 p, dvec3 q, dvec3 r, dvec4 light) {
    return sign(glm::dot(glm::cross(r - p, dvec3(light) - p * light.w), q - p));
}

// A triangle's corners in increasing order of welded index, so that every user of its sign sees the same expression.
uvec3 sorted(uvec3 t) {
    if (t.x > t.y) std::swap(t.x, t.y);
    if (t.y > t.z) std::swap(t.y, t.z);
    if (t.x > t.y) std::swap(t.x, t.y);
    return t;
}

std::vector<std::int8_t> facing_signs(const Frame& frame, const Adjacency& adjacency, dvec4 light) {
    const Scene& scene = frame.scene();
    std::vector<std::int8_t> signs(adjacency.triangles.size());
    parallel_for(signs.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const bool caster = !scene.objects[scene.triangle_objects[i]].light_source && !adjacency.degenerate[i];
            const uvec3 t = sorted(adjacency.triangles[i]);
            const auto at = [&](std::uint32_t v) { return dvec3(adjacency.positions[v]); };
            signs[i] = static_cast<std::int8_t>(caster ? light_side(at(t.x), at(t.y), at(t.z), light) : 0);
        }
    });
    return signs;
}

// How often and which way the edge start → end bounds the union of all volumes: the sum over its triangles, each seen
// as (p, q, r) with the edge as p→q, q→r (along) or p→r (against).
int multiplicity(const Adjacency& adjacency, const Adjacency::Edge& edge, const std::vector<std::int8_t>& signs) {
    int sum = 0;
    for (std::uint32_t k = 0; k < edge.triangle_count; ++k) {
        const std::uint32_t triangle = adjacency.edge_triangles[edge.first_triangle + k];
        const uvec3 t = adjacency.triangles[triangle];
        const std::uint32_t opposite = t.x ^ t.y ^ t.z ^ edge.start ^ edge.end;
        const bool between = opposite > edge.start && opposite < edge.end;
        sum += between ? -signs[triangle] : signs[triangle];
    }
    return sum;
}

// The scene's depth, for comparing with caps that must meet it bit for bit. Caps are drawn with depth clamp, where the
// near plane cuts nothing; a triangle that it did cut would get other vertices and another plane. So where something
// reaches across the near plane the scene is clamped too, and the fragments in front of the plane, clamped to zero, are
// discarded.
void draw_scene_depth(Frame& frame, const mat4& to_clip, Target& depth) {
    Pass pass = frame.pass("scene depth");
    const Scene& scene = frame.scene();
    const auto vertex = [&](std::uint32_t i) { return transform(to_clip, scene.positions[i]); };
    const auto discard_in_front = [](const Fragment<NoVaryings>& in, FragmentOutput& out) {
        out.discarded = in.depth <= 0;
    };
    const auto vertices = static_cast<std::uint32_t>(scene.positions.size());
    bool crosses_near_plane = false;
    for (std::uint32_t i = 0; i < vertices && !crosses_near_plane; ++i) {
        const vec4 p = vertex(i);
        crosses_near_plane = p.z < -p.w;
    }
    PipelineState state;
    state.depth = {.test = Compare::Less, .write = true, .clamp = crosses_near_plane};
    if (crosses_near_plane)
        draw(pass, {vertices, scene.triangles}, state, vertex, FragmentProgram{discard_in_front, {.discards = true}},
             Targets{.depth = &depth, .clear_depth = 1.0f});
    else
        draw(pass, {vertices, scene.triangles}, state, vertex, depth_only,
             Targets{.depth = &depth, .clear_depth = 1.0f});
}

} // namespace

ShadowVolume build_shadow_volume(Frame& frame, const Light& light) {
    const Adjacency& adjacency = frame.adjacency();
    ShadowVolume volume;
    volume.finite = adjacency.positions;
    const bool directional = light.type == LightType::Directional;
    volume.light = directional ? vec4(-light.direction, 0.0f) : vec4(light.position, 1.0f);
    const std::vector<std::int8_t> signs = facing_signs(frame, adjacency, dvec4(volume.light));
    const auto infinite = static_cast<std::uint32_t>(adjacency.positions.size());

    for (const Adjacency::Edge& edge : adjacency.edges) {
        const int count = multiplicity(adjacency, edge, signs);
        std::uint32_t a = edge.start, b = edge.end;
        if (count < 0) std::swap(a, b);
        for (int i = 0; i < std::abs(count); ++i) { // quad b, a, a∞, b∞; a directional light's a∞ = b∞
            volume.sides.push_back({b, a, infinite + a});
            if (!directional) volume.sides.push_back({b, infinite + a, infinite + b});
        }
    }
    for (size_t i = 0; i < signs.size(); ++i) {
        if (signs[i] == 0) continue;
        uvec3 t = sorted(adjacency.triangles[i]);
        if (signs[i] < 0) std::swap(t.y, t.z);
        volume.near_caps.push_back(t);
        if (!directional) volume.far_caps.push_back({infinite + t.z, infinite + t.y, infinite + t.x});
    }
    return volume;
}

Image<float> stencil_shadows(Frame& frame, const Light& light, const ShadowVolume& volume, VolumeTest test,
                             StencilBits bits, std::uint32_t initial_count) {
    const mat4 to_clip(infinite_projection_matrix(frame.camera(), frame.aspect()) * view_matrix(frame.camera()));
    Target depth = frame.target(Format::D32F, frame.width(), frame.height());
    Target stencil = frame.target(bits == StencilBits::S8 ? Format::S8 : Format::S32, frame.width(), frame.height());
    draw_scene_depth(frame, to_clip, depth);
    {
        Pass pass = frame.pass("volumes");
        PipelineState state;
        state.depth = {.test = Compare::Less, .write = false, .clamp = test == VolumeTest::DepthFail};
        state.stencil.enabled = true;
        if (test == VolumeTest::DepthFail) {
            state.stencil.front.depth_fail = StencilOp::DecrementWrap;
            state.stencil.back.depth_fail = StencilOp::IncrementWrap;
        } else {
            state.stencil.front.pass = StencilOp::IncrementWrap;
            state.stencil.back.pass = StencilOp::DecrementWrap;
        }
        std::optional<std::uint32_t> clear = initial_count; // by the first draw
        const auto draw_part = [&](const std::vector<uvec3>& triangles) {
            draw(
                pass, {static_cast<std::uint32_t>(2 * volume.finite.size()), triangles}, state,
                [&](std::uint32_t i) { return volume.vertex(i, to_clip); }, depth_only,
                Targets{.depth = &depth, .stencil = &stencil, .clear_stencil = clear});
            clear.reset();
        };
        draw_part(volume.sides);
        if (test == VolumeTest::DepthFail) {
            draw_part(volume.near_caps);
            draw_part(volume.far_caps);
        }
    }
    return for_each_receiver(frame, "look-up", [&](const Receiver& receiver, Pixel& pixel) {
        pixel.counters.bytes_read += info(stencil.format()).bytes;
        const bool outside = stencil.load_key(pixel.x, pixel.y) == 0;
        // An edge-on caster has no volume to darken its own unlit side.
        return outside && faces_light(receiver, light) ? 1.0f : 0.0f;
    });
}

std::uint32_t count_volumes_around_eye(Frame& frame, const ShadowVolume& volume) {
    // The eye lies in a triangle's volume where the eye and the light are on different sides of it and the line between
    // them passes all three edges on the same side.
    const Adjacency& adjacency = frame.adjacency();
    const dvec3 eye(frame.camera().position);
    const dvec4 light(volume.light);
    std::atomic<std::uint32_t> count{0};
    parallel_for(volume.near_caps.size(), 16384, [&](size_t begin, size_t end) {
        std::uint32_t inside = 0;
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = volume.near_caps[i]; // counter-clockwise from the light
            const dvec3 a(adjacency.positions[t.x]), b(adjacency.positions[t.y]), c(adjacency.positions[t.z]);
            const bool behind = glm::dot(glm::cross(b - a, c - a), eye - a) < 0;
            inside += behind && light_side(a, b, eye, light) >= 0 && light_side(b, c, eye, light) >= 0 &&
                      light_side(c, a, eye, light) >= 0;
        }
        count += inside;
    });
    return count;
}

} // namespace gnomon
