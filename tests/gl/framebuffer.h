#pragma once
// Render targets in OpenGL that match raster/target.h: the same formats, the same clears, and texels read back as the
// same integers. Row 0 is the lowest.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "raster/format.h"

namespace gnomon_gl {

struct Surface {
    int width = 0, height = 0;
    std::optional<gnomon::Format> depth = gnomon::Format::D24; // D16, D24 or D32F
    bool stencil = true;                                       // with D24 and D32F only
    std::vector<gnomon::Format> color = {};
    int samples = 1; // above 1 nothing can be read back or uploaded but through programs and resolve_color()
};

class Framebuffer {
public:
    explicit Framebuffer(const Surface& surface);
    ~Framebuffer();
    Framebuffer(const Framebuffer&) = delete;
    Framebuffer& operator=(const Framebuffer&) = delete;

    const Surface& surface() const { return surface_; }
    void bind() const;

    // Each leaves the masks and the scissor of the context open.
    void clear_depth(float depth) const;
    void clear_stencil(std::uint32_t value) const;
    void clear_color(int index, gnomon::vec4 value) const;
    void clear_uint(int index, std::uint32_t value) const;

    std::vector<std::uint32_t> depth_keys() const; // as gnomon::depth_key
    std::vector<std::uint32_t> stencil() const;
    std::vector<std::uint32_t> uints(int index) const; // first channel
    std::vector<gnomon::vec4> colors(int index) const; // normalised formats as k/(2^bits − 1)

    // A colour target's mean over the samples, into the same of another framebuffer.
    void resolve_color(int index, const Framebuffer& single) const;

    // Fills a target from memory, and lends it to programs as the texture of a unit.
    void upload_depth(std::span<const float> values) const;
    void upload_color(int index, std::span<const gnomon::vec4> values) const;
    void bind_depth_texture(unsigned unit) const;
    void bind_color_texture(int index, unsigned unit) const;

private:
    size_t pixels() const { return static_cast<size_t>(surface_.width) * static_cast<size_t>(surface_.height); }

    Surface surface_;
    std::uint32_t framebuffer_ = 0, depth_ = 0;
    std::vector<std::uint32_t> color_;
};

} // namespace gnomon_gl
