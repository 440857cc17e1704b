#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include "raster/sampler.h"

using namespace gnomon;

namespace {

// 16×16 with five levels; level l holds the value l everywhere.
Target levels_by_value(Format format = Format::R32F) {
    Target target(format, 16, 16, 1, nullptr, 5);
    for (int level = 0; level < 5; ++level)
        for (int y = 0; y < target.height(level); ++y)
            for (int x = 0; x < target.width(level); ++x)
                target.store(x, y, 0, vec4(static_cast<float>(level)), 15, level);
    return target;
}

constexpr Sampler trilinear = {.filter = Filter::Linear, .mip = MipFilter::Linear};

} // namespace

TEST_CASE("the level of detail is the log of the longer gradient in texels") {
    const Target target(Format::R32F, 256, 128);
    const auto lod = [&](vec2 ddx, vec2 ddy) { return level_of_detail(target, ddx, ddy); };
    CHECK(lod({1.0f / 256, 0}, {0, 1.0f / 128}) == 0.0f);
    CHECK(lod({4.0f / 256, 0}, {0, 1.0f / 128}) == 2.0f);
    CHECK(lod({1.0f / 256, 0}, {0, 8.0f / 128}) == 3.0f);
    CHECK(lod({0.5f / 256, 0}, {0, 0.25f / 128}) == -1.0f);
    CHECK(lod({3.0f / 256, 4.0f / 128}, {0, 0}) == Approx(std::log2(5.0)).epsilon(1e-7)); // a length, not a maximum
    CHECK(lod({3.0f / 256, 0}, {0, 0}) == static_cast<float>(std::log2(3.0)));
    CHECK(lod({0, 0}, {0, 0}) == -infinity);
    for (float texels = 0.01f; texels < 300.0f; texels *= 1.37f)
        CHECK(std::abs(lod({texels / 256, 0}, {0, 0}) - std::log2(texels)) < 2e-6f);
}

TEST_CASE("trilinear filtering blends the two levels that lambda lies between") {
    const Target target = levels_by_value();
    PassCounters counters;
    const auto at = [&](const Sampler& sampler, float lod) {
        return sample_lod(target, sampler, {0.4f, 0.3f}, lod, counters).x;
    };
    CHECK(at(trilinear, 0.5f) == 0.5f);
    CHECK(at(trilinear, 2.25f) == 2.25f);
    CHECK(counters.texels_fetched == 16);
    CHECK(counters.bytes_read == 64);
    CHECK(at(trilinear, 3.0f) == 3.0f);
    CHECK(counters.texels_fetched == 20); // a whole lambda reads one level
    CHECK(at(trilinear, -4.0f) == 0.0f);
    CHECK(at(trilinear, 99.0f) == 4.0f);
    CHECK(at(trilinear, infinity) == 4.0f);
    CHECK(at(trilinear, std::nanf("")) == 0.0f);
    // Nearest level: ties go to the finer one.
    const Sampler nearest = {.mip = MipFilter::Nearest};
    CHECK(at(nearest, 0.5f) == 0.0f);
    CHECK(at(nearest, 0.51f) == 1.0f);
    CHECK(at(nearest, 1.5f) == 1.0f);
    CHECK(at(nearest, 1.6f) == 2.0f);
    CHECK(at(nearest, 77.0f) == 4.0f);
    CHECK(at({.filter = Filter::Linear}, 3.0f) == 0.0f); // no mip filter: level 0
}

TEST_CASE("bias and clamps of lambda apply in the order of the specification") {
    const Target target = levels_by_value();
    PassCounters counters;
    Sampler sampler = trilinear;
    sampler.lod_bias = 1.0f;
    CHECK(sample_lod(target, sampler, {0.5f, 0.5f}, 1.5f, counters).x == 2.5f);
    sampler.max_lod = 2.0f;
    CHECK(sample_lod(target, sampler, {0.5f, 0.5f}, 1.5f, counters).x == 2.0f);
    sampler.min_lod = 1.25f;
    CHECK(sample_lod(target, sampler, {0.5f, 0.5f}, -9.0f, counters).x == 1.25f);
    CHECK(sample_grad(target, trilinear, {0.5f, 0.5f}, {4.0f / 16, 0}, {0, 1.0f / 16}, counters).x == 2.0f);
    CHECK(sample_grad(target, trilinear, {0.5f, 0.5f}, vec2(0.0f), vec2(0.0f), counters).x == 0.0f);
}

TEST_CASE("magnification can have its own filter") {
    Target target(Format::R32F, 2, 2, 1, nullptr, 2);
    for (int y = 0; y < 2; ++y) target.store(1, y, 0, vec4(1.0f));
    target.store(0, 0, 0, vec4(0.5f), 15, 1);
    PassCounters counters;
    Sampler sampler = trilinear;
    sampler.magnify = Filter::Nearest;
    CHECK(sample_lod(target, sampler, {0.6f, 0.5f}, 0.0f, counters).x == 1.0f);
    CHECK(counters.texels_fetched == 1);
    CHECK(sample_lod(target, sampler, {0.5f, 0.5f}, 0.5f, counters).x == 0.5f);
}

TEST_CASE("anisotropic filtering probes along the stretched footprint") {
    const Target target = levels_by_value();
    const auto probe = [&](vec2 ddx, vec2 ddy, int most) {
        PassCounters counters;
        Sampler sampler = trilinear;
        sampler.max_anisotropy = most;
        const float level = sample_grad(target, sampler, {0.5f, 0.5f}, ddx, ddy, counters).x;
        return std::pair(counters.texels_fetched, level);
    };
    using Result = std::pair<std::int64_t, float>;
    // 8×2 texels: four probes at lambda log2(8/4) = 1; without anisotropy one at 3.
    CHECK(probe({8.0f / 16, 0}, {0, 2.0f / 16}, 16) == Result(16, 1.0f));
    CHECK(probe({8.0f / 16, 0}, {0, 2.0f / 16}, 1) == Result(4, 3.0f));
    CHECK(probe({8.0f / 16, 0}, {0, 2.0f / 16}, 2) == Result(8, 2.0f));
    CHECK(probe({0, 2.0f / 16}, {8.0f / 16, 0}, 16) == Result(16, 1.0f)); // the other axis
    CHECK(probe({2.0f / 16, 0}, {0, 2.0f / 16}, 16) == Result(4, 1.0f));  // isotropic
    CHECK(probe({8.0f / 16, 0}, {0, 0}, 4) == Result(16, 1.0f));          // no width: the most probes
    CHECK(probe({0, 0}, {0, 0}, 4) == Result(4, 0.0f));

    // The probes lie symmetrically along the major axis: a ramp gives its value at the centre, a cross ramp is not
    // seen.
    Target ramp(Format::R32F, 16, 16);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) ramp.store(x, y, 0, vec4(static_cast<float>(x * x), 0, 0, 0));
    PassCounters counters;
    Sampler linear = {.filter = Filter::Linear, .max_anisotropy = 3};
    // Centre at texel coordinate 8 (value between columns), three probes 12·(¼ − ½) = −3, 0, +3 texels apart.
    const auto squares = [](float u) { // bilinear between x² at centres x + ½
        const float x = std::floor(u - 0.5f), f = u - 0.5f - x;
        return x * x + ((x + 1) * (x + 1) - x * x) * f;
    };
    CHECK(sample_grad(ramp, linear, {0.5f, 0.5f}, {12.0f / 16, 0}, {0, 1.0f / 16}, counters).x ==
          Approx((squares(5) + squares(8) + squares(11)) / 3));
}

TEST_CASE("comparisons filter between levels, and clamp only depth formats") {
    Target depth(Format::D32F, 4, 4, 1, nullptr, 3);
    for (int level = 0; level < 3; ++level)
        for (int y = 0; y < depth.height(level); ++y)
            for (int x = 0; x < depth.width(level); ++x)
                depth.store_key(x, y, 0, depth_key(Format::D32F, level == 1 ? 0.25 : 0.75), level);
    PassCounters counters;
    CHECK(sample_compare_lod(depth, trilinear, {0.5f, 0.5f}, 0.5f, Compare::LessEqual, 0.25f, counters) == 0.75f);
    CHECK(sample_compare_lod(depth, trilinear, {0.5f, 0.5f}, 0.5f, Compare::LessEqual, 1.0f, counters) == 0.0f);
    CHECK(sample_compare_grad(depth, trilinear, {0.5f, 0.5f}, 0.5f, Compare::LessEqual, {4 / 4.f, 0}, {0, 0},
                              counters) == 1.0f);
    Target distance(Format::R32F, 1, 1);
    distance.store(0, 0, 0, vec4(7.0f));
    CHECK(sample_compare(distance, {}, {0.5f, 0.5f}, 6.0f, Compare::LessEqual, counters) == 1.0f);
    CHECK(sample_compare(distance, {}, {0.5f, 0.5f}, 8.0f, Compare::LessEqual, counters) == 0.0f);
    // Every comparison, reference below, at and above the stored value.
    distance.store(0, 0, 0, vec4(0.5f));
    const auto row = [&](Compare test) {
        int bits = 0;
        for (const float reference : {0.25f, 0.5f, 0.75f})
            bits = bits * 2 + (sample_compare(distance, {}, {0.5f, 0.5f}, reference, test, counters) == 1.0f);
        return bits;
    };
    CHECK(row(Compare::Never) == 0b000);
    CHECK(row(Compare::Less) == 0b100);
    CHECK(row(Compare::Equal) == 0b010);
    CHECK(row(Compare::LessEqual) == 0b110);
    CHECK(row(Compare::Greater) == 0b001);
    CHECK(row(Compare::NotEqual) == 0b101);
    CHECK(row(Compare::GreaterEqual) == 0b011);
    CHECK(row(Compare::Always) == 0b111);
}

TEST_CASE("each coordinate has its own wrap mode, and the border blends in by its weight") {
    Target target(Format::R32F, 2, 2);
    for (int y = 0; y < 2; ++y)
        for (int x = 0; x < 2; ++x) target.store(x, y, 0, vec4(static_cast<float>(1 + x + 2 * y)));
    PassCounters counters;
    const Sampler mixed = {.wrap = Wrap::Repeat, .border = vec4(9.0f), .wrap_v = Wrap::Border};
    CHECK(sample(target, mixed, {1.25f, 0.25f}, counters).x == 1.0f);
    CHECK(sample(target, mixed, {0.25f, 1.25f}, counters).x == 9.0f);
    const Sampler border = {.filter = Filter::Linear, .wrap = Wrap::Border, .border = vec4(9.0f)};
    counters = {};
    CHECK(sample(target, border, {0.0f, 0.25f}, counters).x == 5.0f); // half of 1, half of the border
    CHECK(counters.texels_fetched == 2);
    CHECK(sample(target, border, {0.0f, 0.0f}, counters).x == 7.0f); // a quarter of 1
    const Sampler repeat = {.filter = Filter::Linear, .wrap = Wrap::Repeat};
    CHECK(sample(target, repeat, {0.0f, 0.25f}, counters).x == 1.5f);
    CHECK(sample(target, repeat, {1.0f, 0.25f}, counters).x == 1.5f);
    const Sampler mirror = {.filter = Filter::Linear, .wrap = Wrap::Mirror};
    CHECK(sample(target, mirror, {0.0f, 0.25f}, counters).x == 1.0f);
    CHECK(sample(target, mirror, {-0.75f, 0.25f}, counters).x == 2.0f);
}

TEST_CASE("bilinear filtering equals the weighted sum of four fetches, for every format and wrap mode") {
    const Format format = GENERATE(Format::R32F, Format::RG32F, Format::RGBA32F, Format::RGBA16F, Format::RGBA8,
                                   Format::RG16, Format::R8);
    const Wrap wrap = GENERATE(Wrap::Clamp, Wrap::Border, Wrap::Repeat, Wrap::Mirror);
    std::mt19937 random(17);
    const auto unit = [&] { return static_cast<float>(random() % 10001) / 10000.0f; };
    Target target(format, 7, 5, 2, nullptr, 2);
    for (int level = 0; level < 2; ++level)
        for (int layer = 0; layer < 2; ++layer)
            for (int y = 0; y < target.height(level); ++y)
                for (int x = 0; x < target.width(level); ++x)
                    target.store(x, y, layer, vec4(unit(), unit(), unit(), unit()), 15, level);
    const Sampler sampler = {.filter = Filter::Linear, .wrap = wrap, .border = vec4(0.5f), .mip = MipFilter::Nearest};
    float worst = 0;
    for (int i = 0; i < 500; ++i) {
        const int level = static_cast<int>(random() % 2), layer = static_cast<int>(random() % 2);
        const int w = target.width(level), h = target.height(level);
        const vec2 uv(unit() * 4 - 1.5f, unit() * 4 - 1.5f);
        const auto index = [&](int k, int n) { // −1: border
            if (wrap == Wrap::Clamp) return std::min(std::max(k, 0), n - 1);
            if (wrap == Wrap::Border) return k < 0 || k >= n ? -1 : k;
            while (k < 0) k += 2 * n;
            k %= wrap == Wrap::Repeat ? n : 2 * n;
            return k < n ? k : 2 * n - 1 - k;
        };
        const double u = static_cast<double>(uv.x) * w - 0.5, v = static_cast<double>(uv.y) * h - 0.5;
        const int x = static_cast<int>(std::floor(u)), y = static_cast<int>(std::floor(v));
        dvec4 sum(0.0);
        std::int64_t texels = 0;
        for (int dy = 0; dy < 2; ++dy)
            for (int dx = 0; dx < 2; ++dx) {
                const int a = index(x + dx, w), b = index(y + dy, h);
                texels += a >= 0 && b >= 0;
                const vec4 texel = a >= 0 && b >= 0 ? target.load(a, b, layer, level) : vec4(0.5f);
                sum += dvec4(texel) * ((dx ? u - x : 1 - (u - x)) * (dy ? v - y : 1 - (v - y)));
            }
        PassCounters counters;
        const vec4 got = sample_lod(target, sampler, uv, static_cast<float>(level), counters, layer);
        for (int c = 0; c < 4; ++c) worst = std::max(worst, std::abs(got[c] - static_cast<float>(sum[c])));
        REQUIRE(counters.texels_fetched == texels);
        REQUIRE(counters.bytes_read == texels * info(format).bytes);
    }
    CHECK(worst < 5e-6f);
}

TEST_CASE("weights can be rounded to 1/256 as GPUs do") {
    Target target(Format::R32F, 2, 1);
    target.store(1, 0, 0, vec4(256.0f));
    PassCounters counters;
    const float u = 0.25f + 0.5f * 100.4f / 256.0f;
    CHECK(sample(target, {.filter = Filter::Linear}, {u, 0.5f}, counters).x == Approx(100.4f));
    CHECK(sample(target, {.filter = Filter::Linear, .subtexel8 = true}, {u, 0.5f}, counters).x == 100.0f);
}

TEST_CASE("gather returns the footprint counter-clockwise from the upper left") {
    Target target(Format::RG32F, 4, 4);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) target.store(x, y, 0, vec4(static_cast<float>(10 * y + x), 1.0f, 0, 0));
    PassCounters counters;
    CHECK(gather(target, {}, {0.5f, 0.5f}, 0, counters) == vec4(21, 22, 12, 11));
    CHECK(gather(target, {}, {0.5f, 0.5f}, 1, counters) == vec4(1));
    CHECK(counters.texels_fetched == 8);
    CHECK(gather(target, {}, {0.0f, 0.0f}, 0, counters) == vec4(0)); // clamped to the corner
    CHECK(gather_compare(target, {}, {0.5f, 0.5f}, 12.0f, Compare::LessEqual, counters) == vec4(1, 1, 1, 0));
}

TEST_CASE("array coordinates round to the nearest layer, ties to even, and clamp") {
    CHECK(array_layer(0.49f, 4) == 0);
    CHECK(array_layer(0.5f, 4) == 0);
    CHECK(array_layer(1.5f, 4) == 2);
    CHECK(array_layer(2.5f, 4) == 2);
    CHECK(array_layer(2.51f, 4) == 3);
    CHECK(array_layer(99.0f, 4) == 3);
    CHECK(array_layer(-1.0f, 4) == 0);
    CHECK(array_layer(std::nanf(""), 4) == 0);
}

TEST_CASE("a fetch outside the texture is zero and costs nothing") {
    const Target target = levels_by_value();
    PassCounters counters;
    CHECK(fetch(target, 3, 3, 0, 2, counters).x == 2.0f);
    CHECK(counters.texels_fetched == 1);
    for (const auto& [x, y, layer, level] :
         {std::array{4, 0, 0, 2}, {0, -1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 5}, {0, 0, 0, -1}, {16, 0, 0, 0}})
        CHECK(fetch(target, x, y, layer, level, counters) == vec4(0.0f));
    CHECK(counters.texels_fetched == 1);
    Target ids(Format::R32UI, 2, 2);
    ids.store_uint(1, 0, 0, glm::uvec4(0xfffffff0u));
    CHECK(fetch_uint(ids, 1, 0, 0, 0, counters).x == 0xfffffff0u);
    CHECK(fetch_uint(ids, 2, 0, 0, 0, counters) == glm::uvec4(0u));
}
