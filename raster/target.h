#pragma once
// Memory that passes render to and programs read from: one format, one or more layers (cube faces, array slices).

#include <array>
#include <cassert>
#include <cstddef>
#include <memory>
#include <vector>

#include "raster/counters.h"
#include "raster/format.h"

namespace gnomon {

class Target {
public:
    // Contents are zero. Throws UsageError for an impossible size. `meter` may be null; otherwise the bytes count there
    // for as long as the target lives.
    Target(Format format, int width, int height, int layers = 1, std::shared_ptr<MemoryMeter> meter = nullptr);
    Target(Target&&) = default;
    Target& operator=(Target&&) = default;

    Format format() const { return format_; }
    int width() const { return width_; }
    int height() const { return height_; }
    int layers() const { return layers_; }
    std::int64_t bytes() const { return static_cast<std::int64_t>(size_); }

    // Whole-target clears; counted as written bytes of the pass.
    void clear(Pass& pass, vec4 value); // colour formats
    void clear_depth(Pass& pass, float depth);
    void clear_uint(Pass& pass, std::uint32_t value); // stencil and integer formats, all channels

    // Texel values as a program sees them: missing channels are 0, alpha 1. Integer formats go through the _uint
    // functions.
    vec4 load(int x, int y, int layer = 0) const;
    void store(int x, int y, int layer, vec4 value, std::uint8_t channel_mask = 15);
    glm::uvec4 load_uint(int x, int y, int layer = 0) const;
    void store_uint(int x, int y, int layer, glm::uvec4 value, std::uint8_t channel_mask = 15);

    // Depth and stencil texels as the integers that tests compare (see depth_key).
    std::uint32_t load_key(int x, int y, int layer = 0) const;
    void store_key(int x, int y, int layer, std::uint32_t key);
    float depth(int x, int y, int layer = 0) const { return depth_from_key(format_, load_key(x, y, layer)); }

    // The stored words of a 32-bit-per-channel format, row by row from the bottom: T is float, vec2, vec4 or
    // std::uint32_t.
    template <class T> T* row(int y, int layer = 0) {
        assert(static_cast<int>(sizeof(T)) == info(format_).bytes);
        return reinterpret_cast<T*>(texel(0, y, layer));
    }
    template <class T> const T* row(int y, int layer = 0) const {
        assert(static_cast<int>(sizeof(T)) == info(format_).bytes);
        return reinterpret_cast<const T*>(texel(0, y, layer));
    }

    std::byte* texel(int x, int y, int layer) { return bytes_.get() + offset(x, y, layer); }
    const std::byte* texel(int x, int y, int layer) const { return bytes_.get() + offset(x, y, layer); }

private:
    size_t offset(int x, int y, int layer) const {
        assert(x >= 0 && x < width_ && y >= 0 && y < height_ && layer >= 0 && layer < layers_);
        const auto line = static_cast<size_t>(layer) * static_cast<size_t>(height_) + static_cast<size_t>(y);
        return (line * static_cast<size_t>(width_) + static_cast<size_t>(x)) * texel_bytes_;
    }
    template <class Fill> void fill_rows(Pass& pass, const Fill& fill_texel);

    struct Release {
        size_t size;
        std::shared_ptr<MemoryMeter> meter;
        void operator()(std::byte* bytes) const;
    };

    Format format_;
    int width_, height_, layers_;
    size_t texel_bytes_;
    size_t size_;
    std::unique_ptr<std::byte[], Release> bytes_;
};

// What a draw writes to. All of one size; any may be absent.
struct Targets {
    Target* depth = nullptr;
    Target* stencil = nullptr;
    std::vector<Target*> color = {};
    int layer = 0;
};

} // namespace gnomon
