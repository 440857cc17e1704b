#pragma once
// What the tests of image passes share: a pass to count in, random targets, and thread counts that must not matter.

#include <catch2/catch.hpp>
#include <cstring>
#include <functional>

#include "core/image.h"
#include "core/parallel.h"
#include "core/random.h"
#include "raster/target.h"

namespace gnomon_tests {

struct TestPass {
    gnomon::PassLog log;
    gnomon::Pass pass{log, "test"};
};

// In [0, 1), from a hash of the place and the seed.
inline float random_unit(int x, int y, int channel, std::uint32_t seed) {
    return gnomon::to_unit(
        gnomon::hash(static_cast<std::uint32_t>(x * 4 + channel), static_cast<std::uint32_t>(y), seed));
}

inline gnomon::Target random_target(gnomon::Format format, int width, int height, std::uint32_t seed, int layers = 1) {
    gnomon::Target target(format, width, height, layers);
    for (int layer = 0; layer < layers; ++layer)
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                gnomon::vec4 value;
                for (int c = 0; c < 4; ++c) value[c] = random_unit(x, y + layer * height, c, seed);
                target.store(x, y, layer, value);
            }
    return target;
}

// One at the given density, else zero.
inline gnomon::Image<std::uint8_t> random_mask(int width, int height, float density, std::uint32_t seed) {
    gnomon::Image<std::uint8_t> mask(width, height, std::uint8_t{0});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) mask(x, y) = random_unit(x, y, 0, seed) < density;
    return mask;
}

inline bool same_bits(const gnomon::Target& a, const gnomon::Target& b) {
    if (a.bytes() != b.bytes()) return false;
    for (int layer = 0; layer < a.layers(); ++layer)
        for (int y = 0; y < a.height(); ++y) {
            const auto row_bytes = static_cast<size_t>(a.width() * gnomon::info(a.format()).bytes);
            if (std::memcmp(a.texel(0, y, layer), b.texel(0, y, layer), row_bytes) != 0) return false;
        }
    return true;
}

template <class Range> bool same_bits(const Range& a, const Range& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(*a.data())) == 0;
}

// make() with 1, 2 and 7 threads; same(a, b) must hold for all of them.
template <class Make, class Same> void check_threads(const Make& make, const Same& same) {
    using Result = decltype(make());
    std::vector<Result> results;
    for (const int threads : {1, 2, 7}) gnomon::with_threads(threads, [&] { results.push_back(make()); });
    CHECK(same(results[0], results[1]));
    CHECK(same(results[0], results[2]));
}

} // namespace gnomon_tests
