#pragma once
// Texel formats and their exact conversions: what a render target stores is what a GPU's would store.

#include <cstdint>

#include "core/math.h"

namespace gnomon {

enum class Format : std::uint8_t {
    D16,
    D24,
    D32F, // depth: unsigned normalised 16 and 24 bits (24 in a 32-bit word), float
    S8,
    S32, // stencil: 8 bits as in the API; 32 bits where a reference must not wrap
    R8,
    RG8,
    RGBA8, // unsigned normalised
    R16,
    RG16,
    RGBA16,
    R16F,
    RG16F,
    RGBA16F, // half
    R32F,
    RG32F,
    RGBA32F,
    R32UI,
    RGBA16UI, // unsigned integer
};

struct FormatInfo {
    enum class Kind : std::uint8_t { Depth, Stencil, Unorm, Half, Float, Uint };
    const char* name;
    Kind kind;
    int channels;
    int bytes; // per texel
};
const FormatInfo& info(Format format);

// IEEE binary16, rounding to nearest even; overflow goes to infinity, NaN stays NaN.
std::uint16_t half_from_float(float value);
float float_from_half(std::uint16_t half);

// Round to nearest of value·(2^bits − 1), clamped to [0, 1]; NaN becomes 0.
std::uint32_t unorm_from_float(float value, int bits);

// Depth as the unsigned integer that orders as the format does: D16 and D24 are floor(z·(2^n − 1) + 0.5), D32F the bits
// of the float (z is in [0, 1], so bits order as values do). `z` is clamped to [0, 1].
std::uint32_t depth_key(Format format, double z);
float depth_from_key(Format format, std::uint32_t key);

// The smallest resolvable depth difference r of polygon offset: 2⁻ⁿ for n-bit formats; for D32F 2^(e−23), e the
// exponent of the triangle's largest depth. [OpenGL 4.6, 14.6.5; Macedo 2018, 0.5]
double depth_resolution(Format format, double largest_depth);

} // namespace gnomon
