#include "tests/gl/framebuffer.h"

#include <bit>
#include <stdexcept>
#include <string>

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

namespace gnomon_gl {
namespace {

using gnomon::Format;

GLenum internal_format(Format format, bool stencil) {
    switch (format) {
    case Format::D16:
        return GL_DEPTH_COMPONENT16;
    case Format::D24:
        return stencil ? GL_DEPTH24_STENCIL8 : GL_DEPTH_COMPONENT24;
    case Format::D32F:
        return stencil ? GL_DEPTH32F_STENCIL8 : GL_DEPTH_COMPONENT32F;
    case Format::R8:
        return GL_R8;
    case Format::RG8:
        return GL_RG8;
    case Format::RGBA8:
        return GL_RGBA8;
    case Format::R16:
        return GL_R16;
    case Format::RG16:
        return GL_RG16;
    case Format::RGBA16:
        return GL_RGBA16;
    case Format::R16F:
        return GL_R16F;
    case Format::RG16F:
        return GL_RG16F;
    case Format::RGBA16F:
        return GL_RGBA16F;
    case Format::R32F:
        return GL_R32F;
    case Format::RG32F:
        return GL_RG32F;
    case Format::RGBA32F:
        return GL_RGBA32F;
    case Format::R32UI:
        return GL_R32UI;
    default:
        throw std::invalid_argument(std::string("no such format in this OpenGL comparison: ") +
                                    gnomon::info(format).name);
    }
}

GLuint make_texture(GLenum format, int width, int height, int samples) {
    GLuint texture = 0;
    if (samples > 1) {
        glCreateTextures(GL_TEXTURE_2D_MULTISAMPLE, 1, &texture);
        glTextureStorage2DMultisample(texture, samples, format, width, height, GL_TRUE);
        return texture;
    }
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, format, width, height);
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(texture, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    return texture;
}

void open_masks() {
    glDisable(GL_SCISSOR_TEST);
    glDepthMask(GL_TRUE);
    glStencilMask(0xff);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

} // namespace

Framebuffer::Framebuffer(const Surface& surface) : surface_(surface) {
    glCreateFramebuffers(1, &framebuffer_);
    if (surface.depth) {
        const bool stencil = surface.stencil && *surface.depth != Format::D16;
        depth_ = make_texture(internal_format(*surface.depth, stencil), surface.width, surface.height, surface.samples);
        glNamedFramebufferTexture(framebuffer_, stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT, depth_, 0);
    }
    std::vector<GLenum> buffers;
    for (const Format format : surface.color) {
        const auto attachment = static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + buffers.size());
        color_.push_back(make_texture(internal_format(format, false), surface.width, surface.height, surface.samples));
        glNamedFramebufferTexture(framebuffer_, attachment, color_.back(), 0);
        buffers.push_back(attachment);
    }
    if (buffers.empty())
        glNamedFramebufferDrawBuffer(framebuffer_, GL_NONE);
    else
        glNamedFramebufferDrawBuffers(framebuffer_, static_cast<GLsizei>(buffers.size()), buffers.data());
    if (glCheckNamedFramebufferStatus(framebuffer_, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        throw std::runtime_error("OpenGL cannot render to these formats");
}

Framebuffer::~Framebuffer() {
    glDeleteFramebuffers(1, &framebuffer_);
    glDeleteTextures(1, &depth_);
    glDeleteTextures(static_cast<GLsizei>(color_.size()), color_.data());
}

void Framebuffer::bind() const { glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_); }

void Framebuffer::clear_depth(float depth) const {
    open_masks();
    glClearNamedFramebufferfv(framebuffer_, GL_DEPTH, 0, &depth);
}

void Framebuffer::clear_stencil(std::uint32_t value) const {
    open_masks();
    const auto v = static_cast<GLint>(value);
    glClearNamedFramebufferiv(framebuffer_, GL_STENCIL, 0, &v);
}

void Framebuffer::clear_color(int index, gnomon::vec4 value) const {
    open_masks();
    glClearNamedFramebufferfv(framebuffer_, GL_COLOR, index, &value.x);
}

void Framebuffer::clear_uint(int index, std::uint32_t value) const {
    open_masks();
    const GLuint v[4] = {value, value, value, value};
    glClearNamedFramebufferuiv(framebuffer_, GL_COLOR, index, v);
}

std::vector<std::uint32_t> Framebuffer::depth_keys() const {
    bind();
    std::vector<std::uint32_t> keys(pixels());
    if (surface_.depth == Format::D16) {
        std::vector<std::uint16_t> words(pixels());
        glPixelStorei(GL_PACK_ALIGNMENT, 2);
        glReadPixels(0, 0, surface_.width, surface_.height, GL_DEPTH_COMPONENT, GL_UNSIGNED_SHORT, words.data());
        keys.assign(words.begin(), words.end());
        return keys;
    }
    const bool unorm = surface_.depth == Format::D24;
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    if (unorm && surface_.stencil)
        glReadPixels(0, 0, surface_.width, surface_.height, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, keys.data());
    else
        glReadPixels(0, 0, surface_.width, surface_.height, GL_DEPTH_COMPONENT, unorm ? GL_UNSIGNED_INT : GL_FLOAT,
                     keys.data());
    if (unorm)
        for (std::uint32_t& key : keys) key >>= 8;
    return keys;
}

std::vector<std::uint32_t> Framebuffer::stencil() const {
    bind();
    std::vector<std::uint8_t> bytes(pixels());
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, surface_.width, surface_.height, GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, bytes.data());
    return {bytes.begin(), bytes.end()};
}

std::vector<std::uint32_t> Framebuffer::uints(int index) const {
    bind();
    std::vector<std::uint32_t> values(pixels());
    glReadBuffer(static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + index));
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, surface_.width, surface_.height, GL_RED_INTEGER, GL_UNSIGNED_INT, values.data());
    return values;
}

std::vector<gnomon::vec4> Framebuffer::colors(int index) const {
    bind();
    std::vector<gnomon::vec4> values(pixels());
    glReadBuffer(static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + index));
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glClampColor(GL_CLAMP_READ_COLOR, GL_FALSE);
    glReadPixels(0, 0, surface_.width, surface_.height, GL_RGBA, GL_FLOAT, values.data());
    return values;
}

void Framebuffer::resolve_color(int index, const Framebuffer& single) const {
    const auto attachment = static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + index);
    glNamedFramebufferReadBuffer(framebuffer_, attachment);
    glNamedFramebufferDrawBuffer(single.framebuffer_, attachment);
    open_masks();
    glBlitNamedFramebuffer(framebuffer_, single.framebuffer_, 0, 0, surface_.width, surface_.height, 0, 0,
                           surface_.width, surface_.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void Framebuffer::upload_depth(std::span<const float> values) const {
    glTextureSubImage2D(depth_, 0, 0, 0, surface_.width, surface_.height, GL_DEPTH_COMPONENT, GL_FLOAT, values.data());
}

void Framebuffer::upload_color(int index, std::span<const gnomon::vec4> values) const {
    glTextureSubImage2D(color_[static_cast<size_t>(index)], 0, 0, 0, surface_.width, surface_.height, GL_RGBA, GL_FLOAT,
                        values.data());
}

void Framebuffer::bind_depth_texture(unsigned unit) const { glBindTextureUnit(unit, depth_); }
void Framebuffer::bind_color_texture(int index, unsigned unit) const {
    glBindTextureUnit(unit, color_[static_cast<size_t>(index)]);
}

} // namespace gnomon_gl
