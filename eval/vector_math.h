#pragma once
// Roots and powers of floats as plain arithmetic, so that loops over them become vector code; the library's functions
// do not. Relative error below 1e-6, for finite arguments; the same bits whatever the vector width.

#include <bit>
#include <cstdint>

namespace gnomon {

// x ≥ 0; below 1e-30 the root of 1e-30. Two steps of Halley's iteration, each of which triples the digits, from a guess
// that is good to 4 %.
inline float vector_cbrt(float value) {
    const float x = value > 1e-30f ? value : 1e-30f;
    float root = std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) / 3u + 0x2a514067u);
    for (int step = 0; step < 2; ++step) {
        const float cube = root * root * root;
        root *= (cube + 2.0f * x) / (2.0f * cube + x);
    }
    return root;
}

// x > 0 and normal. The mantissa in [√½, √2) by the series of the inverse hyperbolic tangent.
inline float vector_log2(float x) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(x);
    const std::int32_t exponent = static_cast<std::int32_t>(bits - 0x3f3504f3u) >> 23; // 0x3f3504f3 is √½
    const float mantissa = std::bit_cast<float>(bits - (static_cast<std::uint32_t>(exponent) << 23));
    const float s = (mantissa - 1.0f) / (mantissa + 1.0f), s2 = s * s;
    const float series = 1.0f + s2 * (1.0f / 3.0f + s2 * (1.0f / 5.0f + s2 * (1.0f / 7.0f + s2 * (1.0f / 9.0f))));
    return static_cast<float>(exponent) + 2.8853900817779268f * s * series; // 2 / ln 2
}

// |x| < 126. The fraction by the exponential series.
inline float vector_exp2(float x) {
    const std::int32_t whole = static_cast<std::int32_t>(x + 127.5f) - 127; // to nearest: the sum is above 0
    const float t = (x - static_cast<float>(whole)) * 0.69314718055994531f;
    const float series =
        1.0f +
        t * (1.0f + t * (1.0f / 2.0f + t * (1.0f / 6.0f + t * (1.0f / 24.0f + t * (1.0f / 120.0f + t / 720.0f)))));
    return series * std::bit_cast<float>(static_cast<std::uint32_t>(whole + 127) << 23);
}

// x^exponent for x ≥ 0, exponents in [0, 1] or x of at least 1e-10, and results below 2^126; 0 for x below 1e-37.
inline float vector_pow(float x, float exponent) {
    constexpr float smallest = 1e-37f;
    const float power = vector_exp2(exponent * vector_log2(x > smallest ? x : smallest));
    return x < smallest ? 0.0f : power;
}

} // namespace gnomon
