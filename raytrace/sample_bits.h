#pragma once
// What the rays of one receiver answered, sample by sample in the order of the pattern's sequence. Visibility, error
// bars and radiance all follow from it, so it is all that a run has to keep to be resumed, or continued with more
// samples.

#include <cstdint>
#include <span>
#include <vector>

#include "raytrace/occlusion.h"

namespace gnomon {

class SampleBits {
public:
    std::uint32_t samples() const { return samples_; }
    std::uint32_t seen() const { return seen_; }
    bool all_alike() const { return seen_ == 0 || seen_ == samples_; }

    // Whether sample i was seen; i < samples().
    bool operator[](std::uint32_t i) const {
        if (words_.empty()) return seen_ != 0;
        return (words_[i / 64] >> i % 64 & 1u) != 0;
    }
    // Of the first `count` samples.
    std::uint32_t seen_of(std::uint32_t count) const;

    // The answers to the samples from samples() to samples() + index.size() − 1, in another order: bit k of `seen`
    // answers sample index[k].
    void append(std::span<const std::uint32_t> index, std::span<const std::uint16_t> seen);

    // Forgets all but the first `count`, which may be more than there are.
    void truncate(std::uint32_t count);

    // As bytes, appended to `out`; and back, from the front of `bytes`, which is shortened. False where they are none.
    void write(std::vector<unsigned char>& out) const;
    bool read(std::span<const unsigned char>& bytes);

private:
    void expand(std::uint32_t samples);

    std::uint32_t samples_ = 0, seen_ = 0;
    std::vector<std::uint64_t> words_; // empty while all samples are alike
};

} // namespace gnomon
