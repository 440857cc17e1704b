#pragma once
// Memory that passes render to and programs read from: one format, one or more layers (array slices; a cube is six
// layers in OpenGL's order of faces +X −X +Y −Y +Z −Z) and one or more mip levels. Level l is max(1, width >> l) by
// max(1, height >> l) texels. In memory level 0 comes first; within a level, layer after layer, row after row from the
// bottom.

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

#include "raster/counters.h"
#include "raster/format.h"

namespace gnomon {

// Number of mip levels down to 1×1: ⌊log2 max(width, height)⌋ + 1.
int full_level_count(int width, int height);

class Target {
public:
    // Contents are zero. Throws UsageError for an impossible size or number of levels. `meter` may be null; otherwise
    // the bytes count there for as long as the target lives.
    Target(Format format, int width, int height, int layers = 1, std::shared_ptr<MemoryMeter> meter = nullptr,
           int levels = 1);
    Target(Target&&) = default;
    Target& operator=(Target&&) = default;

    Format format() const { return format_; }
    int width() const { return width_; }
    int height() const { return height_; }
    int width(int level) const { return std::max(1, width_ >> level); }
    int height(int level) const { return std::max(1, height_ >> level); }
    int layers() const { return layers_; }
    int levels() const { return levels_; }
    int texel_bytes() const { return static_cast<int>(texel_bytes_); }
    std::int64_t bytes() const { return static_cast<std::int64_t>(size_); }

    // Whole-target clears, all layers and levels; counted as written bytes of the pass.
    void clear(Pass& pass, vec4 value); // colour formats
    void clear_depth(Pass& pass, float depth);
    void clear_uint(Pass& pass, std::uint32_t value); // stencil and integer formats, all channels

    // The bytes of one texel that such a clear writes.
    std::array<std::byte, 16> cleared(vec4 value) const; // integer formats take the bits
    std::array<std::byte, 16> cleared_depth(float depth) const;
    std::array<std::byte, 16> cleared_uint(std::uint32_t value) const;
    // Copies a texel over a rectangle of one layer and level; nothing is counted. Large targets are written past the
    // caches: other threads see it after a store fence.
    void fill(int x, int y, int columns, int rows, int layer, int level, const std::array<std::byte, 16>& texel);

    // Texel values as a program sees them: missing channels are 0, alpha 1. Integer formats go through the _uint
    // functions.
    vec4 load(int x, int y, int layer = 0, int level = 0) const { return load(texel(x, y, layer, level)); }
    vec4 load(const std::byte* at) const { // the texel stored there
        switch (format_) {                 // what needs no conversion stays inline
        case Format::R32F:
        case Format::D32F:
            return {word<float>(at), 0.0f, 0.0f, 1.0f};
        case Format::RG32F:
            return {word<vec2>(at), 0.0f, 1.0f};
        case Format::RGBA32F:
            return word<vec4>(at);
        default:
            return convert(at);
        }
    }
    void store(int x, int y, int layer, vec4 value, std::uint8_t channel_mask = 15, int level = 0);
    glm::uvec4 load_uint(int x, int y, int layer = 0, int level = 0) const;
    void store_uint(int x, int y, int layer, glm::uvec4 value, std::uint8_t channel_mask = 15, int level = 0);

    // Depth and stencil texels as the integers that tests compare (see depth_key).
    std::uint32_t load_key(int x, int y, int layer = 0, int level = 0) const {
        const std::byte* at = texel(x, y, layer, level);
        if (texel_bytes_ == 4) [[likely]]
            return word<std::uint32_t>(at);
        return texel_bytes_ == 2 ? word<std::uint16_t>(at) : word<std::uint8_t>(at);
    }
    void store_key(int x, int y, int layer, std::uint32_t key, int level = 0);
    float depth(int x, int y, int layer = 0, int level = 0) const {
        if (format_ == Format::D32F) [[likely]]
            return word<float>(texel(x, y, layer, level));
        return depth_from_key(format_, load_key(x, y, layer, level));
    }

    // The stored words of a 32-bit-per-channel format, row by row from the bottom: T is float, vec2, vec4 or
    // std::uint32_t.
    template <class T> T* row(int y, int layer = 0, int level = 0) {
        assert(sizeof(T) == texel_bytes_);
        return reinterpret_cast<T*>(texel(0, y, layer, level));
    }
    template <class T> const T* row(int y, int layer = 0, int level = 0) const {
        assert(sizeof(T) == texel_bytes_);
        return reinterpret_cast<const T*>(texel(0, y, layer, level));
    }

    std::byte* texel(int x, int y, int layer, int level = 0) { return bytes_.get() + offset(x, y, layer, level); }
    const std::byte* texel(int x, int y, int layer, int level = 0) const {
        return bytes_.get() + offset(x, y, layer, level);
    }

private:
    size_t offset(int x, int y, int layer, int level) const {
        assert(level >= 0 && level < levels_);
        assert(x >= 0 && x < width(level) && y >= 0 && y < height(level) && layer >= 0 && layer < layers_);
        const auto line = static_cast<size_t>(layer) * static_cast<size_t>(height(level)) + static_cast<size_t>(y);
        const size_t in_level = (line * static_cast<size_t>(width(level)) + static_cast<size_t>(x)) * texel_bytes_;
        return level == 0 ? in_level : in_level + level_begin(level);
    }
    size_t level_begin(int level) const; // bytes
    template <class T> static T word(const std::byte* at) {
        T value;
        std::memcpy(&value, at, sizeof(T));
        return value;
    }
    vec4 convert(const std::byte* texel) const;
    void fill_all(Pass& pass, const std::array<std::byte, 16>& texel);

    struct Release {
        size_t size;
        std::shared_ptr<MemoryMeter> meter;
        void operator()(std::byte* bytes) const;
    };

    Format format_;
    int width_, height_, layers_, levels_;
    size_t texel_bytes_;
    size_t size_;
    std::unique_ptr<std::byte[], Release> bytes_;
};

// Targets of this size are written past the caches, which they would only empty.
inline bool is_streamed(const Target& target) { return target.bytes() >= std::int64_t{6} << 20; }

// What a draw or a full-screen pass writes to: one layer and one level of each. All of one size; any may be absent.
struct Targets {
    Target* depth = nullptr;
    Target* stencil = nullptr;
    std::vector<Target*> color = {};
    int layer = 0;
    int level = 0;
    // 1, 4 or 8. The samples of layer L are the layers L·samples to L·samples + samples − 1 of the targets' memory.
    int samples = 1;
    // Load operations: where given, that layer and level starts as cleared to this, whole, whatever the scissor. Costs
    // less than a clear before the draw, because a tile is written once. [Vulkan 1.3, 8.2
    // "VK_ATTACHMENT_LOAD_OP_CLEAR"]
    std::optional<float> clear_depth = {};
    std::optional<std::uint32_t> clear_stencil = {};
    std::optional<vec4> clear_color = {}; // of all colour targets; integer ones take the bits
};

} // namespace gnomon
