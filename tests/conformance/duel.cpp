#include "tests/conformance/duel.h"

namespace gnomon_conformance {
namespace {

const char* const clip_vertex_source = R"(#version 450 core
layout(location = 0) in vec4 position;
layout(location = 1) in vec4 color;
flat out vec4 flat_color;
void main() { gl_Position = position; flat_color = color; })";

// The order of float operations of transform() in core/math.h.
const char* const transform_vertex_source = R"(#version 450 core
layout(location = 0) in vec3 p;
uniform mat4 m;
void main() {
    precise vec4 clip = (m[0] * p.x + m[1] * p.y) + (m[2] * p.z + m[3] * 1.0);
    gl_Position = clip;
})";

const char* const id_fragment_source = R"(#version 450 core
layout(location = 0) out uint id;
void main() { id = uint(gl_PrimitiveID); })";

const char* const color_fragment_source = R"(#version 450 core
flat in vec4 flat_color;
layout(location = 0) out vec4 color;
void main() { color = flat_color; })";

} // namespace

void Batch::add(const vec4& a, const vec4& b, const vec4& c) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    positions.insert(positions.end(), {a, b, c});
    triangles.push_back({first, first + 1, first + 2});
}

Duel::Duel(const Arena& arena)
    : arena_(arena), depth_(arena.depth, arena.width, arena.height), stencil_(Format::S8, arena.width, arena.height),
      color_(arena.color, arena.width, arena.height),
      framebuffer_({.width = arena.width, .height = arena.height, .depth = arena.depth, .color = {arena.color}}),
      id_program_(clip_vertex_source, id_fragment_source), color_program_(clip_vertex_source, color_fragment_source),
      transform_program_(transform_vertex_source, id_fragment_source) {}

Targets Duel::targets() {
    return {.depth = &depth_, .stencil = has_stencil() ? &stencil_ : nullptr, .color = {&color_}};
}

void Duel::clear(float depth, std::uint32_t stencil, vec4 color) {
    Pass pass(log_, "clear");
    depth_.clear_depth(pass, depth);
    stencil_.clear_uint(pass, stencil);
    framebuffer_.clear_depth(depth);
    if (has_stencil()) framebuffer_.clear_stencil(stencil);
    if (arena_.color == Format::R32UI) {
        color_.clear_uint(pass, no_id);
        framebuffer_.clear_uint(0, no_id);
    } else {
        color_.clear(pass, color);
        framebuffer_.clear_color(0, color);
    }
}

void Duel::draw(const Batch& batch, const PipelineState& state) {
    draw_ours(batch, state);
    const bool ids = arena_.color == Format::R32UI;
    std::vector<vec4> colors; // flat: OpenGL takes the last vertex's
    if (!ids) {
        colors.resize(batch.positions.size());
        for (size_t i = 0; i < batch.colors.size(); ++i) colors[batch.triangles[i].z] = batch.colors[i];
    }
    const gnomon_gl::Mesh mesh(batch.positions, batch.triangles, colors);
    framebuffer_.bind();
    gnomon_gl::set_state(state, arena_.width, arena_.height);
    (ids ? id_program_ : color_program_).use();
    mesh.draw();
}

void Duel::draw_lines(std::span<const vec4> ends, const Batch& quads, const PipelineState& state) {
    draw_ours(quads, state);
    const gnomon_gl::Mesh mesh(ends, quads.triangles);
    framebuffer_.bind();
    gnomon_gl::set_state(state, arena_.width, arena_.height);
    id_program_.use();
    mesh.draw_lines();
}

void Duel::draw_ours(const Batch& batch, const PipelineState& state) {
    if (log_.passes.size() > 100) log_.passes.clear();
    const bool ids = arena_.color == Format::R32UI;
    const auto vertex = [&](std::uint32_t i) { return batch.positions[i]; };
    const Geometry geometry = {static_cast<std::uint32_t>(batch.positions.size()), batch.triangles};
    Pass pass(log_, "duel");
    gnomon::draw(
        pass, geometry, state, vertex,
        [&](const Fragment<NoVaryings>& in, FragmentOutput& out) {
            if (ids)
                out.color[0].x = glm::uintBitsToFloat(in.primitive);
            else if (!batch.colors.empty())
                out.color[0] = batch.colors[in.primitive];
        },
        targets());
}

void Duel::draw_transformed(std::span<const vec3> positions, std::span<const uvec3> triangles, const mat4& to_clip,
                            const PipelineState& state) {
    {
        Pass pass(log_, "duel");
        gnomon::draw(
            pass, {static_cast<std::uint32_t>(positions.size()), triangles}, state,
            [&](std::uint32_t i) { return transform(to_clip, positions[i]); },
            [](const Fragment<NoVaryings>& in, FragmentOutput& out) {
                out.color[0].x = glm::uintBitsToFloat(in.primitive);
            },
            targets());
    }
    const gnomon_gl::Mesh mesh(positions, triangles);
    framebuffer_.bind();
    gnomon_gl::set_state(state, arena_.width, arena_.height);
    transform_program_.set("m", to_clip);
    transform_program_.use();
    mesh.draw();
}

Picture Duel::ours() const {
    Picture p;
    p.depth.reserve(pixels()), p.stencil.reserve(pixels());
    const bool ids = arena_.color == Format::R32UI;
    for (int y = 0; y < arena_.height; ++y)
        for (int x = 0; x < arena_.width; ++x) {
            p.depth.push_back(depth_.load_key(x, y));
            if (has_stencil()) p.stencil.push_back(stencil_.load_key(x, y));
            if (ids)
                p.ids.push_back(color_.load_uint(x, y).x);
            else
                p.color.push_back(color_.load(x, y));
        }
    return p;
}

Picture Duel::witness() const {
    Picture p;
    p.depth = framebuffer_.depth_keys();
    if (has_stencil()) p.stencil = framebuffer_.stencil();
    if (arena_.color == Format::R32UI)
        p.ids = framebuffer_.uints(0);
    else
        p.color = framebuffer_.colors(0);
    return p;
}

PipelineState counting_state() {
    PipelineState state;
    state.stencil.enabled = true;
    for (StencilFace* face : {&state.stencil.front, &state.stencil.back})
        face->fail = face->depth_fail = face->pass = StencilOp::IncrementWrap;
    return state;
}

} // namespace gnomon_conformance
