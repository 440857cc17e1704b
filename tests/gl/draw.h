#pragma once
// Draw calls in OpenGL that mirror raster/draw.h: the same pipeline state over the same vertices.

#include <span>
#include <string>

#include "core/math.h"
#include "raster/state.h"

namespace gnomon_gl {

// Compiled and linked; throws std::runtime_error with the driver's log.
class Program {
public:
    Program(const std::string& vertex_source, const std::string& fragment_source);
    ~Program();
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    void use() const;
    void set(const char* uniform, const gnomon::mat4& value) const;
    void set(const char* uniform, gnomon::vec4 value) const;
    void set(const char* uniform, float value) const;

private:
    std::uint32_t program_;
};

// Vertices and indices in the device's memory. Attribute 0 is the position (3 or 4 floats), attribute 1 an optional
// second one of 3 or 4 floats.
class Mesh {
public:
    Mesh(std::span<const gnomon::vec4> positions, std::span<const gnomon::uvec3> triangles,
         std::span<const gnomon::vec4> second = {});
    Mesh(std::span<const gnomon::vec3> positions, std::span<const gnomon::uvec3> triangles,
         std::span<const gnomon::vec3> second = {});
    ~Mesh();
    Mesh(const Mesh&) = delete;
    Mesh& operator=(const Mesh&) = delete;

    void draw() const;       // all triangles, with the program in use
    void draw_lines() const; // a line between every two vertices instead

private:
    void upload(int components, std::span<const float> positions, std::span<const float> second,
                std::span<const gnomon::uvec3> triangles);
    std::uint32_t vertex_array_ = 0, buffers_[3] = {};
    int index_count_ = 0, vertex_count_ = 0;
};

// GL_EXT_depth_bounds_test.
bool has_depth_bounds();

// Viewport, scissor, depth, stencil, culling, polygon offset, blending and masks for a target of this size. Depth and
// stencil tests are on wherever the state has an effect. Throws std::runtime_error for what this OpenGL lacks.
void set_state(const gnomon::PipelineState& state, int width, int height);

// Two triangles that fill the viewport, with a program of screen_vertex_source: uniform float z is their clip-space
// depth.
extern const char* const screen_vertex_source;
class Screen {
public:
    Screen();
    ~Screen();
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;
    void draw() const;

private:
    std::uint32_t vertex_array_ = 0; // the core profile draws nothing without one
};

void finish(); // waits until everything is drawn

} // namespace gnomon_gl
