#include <catch2/catch.hpp>

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/random.h"
#include "raytrace/sample_bits.h"

using namespace gnomon;

namespace {

enum class Kind { None, All, Mixed };

// Appends `count` answers in a shuffled order, to the bits and to the plain list.
void append(SampleBits& bits, std::vector<bool>& plain, std::uint32_t count, Kind kind) {
    const auto first = static_cast<std::uint32_t>(plain.size());
    for (std::uint32_t i = 0; i < count; ++i)
        plain.push_back(kind == Kind::All || (kind == Kind::Mixed && hash(first + i) % 3 == 0));
    std::vector<std::uint32_t> index(count);
    std::iota(index.begin(), index.end(), first);
    std::sort(index.begin(), index.end(), [](std::uint32_t a, std::uint32_t b) { return hash(a) < hash(b); });
    std::vector<std::uint16_t> seen(seen_words(count));
    for (std::uint32_t k = 0; k < count; ++k)
        if (plain[index[k]]) seen[k / 16] = static_cast<std::uint16_t>(seen[k / 16] | 1u << k % 16);
    bits.append(index, seen);
}

void check_same(const SampleBits& bits, const std::vector<bool>& plain) {
    REQUIRE(bits.samples() == plain.size());
    std::uint32_t seen = 0;
    for (std::uint32_t i = 0; i < plain.size(); ++i) {
        CHECK(bits.seen_of(i) == seen);
        CHECK(bits[i] == plain[i]);
        seen += plain[i];
    }
    CHECK(bits.seen() == seen);
}

} // namespace

TEST_CASE("sample bits keep every answer in its place", "[raytrace]") {
    for (const Kind first : {Kind::None, Kind::All, Kind::Mixed})
        for (const Kind second : {Kind::None, Kind::All, Kind::Mixed})
            for (const std::uint32_t count : {1u, 15u, 63u, 64u, 65u, 300u}) {
                SampleBits bits;
                std::vector<bool> plain;
                append(bits, plain, count, first);
                check_same(bits, plain);
                append(bits, plain, 130, second);
                check_same(bits, plain);

                std::vector<unsigned char> bytes;
                bits.write(bytes);
                std::span<const unsigned char> rest(bytes);
                SampleBits read;
                REQUIRE(read.read(rest));
                CHECK(rest.empty());
                check_same(read, plain);
                for (size_t cut = 0; cut < bytes.size(); ++cut) {
                    std::span<const unsigned char> some(bytes.data(), cut);
                    CHECK_FALSE(SampleBits().read(some));
                }

                for (const std::uint32_t keep : {count + 200, count + 1, count, count / 2, 0u}) {
                    read.truncate(keep);
                    std::vector<bool> shorter = plain;
                    shorter.resize(std::min<size_t>(plain.size(), keep));
                    check_same(read, shorter);
                }
                append(read, plain = {}, 70, Kind::Mixed);
                check_same(read, plain);
            }
}
