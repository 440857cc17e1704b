#include "raster/target.h"

#include <bit>
#include <cstring>

#include <emmintrin.h>
#include <fmt/format.h>

#include "core/error.h"
#include "core/image.h"
#include "core/large_memory.h"
#include "core/parallel.h"

namespace gnomon {
namespace {

using Kind = FormatInfo::Kind;
constexpr size_t clear_grain = size_t{2} << 20; // bytes

template <class T> T read(const std::byte* bytes, int i) {
    T value;
    std::memcpy(&value, bytes + static_cast<size_t>(i) * sizeof(T), sizeof(T));
    return value;
}

template <class T> void write(std::byte* bytes, int i, T value) {
    std::memcpy(bytes + static_cast<size_t>(i) * sizeof(T), &value, sizeof(T));
}

// c/255 for every byte.
constexpr std::array<float, 256> unorm8 = [] {
    std::array<float, 256> table{};
    for (size_t c = 0; c < 256; ++c) table[c] = static_cast<float>(c) / 255.0f;
    return table;
}();

} // namespace

void Target::Release::operator()(std::byte* bytes) const {
    free_large(bytes, size);
    if (meter) meter->release(static_cast<std::int64_t>(size));
}

int full_level_count(int width, int height) {
    return static_cast<int>(std::bit_width(static_cast<unsigned>(std::max({width, height, 1}))));
}

Target::Target(Format format, int width, int height, int layers, std::shared_ptr<MemoryMeter> meter, int levels)
    : format_(format), width_(width), height_(height), layers_(layers), levels_(levels),
      texel_bytes_(static_cast<size_t>(info(format).bytes)) {
    check_image_size(width, height, "render target");
    if (layers < 1) throw UsageError(fmt::format("a render target of {} layers is not possible", layers));
    if (levels < 1 || levels > full_level_count(width, height))
        throw UsageError(fmt::format("a render target of {}x{} has between 1 and {} mip levels, not {}", width, height,
                                     full_level_count(width, height), levels));
    size_ = level_begin(levels);
    auto* bytes = static_cast<std::byte*>(allocate_large(size_));
    if (meter) meter->allocate(static_cast<std::int64_t>(size_));
    bytes_ = {bytes, Release{size_, std::move(meter)}};
    parallel_for(size_, clear_grain, [&](size_t begin, size_t end) { std::memset(bytes + begin, 0, end - begin); });
}

size_t Target::level_begin(int level) const {
    size_t texels = 0;
    for (int l = 0; l < level; ++l) texels += static_cast<size_t>(width(l)) * static_cast<size_t>(height(l));
    return texels * static_cast<size_t>(layers_) * texel_bytes_;
}

namespace {

// Copies of one texel. Sizes are powers of two up to 16, so that 64 bytes hold whole texels.
class Filler {
public:
    Filler(size_t texel_bytes, const std::array<std::byte, 16>& texel, bool stream) : stream_(stream) {
        for (size_t i = 0; i < pattern_.size(); i += texel_bytes) std::memcpy(&pattern_[i], texel.data(), texel_bytes);
    }
    void fill(std::byte* at, size_t bytes) const {
        if (stream_ && reinterpret_cast<std::uintptr_t>(at) % 64 == 0) {
            for (; bytes >= pattern_.size(); bytes -= pattern_.size(), at += pattern_.size())
                for (size_t i = 0; i < pattern_.size(); i += 16)
                    _mm_stream_si128(reinterpret_cast<__m128i*>(at + i),
                                     _mm_load_si128(reinterpret_cast<const __m128i*>(&pattern_[i])));
        }
        for (; bytes >= pattern_.size(); bytes -= pattern_.size(), at += pattern_.size())
            std::memcpy(at, pattern_.data(), pattern_.size());
        std::memcpy(at, pattern_.data(), bytes);
    }

private:
    alignas(64) std::array<std::byte, 64> pattern_;
    bool stream_;
};

} // namespace

void Target::fill_all(Pass& pass, const std::array<std::byte, 16>& value) {
    const Filler filler(texel_bytes_, value, is_streamed(*this));
    parallel_for(size_, size_t{1} << 20, [&](size_t begin, size_t end) {
        filler.fill(bytes_.get() + begin, end - begin);
        _mm_sfence();
    });
    pass.counters().bytes_written += bytes();
}

void Target::fill(int x, int y, int columns, int rows, int layer, int level, const std::array<std::byte, 16>& value) {
    const Filler filler(texel_bytes_, value, is_streamed(*this));
    for (int j = y; j < y + rows; ++j)
        filler.fill(texel(x, j, layer, level), static_cast<size_t>(columns) * texel_bytes_);
}

namespace {

void store_texel(Format format, std::byte* at, vec4 value, std::uint8_t mask) {
    const FormatInfo& f = info(format);
    for (int c = 0; c < f.channels; ++c) {
        if (!(mask >> c & 1)) continue;
        const float v = value[c];
        switch (f.kind) {
        case Kind::Unorm:
            if (f.bytes == f.channels)
                write(at, c, static_cast<std::uint8_t>(unorm_from_float(v, 8)));
            else
                write(at, c, static_cast<std::uint16_t>(unorm_from_float(v, 16)));
            break;
        case Kind::Half:
            write(at, c, half_from_float(v));
            break;
        case Kind::Float:
            write(at, c, v);
            break;
        default:
            assert(false && "integer, depth and stencil formats have their own stores");
        }
    }
}

void store_texel_uint(Format format, std::byte* at, glm::uvec4 value, std::uint8_t mask) {
    const FormatInfo& f = info(format);
    for (int c = 0; c < f.channels; ++c) {
        if (!(mask >> c & 1)) continue;
        switch (format) {
        case Format::R32UI:
        case Format::S32:
            write(at, c, value[c]);
            break;
        case Format::RGBA16UI:
            write(at, c, static_cast<std::uint16_t>(value[c]));
            break;
        case Format::S8:
            write(at, c, static_cast<std::uint8_t>(value[c]));
            break;
        default:
            assert(false && "not an integer format");
        }
    }
}

} // namespace

std::array<std::byte, 16> Target::cleared(vec4 value) const {
    std::array<std::byte, 16> bytes{};
    if (info(format_).kind == Kind::Uint)
        store_texel_uint(format_, bytes.data(), glm::floatBitsToUint(value), 15);
    else
        store_texel(format_, bytes.data(), value, 15);
    return bytes;
}

std::array<std::byte, 16> Target::cleared_depth(float depth) const {
    std::array<std::byte, 16> bytes{};
    const std::uint32_t key = depth_key(format_, static_cast<double>(depth));
    if (format_ == Format::D16)
        write(bytes.data(), 0, static_cast<std::uint16_t>(key));
    else
        write(bytes.data(), 0, key);
    return bytes;
}

std::array<std::byte, 16> Target::cleared_uint(std::uint32_t value) const {
    std::array<std::byte, 16> bytes{};
    store_texel_uint(format_, bytes.data(), glm::uvec4(value), 15);
    return bytes;
}

void Target::clear(Pass& pass, vec4 value) { fill_all(pass, cleared(value)); }
void Target::clear_depth(Pass& pass, float depth) { fill_all(pass, cleared_depth(depth)); }
void Target::clear_uint(Pass& pass, std::uint32_t value) { fill_all(pass, cleared_uint(value)); }

vec4 Target::convert(const std::byte* at) const {
    const FormatInfo& f = info(format_);
    vec4 value(0.0f, 0.0f, 0.0f, 1.0f);
    for (int c = 0; c < f.channels; ++c) {
        switch (f.kind) {
        case Kind::Unorm:
            value[c] = f.bytes == f.channels ? unorm8[read<std::uint8_t>(at, c)]
                                             : static_cast<float>(read<std::uint16_t>(at, c)) / 65535.0f;
            break;
        case Kind::Half:
            value[c] = float_from_half(read<std::uint16_t>(at, c));
            break;
        case Kind::Float:
            value[c] = read<float>(at, c);
            break;
        case Kind::Depth:
            value[c] = depth_from_key(format_, f.bytes == 2 ? read<std::uint16_t>(at, 0) : read<std::uint32_t>(at, 0));
            break;
        default:
            assert(false && "integer and stencil formats go through load_uint");
        }
    }
    return value;
}

void Target::store(int x, int y, int layer, vec4 value, std::uint8_t mask, int level) {
    store_texel(format_, texel(x, y, layer, level), value, mask);
}

glm::uvec4 Target::load_uint(int x, int y, int layer, int level) const {
    const std::byte* at = texel(x, y, layer, level);
    glm::uvec4 value(0u, 0u, 0u, 1u);
    for (int c = 0; c < info(format_).channels; ++c) {
        switch (format_) {
        case Format::R32UI:
        case Format::S32:
            value[c] = read<std::uint32_t>(at, c);
            break;
        case Format::RGBA16UI:
            value[c] = read<std::uint16_t>(at, c);
            break;
        case Format::S8:
            value[c] = read<std::uint8_t>(at, c);
            break;
        default:
            assert(false && "not an integer format");
        }
    }
    return value;
}

void Target::store_uint(int x, int y, int layer, glm::uvec4 value, std::uint8_t mask, int level) {
    store_texel_uint(format_, texel(x, y, layer, level), value, mask);
}

void Target::store_key(int x, int y, int layer, std::uint32_t key, int level) {
    std::byte* at = texel(x, y, layer, level);
    switch (texel_bytes_) {
    case 1:
        write(at, 0, static_cast<std::uint8_t>(key));
        break;
    case 2:
        write(at, 0, static_cast<std::uint16_t>(key));
        break;
    default:
        write(at, 0, key);
    }
}

} // namespace gnomon
