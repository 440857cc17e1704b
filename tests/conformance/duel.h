#pragma once
// The same draws through Gnomon and through OpenGL, and what each leaves in its targets.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raster/draw.h"
#include "tests/gl/draw.h"
#include "tests/gl/framebuffer.h"

namespace gnomon_conformance {

using namespace gnomon;

// Triangles with their positions in clip space, computed once for both sides. Each may have a colour.
struct Batch {
    std::vector<vec4> positions;
    std::vector<uvec3> triangles;
    std::vector<vec4> colors = {}; // per triangle; empty: all zero

    // One more triangle with vertices of its own.
    void add(const vec4& a, const vec4& b, const vec4& c);
};

struct Picture {
    std::vector<std::uint32_t> depth;   // keys
    std::vector<std::uint32_t> stencil; // counts; empty without a stencil target
    std::vector<std::uint32_t> ids;     // primitive, or no_id
    std::vector<vec4> color;            // empty without a colour target
};
inline constexpr std::uint32_t no_id = 0xffffffffu;

struct Arena {
    int width = 0, height = 0;
    Format depth = Format::D24;   // with 8 bits of stencil beside, but for D16, which OpenGL gives none
    Format color = Format::R32UI; // R32UI: primitive ids; others: the triangle's colour
};

class Duel {
public:
    explicit Duel(const Arena& arena);

    int width() const { return arena_.width; }
    int height() const { return arena_.height; }
    size_t pixels() const { return static_cast<size_t>(arena_.width) * static_cast<size_t>(arena_.height); }

    void clear(float depth = 1.0f, std::uint32_t stencil = 0, vec4 color = vec4(0.0f));
    void draw(const Batch& batch, const PipelineState& state);

    // Lines between every two of `ends` there, the triangles that stand for them here.
    void draw_lines(std::span<const vec4> ends, const Batch& quads, const PipelineState& state);

    // World-space vertices under a matrix: each side multiplies for itself, in float32, in the order of transform().
    void draw_transformed(std::span<const vec3> positions, std::span<const uvec3> triangles, const mat4& to_clip,
                          const PipelineState& state);

    Picture ours() const;
    Picture witness() const;
    const PassCounters& counters() const { return log_.passes.back(); } // of the last draw

private:
    void draw_ours(const Batch& batch, const PipelineState& state);
    Targets targets();
    bool has_stencil() const { return arena_.depth != Format::D16; }

    Arena arena_;
    PassLog log_;
    Target depth_, stencil_, color_;
    gnomon_gl::Framebuffer framebuffer_;
    gnomon_gl::Program id_program_, color_program_, transform_program_;
};

// A state that draws everything in order over what is there: depth test off, no depth write, stencil counts fragments.
PipelineState counting_state();

} // namespace gnomon_conformance
