#include "raster/passes/distance_transform.h"
#include "raster/passes/jump_flooding.h"
#include "tests/raster/passes/images.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

std::int32_t squared(int dx, int dy) { return dx * dx + dy * dy; }

// Columns from the left, rows from the bottom, and only a strictly nearer seed replaces one: the tie rule.
Image<Site> brute(const Image<std::uint8_t>& seeds) {
    Image<Site> sites(seeds.width(), seeds.height());
    for (int y = 0; y < seeds.height(); ++y)
        for (int x = 0; x < seeds.width(); ++x) {
            std::int32_t best = no_seed_distance;
            for (int sx = 0; sx < seeds.width(); ++sx)
                for (int sy = 0; sy < seeds.height(); ++sy)
                    if (seeds(sx, sy) && squared(x - sx, y - sy) < best) {
                        best = squared(x - sx, y - sy);
                        sites(x, y) = {static_cast<std::int16_t>(sx), static_cast<std::int16_t>(sy)};
                    }
        }
    return sites;
}

int differing(const Image<Site>& a, const Image<Site>& b) {
    int count = 0;
    for (int y = 0; y < a.height(); ++y)
        for (int x = 0; x < a.width(); ++x) count += a(x, y) != b(x, y);
    return count;
}

Image<std::uint8_t> transposed(const Image<std::uint8_t>& image) {
    Image<std::uint8_t> result(image.height(), image.width());
    for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x) result(y, x) = image(x, y);
    return result;
}

} // namespace

TEST_CASE("nearest seeds equal brute force, ties included") {
    const auto [width, height] = GENERATE(table<int, int>({{64, 64}, {47, 21}, {1, 50}, {70, 1}}));
    const float density = GENERATE(0.001f, 0.1f, 0.5f);
    for (std::uint32_t seed = 1; seed <= 4; ++seed) {
        CAPTURE(width, height, density, seed);
        TestPass t;
        const Image<std::uint8_t> seeds = random_mask(width, height, density, seed);
        CHECK(differing(nearest_seeds(t.pass, seeds), brute(seeds)) == 0);
    }
}

TEST_CASE("no seed, one seed, all seeds") {
    TestPass t;
    Image<std::uint8_t> seeds(33, 18, std::uint8_t{0});
    const Image<Site> none = nearest_seeds(t.pass, seeds);
    CHECK(std::all_of(none.values().begin(), none.values().end(), [](Site s) { return !s.exists(); }));
    CHECK(squared_distances(t.pass, none)(3, 4) == no_seed_distance);
    CHECK(differing(jump_flooding(t.pass, seeds), none) == 0);
    seeds(20, 7) = 1;
    const Image<Site> one = nearest_seeds(t.pass, seeds);
    CHECK(std::all_of(one.values().begin(), one.values().end(), [](Site s) { return s == Site{20, 7}; }));
    CHECK(squared_distances(t.pass, one)(17, 11) == 9 + 16);
    CHECK(differing(jump_flooding(t.pass, seeds), one) == 0);
    const Image<std::uint8_t> all(33, 18, std::uint8_t{255});
    const Image<std::int32_t> distances = squared_distances(t.pass, nearest_seeds(t.pass, all));
    CHECK(std::all_of(distances.values().begin(), distances.values().end(), [](int d) { return d == 0; }));
}

TEST_CASE("a tie goes to the smaller column and then to the smaller row") {
    TestPass t;
    Image<std::uint8_t> seeds(5, 5, std::uint8_t{0});
    for (const ivec2 corner : {ivec2(0, 0), ivec2(4, 0), ivec2(0, 4), ivec2(4, 4)}) seeds(corner.x, corner.y) = 1;
    const Image<Site> sites = nearest_seeds(t.pass, seeds);
    CHECK(sites(2, 2) == Site{0, 0});
    CHECK(sites(2, 4) == Site{0, 4});
    CHECK(sites(4, 2) == Site{4, 0});
    CHECK(differing(jump_flooding(t.pass, seeds), sites) == 0);
}

TEST_CASE("distances do not change under transposition") {
    TestPass t;
    const std::uint32_t seed = 9;
    const Image<std::uint8_t> seeds = random_mask(90, 41, 0.01f, seed);
    const Image<std::int32_t> distances = squared_distances(t.pass, nearest_seeds(t.pass, seeds));
    const Image<std::int32_t> turned = squared_distances(t.pass, nearest_seeds(t.pass, transposed(seeds)));
    bool same = true;
    for (int y = 0; y < 41; ++y)
        for (int x = 0; x < 90; ++x) same = same && distances(x, y) == turned(y, x);
    CHECK(same);
}

TEST_CASE("the distance transform holds at the largest side") {
    TestPass t;
    Image<std::uint8_t> seeds(max_image_side, 2, std::uint8_t{0});
    seeds(0, 0) = seeds(max_image_side - 1, 1) = 1;
    const Image<Site> sites = nearest_seeds(t.pass, seeds);
    CHECK(sites(16383, 0) == Site{0, 0});
    CHECK(sites(16384, 0) == Site{32767, 1}); // 16383² + 1 is less than 16384²
    CHECK(sites(16383, 1) == Site{0, 0});
    CHECK(sites(16384, 1) == Site{32767, 1});
    CHECK(differing(jump_flooding(t.pass, seeds), sites) == 0);
}

TEST_CASE("jump flooding is close to the truth, closer with a step before or after") {
    TestPass t;
    const int side = 96;
    int plain = 0, before = 0, after = 0;
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
        const Image<std::uint8_t> seeds = random_mask(side, side, 0.02f, seed);
        const Image<std::int32_t> truth = squared_distances(t.pass, nearest_seeds(t.pass, seeds));
        const auto farther = [&](const JumpFlooding& options) {
            const Image<Site> sites = jump_flooding(t.pass, seeds, options);
            const Image<std::int32_t> distances = squared_distances(t.pass, sites);
            int count = 0;
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    const Site site = sites(x, y);
                    if (!seeds(site.x, site.y) || distances(x, y) < truth(x, y)) FAIL("no seed at the site");
                    count += distances(x, y) > truth(x, y);
                }
            return count;
        };
        plain += farther({});
        before += farther({.one_before = true});
        after += farther({.after = 2});
    }
    CAPTURE(plain, before, after);
    CHECK(plain <= 10 * side * side / 100); // one pixel in a hundred
    CHECK(before < plain);
    CHECK(after < plain);
}

TEST_CASE("distance transforms count their passes and have the same bits for any number of threads") {
    const Image<std::uint8_t> seeds = random_mask(131, 67, 0.01f, 2);
    check_threads(
        [&] {
            TestPass t;
            return nearest_seeds(t.pass, seeds);
        },
        [](const auto& a, const auto& b) { return same_bits(a, b); });
    check_threads(
        [&] {
            TestPass t;
            return jump_flooding(t.pass, seeds, {.one_before = true});
        },
        [](const auto& a, const auto& b) { return same_bits(a, b); });
    TestPass t;
    nearest_seeds(t.pass, seeds);
    CHECK(t.pass.counters().draws == 5);
    CHECK(t.pass.counters().texels_fetched == 5 * 131 * 67);
    TestPass flooding;
    jump_flooding(flooding.pass, Image<std::uint8_t>(4, 4, std::uint8_t{1}));
    // Seeding; step 2, where each axis offers 2 of 3 columns to every pixel; step 1: 10 of 12.
    CHECK(flooding.pass.counters().draws == 3);
    CHECK(flooding.pass.counters().texels_fetched == 16 + 8 * 8 + 10 * 10);
}
