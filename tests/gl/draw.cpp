#include "tests/gl/draw.h"

#include <cstring>
#include <stdexcept>

#define EGL_NO_X11
#define GL_GLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <GL/glcorearb.h>

namespace gnomon_gl {
namespace {

using namespace gnomon;

constexpr GLenum GL_DEPTH_BOUNDS_TEST_EXT = 0x8890; // of no core header

GLuint compile(GLenum stage, const std::string& source) {
    const GLuint shader = glCreateShader(stage);
    const char* text = source.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint ok = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (!ok) {
        std::string log(4096, '\0');
        glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
        throw std::runtime_error("shader: " + log);
    }
    return shader;
}

GLenum gl(Compare test) { return static_cast<GLenum>(GL_NEVER + static_cast<int>(test)); } // the same order

GLenum gl(StencilOp op) {
    constexpr GLenum ops[] = {GL_KEEP, GL_ZERO, GL_REPLACE, GL_INCR, GL_DECR, GL_INVERT, GL_INCR_WRAP, GL_DECR_WRAP};
    return ops[static_cast<size_t>(op)];
}

GLenum gl(BlendFactor factor) {
    constexpr GLenum factors[] = {GL_ZERO,           GL_ONE,
                                  GL_SRC_COLOR,      GL_ONE_MINUS_SRC_COLOR,
                                  GL_DST_COLOR,      GL_ONE_MINUS_DST_COLOR,
                                  GL_SRC_ALPHA,      GL_ONE_MINUS_SRC_ALPHA,
                                  GL_DST_ALPHA,      GL_ONE_MINUS_DST_ALPHA,
                                  GL_CONSTANT_COLOR, GL_CONSTANT_ALPHA};
    return factors[static_cast<size_t>(factor)];
}

GLenum gl(BlendOp op) {
    constexpr GLenum ops[] = {GL_FUNC_ADD, GL_FUNC_SUBTRACT, GL_FUNC_REVERSE_SUBTRACT, GL_MIN, GL_MAX};
    return ops[static_cast<size_t>(op)];
}

void enable(GLenum capability, bool on) { (on ? glEnable : glDisable)(capability); }

void set_stencil_face(GLenum face, const StencilFace& f) {
    glStencilFuncSeparate(face, gl(f.test), static_cast<GLint>(f.reference), f.read_mask);
    glStencilOpSeparate(face, gl(f.fail), gl(f.depth_fail), gl(f.pass));
    glStencilMaskSeparate(face, f.write_mask);
}

void set_polygon_offset(const PolygonOffset& offset) {
    if (offset.clamp == 0) return glPolygonOffset(offset.factor, offset.units);
    // Core since 4.6; before, an extension by either name.
    for (const char* name : {"glPolygonOffsetClamp", "glPolygonOffsetClampEXT"})
        if (const auto set = reinterpret_cast<PFNGLPOLYGONOFFSETCLAMPPROC>(eglGetProcAddress(name)))
            return set(offset.factor, offset.units, offset.clamp);
    throw std::runtime_error("this OpenGL has no clamp of polygon offset");
}

void set_depth_bounds(const std::optional<DepthState::Bounds>& bounds) {
    if (!has_depth_bounds()) {
        if (bounds) throw std::runtime_error("this OpenGL has no depth bounds test");
        return;
    }
    enable(GL_DEPTH_BOUNDS_TEST_EXT, bounds.has_value());
    if (!bounds) return;
    using DepthBounds = void (*)(GLdouble minimum, GLdouble maximum);
    reinterpret_cast<DepthBounds>(eglGetProcAddress("glDepthBoundsEXT"))(bounds->minimum, bounds->maximum);
}

} // namespace

bool has_depth_bounds() {
    GLint count = 0;
    glGetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLuint i = 0; i < static_cast<GLuint>(count); ++i)
        if (std::strcmp(reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, i)), "GL_EXT_depth_bounds_test") == 0)
            return true;
    return false;
}

Program::Program(const std::string& vertex_source, const std::string& fragment_source) {
    program_ = glCreateProgram();
    const GLuint stages[2] = {compile(GL_VERTEX_SHADER, vertex_source), compile(GL_FRAGMENT_SHADER, fragment_source)};
    for (const GLuint stage : stages) glAttachShader(program_, stage);
    glLinkProgram(program_);
    for (const GLuint stage : stages) glDeleteShader(stage);
    GLint ok = 0;
    glGetProgramiv(program_, GL_LINK_STATUS, &ok);
    if (!ok) throw std::runtime_error("the shader program does not link");
}
Program::~Program() { glDeleteProgram(program_); }
void Program::use() const { glUseProgram(program_); }
void Program::set(const char* uniform, const mat4& value) const {
    glProgramUniformMatrix4fv(program_, glGetUniformLocation(program_, uniform), 1, GL_FALSE, &value[0][0]);
}
void Program::set(const char* uniform, vec4 value) const {
    glProgramUniform4fv(program_, glGetUniformLocation(program_, uniform), 1, &value.x);
}
void Program::set(const char* uniform, float value) const {
    glProgramUniform1f(program_, glGetUniformLocation(program_, uniform), value);
}

Mesh::Mesh(std::span<const vec4> positions, std::span<const uvec3> triangles, std::span<const vec4> second) {
    upload(4, {reinterpret_cast<const float*>(positions.data()), 4 * positions.size()},
           {reinterpret_cast<const float*>(second.data()), 4 * second.size()}, triangles);
}
Mesh::Mesh(std::span<const vec3> positions, std::span<const uvec3> triangles, std::span<const vec3> second) {
    upload(3, {reinterpret_cast<const float*>(positions.data()), 3 * positions.size()},
           {reinterpret_cast<const float*>(second.data()), 3 * second.size()}, triangles);
}
Mesh::~Mesh() {
    glDeleteVertexArrays(1, &vertex_array_);
    glDeleteBuffers(3, buffers_);
}

void Mesh::upload(int components, std::span<const float> positions, std::span<const float> second,
                  std::span<const uvec3> triangles) {
    index_count_ = static_cast<int>(3 * triangles.size());
    vertex_count_ = static_cast<int>(positions.size()) / components;
    glCreateVertexArrays(1, &vertex_array_);
    glCreateBuffers(3, buffers_);
    glNamedBufferStorage(buffers_[2], static_cast<GLsizeiptr>(triangles.size_bytes()), triangles.data(), 0);
    glVertexArrayElementBuffer(vertex_array_, buffers_[2]);
    const std::span<const float> attributes[2] = {positions, second};
    for (GLuint i = 0; i < 2; ++i) {
        if (attributes[i].empty()) continue;
        glNamedBufferStorage(buffers_[i], static_cast<GLsizeiptr>(attributes[i].size_bytes()), attributes[i].data(), 0);
        glVertexArrayVertexBuffer(vertex_array_, i, buffers_[i], 0, components * static_cast<GLsizei>(sizeof(float)));
        glVertexArrayAttribFormat(vertex_array_, i, components, GL_FLOAT, GL_FALSE, 0);
        glVertexArrayAttribBinding(vertex_array_, i, i);
        glEnableVertexArrayAttrib(vertex_array_, i);
    }
}

void Mesh::draw() const {
    glBindVertexArray(vertex_array_);
    glDrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
}

void Mesh::draw_lines() const {
    glBindVertexArray(vertex_array_);
    glDrawArrays(GL_LINES, 0, vertex_count_);
}

void set_state(const PipelineState& state, int width, int height) {
    set_depth_bounds(state.depth.bounds);
    const Rectangle viewport = state.viewport.value_or(Rectangle{0, 0, width, height});
    glViewport(viewport.x, viewport.y, viewport.width, viewport.height);
    enable(GL_SCISSOR_TEST, state.scissor.has_value());
    if (state.scissor) glScissor(state.scissor->x, state.scissor->y, state.scissor->width, state.scissor->height);
    glClipControl(GL_LOWER_LEFT, state.clip_depth == ClipDepth::ZeroToOne ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);

    enable(GL_DEPTH_TEST, true);
    glDepthFunc(gl(state.depth.test));
    glDepthMask(state.depth.write);
    enable(GL_DEPTH_CLAMP, state.depth.clamp);
    const PolygonOffset& offset = state.polygon_offset;
    enable(GL_POLYGON_OFFSET_FILL, offset.factor != 0 || offset.units != 0);
    set_polygon_offset(offset);

    enable(GL_STENCIL_TEST, state.stencil.enabled);
    set_stencil_face(GL_FRONT, state.stencil.front);
    set_stencil_face(GL_BACK, state.stencil.back);

    enable(GL_CULL_FACE, state.cull != Cull::None);
    if (state.cull != Cull::None) glCullFace(state.cull == Cull::Front ? GL_FRONT : GL_BACK);
    glFrontFace(state.front_face == FrontFace::CounterClockwise ? GL_CCW : GL_CW);

    const BlendState& blend = state.blend;
    enable(GL_BLEND, blend.enabled);
    glBlendFuncSeparate(gl(blend.source_color), gl(blend.destination_color), gl(blend.source_alpha),
                        gl(blend.destination_alpha));
    glBlendEquationSeparate(gl(blend.color), gl(blend.alpha));
    glBlendColor(blend.constant.x, blend.constant.y, blend.constant.z, blend.constant.w);
    for (GLuint i = 0; i < max_color_targets; ++i) {
        const auto bit = [&](int channel) { return static_cast<GLboolean>(state.color_mask[i] >> channel & 1); };
        glColorMaski(i, bit(0), bit(1), bit(2), bit(3));
    }
}

const char* const screen_vertex_source = R"(#version 450 core
uniform float z;
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0, z, 1.0); })";

Screen::Screen() { glCreateVertexArrays(1, &vertex_array_); }
Screen::~Screen() { glDeleteVertexArrays(1, &vertex_array_); }
void Screen::draw() const {
    glBindVertexArray(vertex_array_);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
}

void finish() { glFinish(); }

} // namespace gnomon_gl
