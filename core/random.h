#pragma once
// Random numbers without state: a hash of (pixel, sample, seed), so that no result depends on the order of evaluation.

#include <cstdint>

namespace gnomon {

// A full-avalanche 32-bit mix (the "lowbias32" constants found by Wellons' hash-prospector search).
constexpr std::uint32_t hash(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}
constexpr std::uint32_t hash(std::uint32_t a, std::uint32_t b) { return hash(a ^ (hash(b) + 0x9e3779b9u)); }
constexpr std::uint32_t hash(std::uint32_t a, std::uint32_t b, std::uint32_t c) { return hash(hash(a, b), c); }

// [0, 1) with 24 bits: exact in float.
constexpr float to_unit(std::uint32_t bits) {
    return static_cast<float>(static_cast<std::int32_t>(bits >> 8)) * 0x1p-24f;
}

} // namespace gnomon
