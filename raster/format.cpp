#include "raster/format.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace gnomon {

const FormatInfo& info(Format format) {
    using Kind = FormatInfo::Kind;
    static constexpr std::array<FormatInfo, 19> table = {{
        {"D16", Kind::Depth, 1, 2},     {"D24", Kind::Depth, 1, 4},      {"D32F", Kind::Depth, 1, 4},
        {"S8", Kind::Stencil, 1, 1},    {"S32", Kind::Stencil, 1, 4},    {"R8", Kind::Unorm, 1, 1},
        {"RG8", Kind::Unorm, 2, 2},     {"RGBA8", Kind::Unorm, 4, 4},    {"R16", Kind::Unorm, 1, 2},
        {"RG16", Kind::Unorm, 2, 4},    {"RGBA16", Kind::Unorm, 4, 8},   {"R16F", Kind::Half, 1, 2},
        {"RG16F", Kind::Half, 2, 4},    {"RGBA16F", Kind::Half, 4, 8},   {"R32F", Kind::Float, 1, 4},
        {"RG32F", Kind::Float, 2, 8},   {"RGBA32F", Kind::Float, 4, 16}, {"R32UI", Kind::Uint, 1, 4},
        {"RGBA16UI", Kind::Uint, 4, 8},
    }};
    return table[static_cast<size_t>(format)];
}

std::uint16_t half_from_float(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const auto sign = static_cast<std::uint16_t>((bits >> 16) & 0x8000u);
    const std::uint32_t magnitude = bits & 0x7fffffffu;
    if (magnitude > 0x7f800000u) return static_cast<std::uint16_t>(sign | 0x7e00u);  // NaN
    if (magnitude >= 0x477ff000u) return static_cast<std::uint16_t>(sign | 0x7c00u); // rounds to 65536 or more
    std::uint32_t rounded;
    if (magnitude >= 0x38800000u) { // normal half: re-bias the exponent, then round away 13 bits
        const std::uint32_t rebased = magnitude - 0x38000000u;
        rounded = (rebased + 0xfffu + ((rebased >> 13) & 1u)) >> 13;
    } else { // subnormal half: the FPU rounds at bit 2⁻²⁴ when 0.5 is added
        const float shifted = std::bit_cast<float>(magnitude) + 0.5f;
        rounded = std::bit_cast<std::uint32_t>(shifted) - std::bit_cast<std::uint32_t>(0.5f);
    }
    return static_cast<std::uint16_t>(sign | rounded);
}

float float_from_half(std::uint16_t half) {
    const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000u) << 16;
    const std::uint32_t exponent = (half >> 10) & 0x1fu, mantissa = half & 0x3ffu;
    if (exponent == 0) {
        const float subnormal = static_cast<float>(mantissa) * 0x1p-24f;
        return std::bit_cast<float>(std::bit_cast<std::uint32_t>(subnormal) | sign);
    }
    const std::uint32_t wide = exponent == 31 ? 255u : exponent + 112u;
    return std::bit_cast<float>(sign | wide << 23 | mantissa << 13);
}

std::uint32_t unorm_from_float(float value, int bits) {
    const double scale = static_cast<double>((std::uint32_t{1} << bits) - 1);
    const double clamped = value > 0.0f ? std::min(1.0, static_cast<double>(value)) : 0.0;
    return static_cast<std::uint32_t>(std::floor(clamped * scale + 0.5));
}

std::uint32_t depth_key(Format format, double z) {
    z = z > 0.0 ? std::min(z, 1.0) : 0.0;
    switch (format) {
    case Format::D16:
        return static_cast<std::uint32_t>(z * 65535.0 + 0.5);
    case Format::D24:
        return static_cast<std::uint32_t>(z * 16777215.0 + 0.5);
    default:
        return std::bit_cast<std::uint32_t>(static_cast<float>(z));
    }
}

float depth_from_key(Format format, std::uint32_t key) {
    switch (format) {
    case Format::D16:
        return static_cast<float>(key / 65535.0);
    case Format::D24:
        return static_cast<float>(key / 16777215.0);
    default:
        return std::bit_cast<float>(key);
    }
}

double depth_resolution(Format format, double largest_depth) {
    switch (format) {
    case Format::D16:
        return 0x1p-16;
    case Format::D24:
        return 0x1p-24;
    default:
        // The exponent's bits of the double, which holds every float as a normal number.
        if (!(largest_depth > 0)) return 0x1p-149;
        constexpr std::uint64_t exponent = 0x7ffull << 52;
        return std::bit_cast<double>((std::bit_cast<std::uint64_t>(largest_depth) & exponent) - (23ull << 52));
    }
}

} // namespace gnomon
