#include <catch2/catch.hpp>

#include "raster/full_screen.h"
#include "raster/passes/filter.h"
#include "raster/sampler.h"

using namespace gnomon;

namespace {

struct Fixture {
    PassLog log;
    Pass pass{log, "test"};
    Target depth{Format::D32F, 4, 4};
    Fixture() {
        // Column x has depth x/4 + 1/8.
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 4; ++x) depth.store_key(x, y, 0, depth_key(Format::D32F, x / 4.0 + 0.125));
    }
};

} // namespace

TEST_CASE("samplers wrap, filter and count their texels") {
    Fixture f;
    PassCounters counters;
    const auto nearest = [&](Wrap wrap, float u) {
        return sample(f.depth, {.wrap = wrap, .border = vec4(0.75f)}, {u, 0.5f}, counters).x;
    };
    CHECK(nearest(Wrap::Clamp, 0.3f) == 0.375f);
    CHECK(nearest(Wrap::Clamp, -3.0f) == 0.125f);
    CHECK(nearest(Wrap::Repeat, 1.1f) == 0.125f);
    CHECK(nearest(Wrap::Repeat, -0.1f) == 0.875f);
    CHECK(nearest(Wrap::Mirror, 1.1f) == 0.875f);
    CHECK(nearest(Wrap::Mirror, -0.3f) == 0.375f);
    CHECK(counters.texels_fetched == 6);
    CHECK(nearest(Wrap::Border, 1.1f) == 0.75f);
    CHECK(counters.texels_fetched == 6); // the border is no texel
    CHECK(sample(f.depth, {.filter = Filter::Linear}, {0.5f, 0.5f}, counters).x == 0.5f);
    CHECK(counters.texels_fetched == 10);
    CHECK(counters.bytes_read == 40);
}

TEST_CASE("depth comparison filters results, not depths") {
    Fixture f;
    PassCounters counters;
    const Sampler linear = {.filter = Filter::Linear};
    // Between columns 1 (0.375) and 2 (0.625): a reference of 0.5 is beyond the one and before the other.
    CHECK(sample_compare(f.depth, linear, {0.5f, 0.5f}, 0.5f, Compare::LessEqual, counters) == 0.5f);
    CHECK(sample_compare(f.depth, linear, {0.5625f, 0.5f}, 0.5f, Compare::LessEqual, counters) == 0.75f);
    CHECK(sample_compare(f.depth, {}, {0.6f, 0.5f}, 0.5f, Compare::LessEqual, counters) == 1.0f);
    CHECK(sample_compare(f.depth, {}, {0.4f, 0.5f}, 0.5f, Compare::LessEqual, counters) == 0.0f);
    CHECK(sample_compare(f.depth, {}, {0.9f, 0.5f}, 7.0f, Compare::Greater, counters) == 1.0f); // clamped to 1
}

TEST_CASE("binomial weights are Pascal's triangle") {
    const std::vector<float> seven = {1 / 64.f, 6 / 64.f, 15 / 64.f, 20 / 64.f, 15 / 64.f, 6 / 64.f, 1 / 64.f};
    CHECK(binomial_weights(7) == seven);
    double sum = 0;
    for (const float w : binomial_weights(31)) sum += static_cast<double>(w);
    CHECK(sum == Approx(1.0).epsilon(1e-7));
}

TEST_CASE("a separable filter equals the double sum, in every format it takes") {
    const Format format = GENERATE(Format::R32F, Format::RG32F, Format::RGBA16F, Format::RGBA8);
    PassLog log;
    Pass pass(log, "blur");
    Target source(format, 9, 5, 2), rows(format, 9, 5, 2), blurred(format, 9, 5, 2);
    for (int layer = 0; layer < 2; ++layer)
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 9; ++x)
                source.store(x, y, layer, vec4(static_cast<float>((x * 7 + y * 5 + layer * 3) % 11) / 11.0f));
    const std::vector<float> weights = {0.25f, 0.5f, 0.25f};
    convolve_rows(pass, source, rows, weights);
    convolve_columns(pass, rows, blurred, weights);
    const float tolerance =
        info(format).kind == FormatInfo::Kind::Float ? 1e-6f : 0.005f; // two roundings to the format
    for (int layer = 0; layer < 2; ++layer)
        for (int y = 0; y < 5; ++y)
            for (int x = 0; x < 9; ++x) {
                float sum = 0;
                for (int j = -1; j <= 1; ++j)
                    for (int i = -1; i <= 1; ++i)
                        sum += weights[static_cast<size_t>(i + 1)] * weights[static_cast<size_t>(j + 1)] *
                               source.load(std::clamp(x + i, 0, 8), std::clamp(y + j, 0, 4), layer).x;
                CHECK(std::abs(blurred.load(x, y, layer).x - sum) <= tolerance);
            }
    CHECK(log.passes[0].texels_fetched == 2 * 2 * 3 * 9 * 5);
}

TEST_CASE("a full-screen pass blends into its targets and counts its pixels") {
    PassLog log;
    Pass pass(log, "add");
    Target target(Format::RGBA8, 5, 3);
    target.clear(pass, vec4(0.25f));
    full_screen(
        pass, Targets{.color = {&target}},
        [](Pixel& p) {
            p.color[0] = vec4(0.5f, 1.0f, 0.0f, 0.0f);
            p.discarded = p.x == 2;
        },
        BlendState::add());
    CHECK(target.load(0, 0).x == Approx(0.75f).margin(0.003));
    CHECK(target.load(0, 0).y == 1.0f);
    CHECK(target.load(2, 1).x == Approx(0.25f).margin(0.003));
    CHECK(log.passes[0].fragments_shaded == 15);
    CHECK(log.passes[0].fragments_passed == 12);
    CHECK(log.passes[0].bytes_written == 4 * 15 + 4 * 12); // the clear and the pixels
}

TEST_CASE("a target counts its memory for as long as it lives") {
    const auto meter = std::make_shared<MemoryMeter>();
    {
        const Target a(Format::RGBA32F, 16, 16, 6, meter);
        CHECK(meter->peak() == 16 * 16 * 6 * 16);
    }
    const Target b(Format::R8, 16, 16, 1, meter);
    CHECK(meter->peak() == 16 * 16 * 6 * 16); // not the sum of the two
}
