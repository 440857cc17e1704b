#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/random.h"
#include "raytrace/truth_state.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

SampleBits bits_of(std::uint32_t seed) {
    std::vector<std::uint32_t> index(96);
    std::vector<std::uint16_t> seen(6);
    for (std::uint32_t i = 0; i < 96; ++i) index[i] = i;
    for (std::uint32_t i = 0; i < 6; ++i) seen[i] = static_cast<std::uint16_t>(hash(seed, i));
    SampleBits bits;
    bits.append(index, seen);
    return bits;
}

bool same(const SampleBits& a, const SampleBits& b) {
    if (a.samples() != b.samples()) return false;
    for (std::uint32_t i = 0; i < a.samples(); ++i)
        if (a[i] != b[i]) return false;
    return true;
}

const nlohmann::ordered_json identity = {{"scene", "abc"}, {"seed", 3}};

} // namespace

TEST_CASE("a state cut off at any byte keeps every tile before the cut", "[raytrace]") {
    const std::string path = temporary_folder() + "/state";
    std::vector<std::uint64_t> ends;
    {
        TruthState state(path, identity, false, 0);
        for (std::uint32_t tile = 0; tile < 4; ++tile) {
            const std::vector<SampleBits> tile_bits = {bits_of(2 * tile), bits_of(2 * tile + 1)};
            state.store(tile % 2, tile, tile_bits);
            ends.push_back(std::filesystem::file_size(path));
        }
    }
    const std::string whole = read_file(path);
    for (std::uint64_t size = whole.find("}\n") + 2; size <= whole.size(); ++size) {
        write_text_file(path, whole.substr(0, size));
        const auto expected = std::count_if(ends.begin(), ends.end(), [&](std::uint64_t end) { return end <= size; });
        TruthState state(path, identity, true, 0);
        REQUIRE(state.tiles() == static_cast<size_t>(expected));
        for (std::uint32_t tile = 0; tile < 4; ++tile) {
            std::vector<SampleBits> loaded(2);
            const bool known = state.load(tile % 2, tile, loaded);
            REQUIRE(known == (tile < expected));
            if (known) REQUIRE((same(loaded[0], bits_of(2 * tile)) && same(loaded[1], bits_of(2 * tile + 1))));
        }
        // What comes after the cut is written over.
        const std::vector<SampleBits> more = {bits_of(77), bits_of(78)};
        state.store(0, 9, more);
        TruthState again(path, identity, true, 0);
        REQUIRE(again.tiles() == static_cast<size_t>(expected) + 1);
        std::vector<SampleBits> loaded(2);
        REQUIRE(again.load(0, 9, loaded));
        REQUIRE(same(loaded[1], more[1]));
    }
}

TEST_CASE("a damaged record ends what a state knows", "[raytrace]") {
    const std::string path = temporary_folder() + "/state";
    {
        TruthState state(path, identity, false, 0);
        for (std::uint32_t tile = 0; tile < 3; ++tile) state.store(0, tile, std::vector<SampleBits>{bits_of(tile)});
    }
    const std::string whole = read_file(path);
    const size_t records = whole.find("}\n") + 2, record = (whole.size() - records) / 3;
    for (size_t byte = records + record; byte < records + 2 * record; ++byte) {
        std::string damaged = whole;
        damaged[byte] = static_cast<char>(damaged[byte] ^ 4);
        write_text_file(path, damaged);
        CHECK(TruthState(path, identity, true, 0).tiles() == 1);
    }
}

TEST_CASE("a state says what differs", "[raytrace]") {
    const std::string path = temporary_folder() + "/state";
    const auto error_of = [&](const nlohmann::ordered_json& wanted) -> std::string {
        try {
            TruthState(path, wanted, true, 0);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    CHECK(error_of(identity).empty()); // nothing to resume is no error
    TruthState(path, identity, false, 0).store(0, 0, std::vector<SampleBits>{bits_of(1)});
    CHECK(error_of(identity).empty());
    CHECK(error_of({{"scene", "abd"}, {"seed", 3}}).find("its scene is \"abc\", this run's is \"abd\"") !=
          std::string::npos);
    CHECK(error_of({{"scene", "abc"}, {"seed", 4}}).find("its seed is 3, this run's is 4") != std::string::npos);
    CHECK(error_of({{"scene", "abc"}}).find("it has a seed") != std::string::npos);
    CHECK(error_of({{"scene", "abc"}, {"seed", 3}, {"light 2", "x"}}).find("its light 2 is not there") !=
          std::string::npos);
    write_text_file(path, "gnomon truth state 1\nno json\n");
    CHECK(error_of(identity).find("it is no state of a run") != std::string::npos);
}
