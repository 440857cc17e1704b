#include "raster/passes/mip.h"
#include "tests/raster/passes/images.h"

using namespace gnomon;
using namespace gnomon_tests;

TEST_CASE("a mip texel is the mean of its 2x2 block") {
    TestPass t;
    Target base(Format::R32F, 4, 4);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) base.store(x, y, 0, vec4(static_cast<float>(x + 4 * y)));
    const std::vector<Target> chain = mip_chain(t.pass, std::move(base));
    REQUIRE(chain.size() == 3);
    CHECK(chain[1].load(0, 0).x == 2.5f);
    CHECK(chain[1].load(1, 0).x == 4.5f);
    CHECK(chain[1].load(0, 1).x == 10.5f);
    CHECK(chain[2].load(0, 0).x == 7.5f);
    CHECK(t.pass.counters().texels_fetched == 16 + 4);
    CHECK(t.pass.counters().fragments_shaded == 4 + 1);
    CHECK(t.pass.counters().bytes_written == 4 * 5);
    CHECK(t.pass.counters().draws == 2);
}

TEST_CASE("an odd side is averaged by area") {
    TestPass t;
    Target source(Format::R32F, 5, 1), level(Format::R32F, 2, 1);
    for (int x = 0; x < 5; ++x) source.store(x, 0, 0, vec4(static_cast<float>(x)));
    fill_mip(t.pass, source, level);
    // Texel 0 covers [0, 2.5): two texels and half of the third.
    CHECK(level.load(0, 0).x == Approx((0 + 1 + 0.5 * 2) / 2.5));
    CHECK(level.load(1, 0).x == Approx((0.5 * 2 + 3 + 4) / 2.5));
    CHECK(t.pass.counters().texels_fetched == 6);
}

TEST_CASE("every mip level keeps the mean and a constant") {
    TestPass t;
    const auto [width, height] = GENERATE(table<int, int>({{64, 64}, {37, 53}, {1, 19}, {100, 3}}));
    const std::uint32_t seed = 17;
    CAPTURE(width, height, seed);
    const std::vector<Target> chain = mip_chain(t.pass, random_target(Format::RG32F, width, height, seed, 2));
    REQUIRE(static_cast<int>(chain.size()) == mip_levels(width, height));
    for (int layer = 0; layer < 2; ++layer) {
        std::vector<dvec2> means;
        for (const Target& level : chain) {
            dvec2 sum(0.0);
            for (int y = 0; y < level.height(); ++y)
                for (int x = 0; x < level.width(); ++x) sum += dvec2(vec2(level.load(x, y, layer)));
            means.push_back(sum / static_cast<double>(level.width() * level.height()));
        }
        for (const dvec2 mean : means) {
            CHECK(mean.x == Approx(means[0].x).epsilon(1e-6));
            CHECK(mean.y == Approx(means[0].y).epsilon(1e-6));
        }
    }
    Target constant(Format::RGBA8, width, height);
    constant.clear(t.pass, vec4(0.6f));
    const std::vector<Target> constants = mip_chain(t.pass, std::move(constant));
    CHECK(constants.back().load(0, 0) == constants.front().load(0, 0));
    CHECK(constants.back().width() == 1);
    CHECK(constants.back().height() == 1);
}

TEST_CASE("a mip chain has the same bits for any number of threads") {
    check_threads(
        [] {
            TestPass t;
            return mip_chain(t.pass, random_target(Format::RGBA32F, 129, 66, 3));
        },
        [](const auto& a, const auto& b) {
            bool same = true;
            for (size_t level = 0; level < a.size(); ++level) same = same && same_bits(a[level], b[level]);
            return same;
        });
}
