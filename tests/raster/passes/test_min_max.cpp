#include "raster/passes/min_max.h"
#include "tests/raster/passes/images.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

MinMax brute(const Target& map, ivec2 first, ivec2 last, int layer = 0) {
    MinMax bounds;
    for (int y = std::max(0, first.y); y <= std::min(last.y, map.height() - 1); ++y)
        for (int x = std::max(0, first.x); x <= std::min(last.x, map.width() - 1); ++x) {
            bounds.minimum = std::min(bounds.minimum, map.load(x, y, layer).x);
            bounds.maximum = std::max(bounds.maximum, map.load(x, y, layer).x);
        }
    return bounds;
}

} // namespace

TEST_CASE("every texel of a min-max pyramid bounds what it covers, and is met by it") {
    TestPass t;
    const auto [width, height] = GENERATE(table<int, int>({{64, 64}, {37, 53}, {1, 19}, {100, 3}, {1, 1}}));
    const std::uint32_t seed = 5;
    CAPTURE(width, height, seed);
    const Target map = random_target(Format::R32F, width, height, seed, 2);
    const MinMaxPyramid pyramid = min_max_pyramid(t.pass, map);
    CHECK(pyramid.levels.back().width() == 1);
    CHECK(pyramid.levels.back().height() == 1);
    bool exact = true;
    for (int level = 0; level < static_cast<int>(pyramid.levels.size()); ++level) {
        const Target& target = pyramid.levels[static_cast<size_t>(level)];
        for (int layer = 0; layer < 2; ++layer)
            for (int y = 0; y < target.height(); ++y)
                for (int x = 0; x < target.width(); ++x) {
                    const MinMax truth =
                        brute(map, {x << level, y << level}, {((x + 1) << level) - 1, ((y + 1) << level) - 1}, layer);
                    const vec4 stored = target.load(x, y, layer);
                    exact = exact && stored.x == truth.minimum && stored.y == truth.maximum;
                }
    }
    CHECK(exact);
}

TEST_CASE("a min-max query is conservative, exact at level 0, and fetches at most four texels at the named level") {
    TestPass t;
    const std::uint32_t seed = 23;
    CAPTURE(seed);
    const Target map = random_target(Format::R32F, 77, 45, seed);
    const MinMaxPyramid pyramid = min_max_pyramid(t.pass, map);
    int loose = 0;
    for (int i = 0; i < 4000; ++i) {
        const auto draw = [&](int channel, int span) {
            return static_cast<int>(random_unit(i, 1, channel, seed) * static_cast<float>(span));
        };
        const ivec2 first(draw(0, 90) - 8, draw(1, 60) - 8), last = first + ivec2(draw(2, 40), draw(3, 40));
        const MinMax truth = brute(map, first, last);
        PassCounters counters;
        const MinMax bounds = min_max_over(pyramid, first, last, counters);
        const bool conservative = bounds.minimum <= truth.minimum && bounds.maximum >= truth.maximum;
        const bool cheap = counters.texels_fetched <= 4 && counters.bytes_read == 8 * counters.texels_fetched;
        if (!conservative || !cheap) FAIL("rectangle " << i);
        if (min_max_over(pyramid, first, last, 0, counters) != truth) FAIL("level 0, rectangle " << i);
        loose += bounds != truth;
    }
    CHECK(loose > 0);
    CHECK(min_max_level(1, 1) == 0);
    CHECK(min_max_level(2, 1) == 1);
    CHECK(min_max_level(9, 9) == 4);
    CHECK(min_max_level(3, 16) == 4);
    PassCounters counters;
    CHECK(min_max_over(pyramid, {-5, 0}, {-1, 9}, counters) == MinMax{});
}

TEST_CASE("a min-max pyramid takes depth formats and passes over NaN") {
    TestPass t;
    Target depth(Format::D16, 3, 2);
    depth.clear_depth(t.pass, 1.0f);
    depth.store_key(2, 1, 0, depth_key(Format::D16, 0.25));
    const MinMaxPyramid of_depth = min_max_pyramid(t.pass, depth);
    CHECK(of_depth.levels.back().load(0, 0).x == depth.depth(2, 1));
    CHECK(of_depth.levels.back().load(0, 0).y == 1.0f);
    Target values = random_target(Format::R32F, 3, 2, 1);
    values.store(1, 0, 0, vec4(std::numeric_limits<float>::quiet_NaN()));
    PassCounters counters;
    const MinMaxPyramid of_values = min_max_pyramid(t.pass, values);
    CHECK(min_max_over(of_values, {1, 0}, {1, 0}, counters) == MinMax{});
    CHECK(min_max_over(of_values, {0, 0}, {1, 0}, 0, counters) == MinMax{values.load(0, 0).x, values.load(0, 0).x});
}

TEST_CASE("a min-max pyramid has the same bits and counters for any number of threads") {
    check_threads(
        [] {
            TestPass t;
            MinMaxPyramid pyramid = min_max_pyramid(t.pass, random_target(Format::R32F, 65, 33, 3));
            return std::pair(std::move(pyramid), t.pass.counters().texels_fetched);
        },
        [](const auto& a, const auto& b) {
            bool same =
                a.second == b.second && a.second == 65 * 33 + 65 * 33 + 33 * 17 + 17 * 9 + 9 * 5 + 5 * 3 + 3 * 2 + 2;
            for (size_t level = 0; level < a.first.levels.size(); ++level)
                same = same && same_bits(a.first.levels[level], b.first.levels[level]);
            return same;
        });
}
