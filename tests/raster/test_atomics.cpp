#include <catch2/catch.hpp>

#include <numeric>

#include "raster/atomics.h"
#include "raster/draw.h"
#include "raster/full_screen.h"
#include "raster/occlusion_query.h"

using namespace gnomon;

TEST_CASE("atomics return the old value and leave the new one") {
    std::uint32_t word = 12;
    CHECK(atomic_add(word, 5u) == 12);
    CHECK(atomic_min(word, 20u) == 17);
    CHECK(atomic_min(word, 9u) == 17);
    CHECK(atomic_max(word, 3u) == 9);
    CHECK(atomic_max(word, 0xf0u) == 9);
    CHECK(atomic_and(word, 0x3cu) == 0xf0);
    CHECK(atomic_or(word, 0x03u) == 0x30);
    CHECK(atomic_xor(word, 0xffu) == 0x33);
    CHECK(atomic_exchange(word, 7u) == 0xcc);
    CHECK(atomic_compare_exchange(word, 8u, 1u) == 7);
    CHECK(word == 7);
    CHECK(atomic_compare_exchange(word, 7u, 1u) == 7);
    CHECK(word == 1);
    CHECK(atomic_add(word, 0xffffffffu) == 1);
    CHECK(word == 0);
    std::int32_t number = -3;
    CHECK(atomic_min(number, 2) == -3);
    CHECK(atomic_max(number, -1) == -3);
    CHECK(number == -1);
    std::int64_t wide = std::int64_t{1} << 40;
    CHECK(atomic_add(wide, std::int64_t{5}) == std::int64_t{1} << 40);
    CHECK(wide == (std::int64_t{1} << 40) + 5);
}

TEST_CASE("image atomics count a word read and a word written, and ignore what does not exist") {
    Target image(Format::R32UI, 4, 4, 2, nullptr, 2);
    PassCounters counters;
    CHECK(atomic_add(image, {1, 1, 1, 1}, 6, counters) == 0);
    CHECK(atomic_max(image, {1, 1, 1, 1}, 4, counters) == 6);
    CHECK(atomic_min(image, {1, 1, 1, 1}, 4, counters) == 6);
    CHECK(atomic_or(image, {1, 1, 1, 1}, 1, counters) == 4);
    CHECK(atomic_and(image, {1, 1, 1, 1}, 1, counters) == 5);
    CHECK(atomic_xor(image, {1, 1, 1, 1}, 3, counters) == 1);
    CHECK(atomic_exchange(image, {1, 1, 1, 1}, 9, counters) == 2);
    CHECK(atomic_compare_exchange(image, {1, 1, 1, 1}, 9, 11, counters) == 9);
    CHECK(image.load_uint(1, 1, 1, 1).x == 11);
    CHECK(counters.texels_fetched == 8);
    CHECK(counters.bytes_read == 32);
    CHECK(counters.bytes_written == 32);
    for (const ImageTexel at : {ImageTexel{2, 0, 0, 1}, {-1, 0}, {0, 4}, {0, 0, 2}, {0, 0, 0, 2}, {0, 0, -1}})
        CHECK(atomic_add(image, at, 1, counters) == 0);
    CHECK(counters.texels_fetched == 8);
    int touched = 0;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) touched += image.load_uint(x, y, 0).x != 0 || image.load_uint(x, y, 1).x != 0;
    CHECK(touched == 0);
}

TEST_CASE("a histogram by atomics is the same for any number of threads") {
    for (const int threads : {1, 2, 7})
        with_threads(threads, [&] {
            PassLog log;
            Pass pass(log, "histogram");
            Target screen(Format::R8, 128, 96), bins(Format::R32UI, 16, 1);
            std::vector<std::uint32_t> extremes = {0xffffffffu, 0, 0};
            full_screen(pass, Targets{.color = {&screen}}, [&](Pixel& p) {
                const auto value = static_cast<std::uint32_t>(p.x * 31 + p.y * 17);
                atomic_add(bins, {static_cast<int>(value % 16), 0}, 1, p.counters);
                atomic_min(extremes[0], value + 3);
                atomic_max(extremes[1], value);
                atomic_or(extremes[2], value);
            });
            std::vector<std::uint32_t> expected(16, 0);
            std::uint32_t bits = 0;
            for (std::uint32_t y = 0; y < 96; ++y)
                for (std::uint32_t x = 0; x < 128; ++x) ++expected[(x * 31 + y * 17) % 16], bits |= x * 31 + y * 17;
            for (int i = 0; i < 16; ++i) CHECK(bins.load_uint(i, 0).x == expected[static_cast<size_t>(i)]);
            CHECK(extremes == std::vector<std::uint32_t>{3, 127 * 31 + 95 * 17, bits});
        });
}

TEST_CASE("an occlusion query counts the fragments that passed while it was open") {
    PassLog log;
    Pass pass(log, "boxes");
    Target depth(Format::D32F, 16, 16);
    depth.clear_depth(pass, 1.0f);
    PipelineState state;
    state.depth = {.test = Compare::Less, .write = true};
    // The rectangle of pixels [x0, x1) × [y0, y1) at depth ½z + ½.
    const auto box = [&](float x0, float y0, float x1, float y1, float z) {
        const std::vector<vec4> corners = {{x0, y0, z, 1}, {x1, y0, z, 1}, {x1, y1, z, 1}, {x0, y1, z, 1}};
        const std::vector<uvec3> triangles = {{0, 1, 3}, {1, 2, 3}};
        draw(
            pass, {4, triangles}, state,
            [&](std::uint32_t i) { return vec4(corners[i].x / 8 - 1, corners[i].y / 8 - 1, corners[i].z, 1); },
            depth_only, Targets{.depth = &depth});
    };
    OcclusionQuery whole(pass, "frame");
    box(0, 0, 8, 16, 0.0f);
    OcclusionQuery behind(pass, whole, "behind");
    CHECK_FALSE(behind.any_samples_passed());
    box(4, 0, 12, 16, 0.5f); // half of it lies behind the first
    CHECK(behind.samples_passed() == 4 * 16);
    CHECK(behind.end() == 4 * 16);
    OcclusionQuery hidden(pass, behind, "hidden");
    box(2, 2, 6, 6, 0.25f);
    CHECK(hidden.end() == 0);
    CHECK_FALSE(hidden.any_samples_passed());
    box(12, 0, 16, 16, 0.0f);
    CHECK(behind.samples_passed() == 4 * 16); // closed
    CHECK(whole.end() == 8 * 16 + 4 * 16 + 4 * 16);
    CHECK(behind.name() == "frame/behind");
    CHECK(hidden.name() == "frame/behind/hidden");
}
