#include "raytrace/sample_bits.h"

#include <bit>
#include <cassert>
#include <cstring>

namespace gnomon {
namespace {

constexpr size_t words_for(std::uint32_t samples) { return (size_t{samples} + 63) / 64; }

template <class T> bool take(std::span<const unsigned char>& bytes, T* values, size_t count) {
    const size_t size = count * sizeof(T);
    if (bytes.size() < size) return false;
    if (size > 0) std::memcpy(values, bytes.data(), size);
    bytes = bytes.subspan(size);
    return true;
}

template <class T> void put(std::vector<unsigned char>& out, const T* values, size_t count) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(values);
    out.insert(out.end(), bytes, bytes + count * sizeof(T));
}

} // namespace

std::uint32_t SampleBits::seen_of(std::uint32_t count) const {
    assert(count <= samples_);
    if (count == samples_) return seen_;
    if (words_.empty()) return seen_ == 0 ? 0 : count;
    std::uint32_t seen = 0;
    for (std::uint32_t i = 0; i < count / 64; ++i) seen += static_cast<std::uint32_t>(std::popcount(words_[i]));
    if (count % 64 != 0) {
        const std::uint64_t first = (std::uint64_t{1} << count % 64) - 1;
        seen += static_cast<std::uint32_t>(std::popcount(words_[count / 64] & first));
    }
    return seen;
}

// Room for so many samples, the present ones written out.
void SampleBits::expand(std::uint32_t samples) {
    const bool ones = words_.empty() && seen_ != 0;
    words_.resize(words_for(samples));
    if (!ones) return;
    for (std::uint32_t i = 0; i < samples_ / 64; ++i) words_[i] = ~std::uint64_t{0};
    if (samples_ % 64 != 0) words_[samples_ / 64] = (std::uint64_t{1} << samples_ % 64) - 1;
}

void SampleBits::append(std::span<const std::uint32_t> index, std::span<const std::uint16_t> seen) {
    assert(seen.size() >= seen_words(index.size()));
    std::uint32_t seen_now = 0;
    for (size_t w = 0; w < seen_words(index.size()); ++w)
        seen_now += static_cast<std::uint32_t>(std::popcount(seen[w]));
    const auto count = static_cast<std::uint32_t>(index.size());
    const std::uint32_t samples = samples_ + count, seen_then = seen_ + seen_now;
    if (seen_then != 0 && seen_then != samples) {
        expand(samples);
        for (size_t w = 0; w < seen_words(count); ++w)
            for (unsigned rest = seen[w]; rest; rest &= rest - 1) {
                const std::uint32_t i = index[16 * w + static_cast<size_t>(std::countr_zero(rest))];
                assert(i >= samples_ && i < samples);
                words_[i / 64] |= std::uint64_t{1} << i % 64;
            }
    }
    samples_ = samples;
    seen_ = seen_then;
}

void SampleBits::truncate(std::uint32_t count) {
    if (count >= samples_) return;
    seen_ = seen_of(count);
    samples_ = count;
    words_.resize(all_alike() ? 0 : words_for(count));
    if (!words_.empty() && count % 64 != 0) words_.back() &= (std::uint64_t{1} << count % 64) - 1;
}

void SampleBits::write(std::vector<unsigned char>& out) const {
    const std::uint32_t head[] = {samples_, seen_};
    put(out, head, 2);
    put(out, words_.data(), words_.size());
}

bool SampleBits::read(std::span<const unsigned char>& bytes) {
    std::uint32_t head[2];
    if (!take(bytes, head, 2) || head[1] > head[0]) return false;
    samples_ = head[0], seen_ = head[1];
    words_.assign(all_alike() ? 0 : words_for(samples_), 0);
    return bytes.size() >= words_.size() * sizeof(std::uint64_t) && take(bytes, words_.data(), words_.size());
}

} // namespace gnomon
