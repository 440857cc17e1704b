#pragma once
// Integer atomics for programs: on words of a buffer, and on texels of R32UI (and S32) targets, counted as one word
// read and one written. Programs run on many threads; the end of a pass is the barrier, and within a pass a word that
// is updated here must be touched in no other way.
//
// What a word holds after the pass is independent of the order of the updates for add, min, max, and, or and xor, each
// alone. The old values that they return are not, nor is what exchange and compare-exchange leave: a program that uses
// those answers for the same result itself. Non-negative floats order as their bits do, so that atomic_max of
// glm::floatBitsToUint(f) is their maximum.

#include <atomic>
#include <concepts>
#include <cstdint>

#include "raster/counters.h"
#include "raster/target.h"

namespace gnomon {

// Each returns the word's old value. Sums wrap.
template <std::integral T> T atomic_add(T& word, T value) {
    return std::atomic_ref(word).fetch_add(value, std::memory_order_relaxed);
}
template <std::integral T> T atomic_and(T& word, T value) {
    return std::atomic_ref(word).fetch_and(value, std::memory_order_relaxed);
}
template <std::integral T> T atomic_or(T& word, T value) {
    return std::atomic_ref(word).fetch_or(value, std::memory_order_relaxed);
}
template <std::integral T> T atomic_xor(T& word, T value) {
    return std::atomic_ref(word).fetch_xor(value, std::memory_order_relaxed);
}
template <std::integral T> T atomic_exchange(T& word, T value) {
    return std::atomic_ref(word).exchange(value, std::memory_order_relaxed);
}
// Stores `value` where the word holds `expected`; the old value says whether it did.
template <std::integral T> T atomic_compare_exchange(T& word, T expected, T value) {
    std::atomic_ref(word).compare_exchange_strong(expected, value, std::memory_order_relaxed);
    return expected;
}
template <std::integral T> T atomic_min(T& word, T value) {
    std::atomic_ref at(word);
    T old = at.load(std::memory_order_relaxed);
    while (value < old && !at.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
    }
    return old;
}
template <std::integral T> T atomic_max(T& word, T value) {
    std::atomic_ref at(word);
    T old = at.load(std::memory_order_relaxed);
    while (value > old && !at.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
    }
    return old;
}

// One texel of an integer target, as an image that programs update.
struct ImageTexel {
    int x, y;
    int layer = 0, level = 0;
};

namespace detail {
// update(word) -> old value; a texel that does not exist is left alone, costs nothing and reads as 0.
template <class Update>
std::uint32_t update_texel(Target& image, const ImageTexel& at, PassCounters& counters, const Update& update) {
    assert(image.format() == Format::R32UI || image.format() == Format::S32);
    if (at.level < 0 || at.level >= image.levels() || at.layer < 0 || at.layer >= image.layers() || at.x < 0 ||
        at.y < 0 || at.x >= image.width(at.level) || at.y >= image.height(at.level))
        return 0;
    ++counters.texels_fetched;
    counters.bytes_read += 4;
    counters.bytes_written += 4;
    return update(image.row<std::uint32_t>(at.y, at.layer, at.level)[at.x]);
}
} // namespace detail

inline std::uint32_t atomic_add(Target& image, ImageTexel at, std::uint32_t value, PassCounters& counters) {
    return detail::update_texel(image, at, counters, [=](std::uint32_t& word) { return atomic_add(word, value); });
}
inline std::uint32_t atomic_min(Target& image, ImageTexel at, std::uint32_t value, PassCounters& counters) {
    return detail::update_texel(image, at, counters, [=](std::uint32_t& word) { return atomic_min(word, value); });
}
inline std::uint32_t atomic_max(Target& image, ImageTexel at, std::uint32_t value, PassCounters& counters) {
    return detail::update_texel(image, at, counters, [=](std::uint32_t& word) { return atomic_max(word, value); });
}
inline std::uint32_t atomic_and(Target& image, ImageTexel at, std::uint32_t value, PassCounters& counters) {
    return detail::update_texel(image, at, counters, [=](std::uint32_t& word) { return atomic_and(word, value); });
}
inline std::uint32_t atomic_or(Target& image, ImageTexel at, std::uint32_t value, PassCounters& counters) {
    return detail::update_texel(image, at, counters, [=](std::uint32_t& word) { return atomic_or(word, value); });
}
inline std::uint32_t atomic_xor(Target& image, ImageTexel at, std::uint32_t value, PassCounters& counters) {
    return detail::update_texel(image, at, counters, [=](std::uint32_t& word) { return atomic_xor(word, value); });
}
inline std::uint32_t atomic_exchange(Target& image, ImageTexel at, std::uint32_t value, PassCounters& counters) {
    return detail::update_texel(image, at, counters, [=](std::uint32_t& word) { return atomic_exchange(word, value); });
}
inline std::uint32_t atomic_compare_exchange(Target& image, ImageTexel at, std::uint32_t expected, std::uint32_t value,
                                             PassCounters& counters) {
    return detail::update_texel(image, at, counters,
                                [=](std::uint32_t& word) { return atomic_compare_exchange(word, expected, value); });
}

} // namespace gnomon
