#include "raster/passes/summed_area.h"
#include "tests/raster/passes/images.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

// The integral of the piecewise constant map over a rectangle inside it, divided by its area.
double brute_mean(const Target& map, dvec2 low, dvec2 high, int channel) {
    double sum = 0;
    for (int y = 0; y < map.height(); ++y)
        for (int x = 0; x < map.width(); ++x) {
            const double w = std::max(0.0, std::min(high.x, x + 1.0) - std::max(low.x, static_cast<double>(x)));
            const double h = std::max(0.0, std::min(high.y, y + 1.0) - std::max(low.y, static_cast<double>(y)));
            sum += w * h * static_cast<double>(map.load(x, y)[channel]);
        }
    return sum / ((high.x - low.x) * (high.y - low.y));
}

} // namespace

TEST_CASE("integer summed areas equal brute force for all boxes") {
    TestPass t;
    const int width = 65, height = 33;
    const std::uint32_t seed = 41;
    CAPTURE(seed);
    const Target map = random_target(Format::R16, width, height, seed);
    const SummedAreaOptions options = {.fraction_bits = 30}; // 32-bit sums wrap after four texels of 1
    const SummedArea<std::int64_t> exact = summed_area<std::int64_t>(t.pass, map, options);
    const SummedArea<std::uint32_t> wrapped = summed_area<std::uint32_t>(t.pass, map, options);
    std::vector<std::int64_t> values;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) values.push_back(std::llrint(static_cast<double>(map.load(x, y).x) * 0x1p30));
    PassCounters counters;
    std::int64_t wrong = 0;
    std::vector<std::int64_t> column(static_cast<size_t>(width));
    for (int y0 = 0; y0 < height; ++y0) {
        std::fill(column.begin(), column.end(), 0);
        for (int y1 = y0; y1 < height; ++y1) {
            for (int x = 0; x < width; ++x)
                column[static_cast<size_t>(x)] += values[static_cast<size_t>(y1 * width + x)];
            for (int x0 = 0; x0 < width; ++x0) {
                std::int64_t brute = 0;
                for (int x1 = x0; x1 < width; ++x1) {
                    brute += column[static_cast<size_t>(x1)];
                    wrong += box_sum(exact, {x0, y0}, {x1, y1}, counters).x != brute;
                    wrong += box_sum(wrapped, {x0, y0}, {x1, y1}, counters).x != static_cast<std::uint32_t>(brute);
                }
            }
        }
    }
    CHECK(wrong == 0);
}

TEST_CASE("a summed area emulated in fp32 keeps its error bound") {
    TestPass t;
    const int side = 257;
    const Target map = random_target(Format::R32F, side, side, 8);
    const SummedArea<float> emulated = summed_area<float>(t.pass, map);
    const SummedArea<double> truth = summed_area<double>(t.pass, map);
    // A sum of recursive doubling passes 2·9 roundings, each of relative error 2^−24, of non-negative terms.
    bool bounded = true, rounded = false;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const double error = std::abs(static_cast<double>(emulated.sum(x, y, 0)) - truth.sum(x, y, 0));
            bounded = bounded && error <= truth.sum(x, y, 0) * (19 * 0x1p-24);
            rounded = rounded || error > 0;
        }
    CHECK(bounded);
    CHECK(rounded);
    // A box has the error of its four corners; with the mean subtracted, less.
    PassCounters counters;
    const auto error_of = [&](const SummedArea<float>& table) {
        double worst = 0;
        for (int i = 0; i + 8 < side; ++i) {
            const dvec2 low(i, i + 0.5), high(i + 7.25, i + 8.0);
            worst = std::max(worst,
                             std::abs(box_mean(table, low, high, counters).x - box_mean(truth, low, high, counters).x));
        }
        return worst;
    };
    const double plain = error_of(emulated), centred = error_of(summed_area<float>(t.pass, map, {.offset = 0.5f}));
    CAPTURE(plain, centred);
    CHECK(plain <= 8 * truth.sum(side - 1, side - 1, 0) * (19 * 0x1p-24) / (7.25 * 7.5));
    CHECK(centred < plain);
}

TEST_CASE("recursive doubling adds in the order of the passes") {
    TestPass t;
    Target map(Format::R32F, 4, 1);
    const float values[] = {0x1p24f, 1.0f, 1.0f, 1.0f};
    for (int x = 0; x < 4; ++x) map.store(x, 0, 0, vec4(values[x]));
    const SummedArea<float> table = summed_area<float>(t.pass, map);
    CHECK(table.sum(1, 0, 0) == 0x1p24f);        // 2^24 + 1, a tie, to even
    CHECK(table.sum(3, 0, 0) == 0x1p24f + 2.0f); // (2^24 + 1) + (1 + 1)
    CHECK(t.pass.counters().draws == 2);
    CHECK(t.pass.counters().texels_fetched == (4 + 3) + (4 + 2));
    CHECK(t.pass.counters().bytes_written == 2 * 4 * 4);
}

TEST_CASE("box means take continuous extents and are exact for the piecewise constant map") {
    TestPass t;
    const std::uint32_t seed = 77;
    CAPTURE(seed);
    const Target map = random_target(Format::RGBA32F, 23, 17, seed);
    const SummedAreaOptions options = {.offset = 0.25f};
    const SummedArea<double> in_double = summed_area<double>(t.pass, map, options);
    const SummedArea<std::int64_t> in_int64 = summed_area<std::int64_t>(t.pass, map, {.fraction_bits = 30});
    const SummedArea<std::uint32_t> in_uint32 = summed_area<std::uint32_t>(t.pass, map, {.fraction_bits = 23});
    const SummedArea<float> in_float = summed_area<float>(t.pass, map, options);
    PassCounters counters;
    const auto unit = [&](int i, int c) { return static_cast<double>(random_unit(i, 99, c, seed)); };
    for (int i = 0; i < 300; ++i) {
        dvec2 low(unit(i, 0) * 23, unit(i, 1) * 17);
        dvec2 high(unit(i, 2) * 23, unit(i, 3) * 17);
        if (i % 3 == 0) low = glm::floor(low), high = glm::ceil(high); // corners on texel borders
        if (low.x > high.x) std::swap(low.x, high.x);
        if (low.y > high.y) std::swap(low.y, high.y);
        if (high.x - low.x < 0.1 || high.y - low.y < 0.1) continue;
        for (int c = 0; c < 4; ++c) {
            const double mean = brute_mean(map, low, high, c);
            const double tolerance = 1e-3 / ((high.x - low.x) * (high.y - low.y));
            const bool good = std::abs(box_mean(in_double, low, high, counters)[c] - mean) < 1e-11 &&
                              std::abs(box_mean(in_int64, low, high, counters)[c] - mean) < 1e-9 &&
                              std::abs(box_mean(in_uint32, low, high, counters)[c] - mean) < 1e-6 &&
                              std::abs(box_mean(in_float, low, high, counters)[c] - mean) < tolerance;
            if (!good) FAIL("box " << i << " channel " << c);
        }
    }
}

TEST_CASE("boxes that leave the map are cut off, and empty ones mean the nearest texel") {
    TestPass t;
    const Target map = random_target(Format::RG32F, 8, 6, 3);
    const SummedArea<double> table = summed_area<double>(t.pass, map);
    PassCounters counters;
    const auto mean = [&](dvec2 low, dvec2 high) { return box_mean(table, low, high, counters).y; };
    const auto value = [&](int x, int y) { return Approx(static_cast<double>(map.load(x, y).y)); };
    CHECK(mean({-4, -4}, {1, 1}) == value(0, 0));
    CHECK(mean({7, 5}, {70, 50}) == value(7, 5));
    CHECK(mean({3.5, 2.5}, {3.5, 2.5}) == value(3, 2));
    CHECK(mean({-9, 2}, {-7, 3}) == value(0, 2));
    CHECK(mean({8, 2}, {9, 3}) == value(7, 2));
    CHECK(mean({-1, -1}, {9, 9}) == Approx(brute_mean(map, {0, 0}, {8, 6}, 1)));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(mean({nan, nan}, {nan, nan}) == value(0, 0));
    counters = {};
    mean({2.5, 2.5}, {4.5, 4.5});
    CHECK(counters.texels_fetched == 16);
    CHECK(counters.bytes_read == 16 * 16);
}

TEST_CASE("fixed point clamps, and passes over NaN") {
    TestPass t;
    Target map(Format::R32F, 3, 1);
    map.store(0, 0, 0, vec4(infinity));
    map.store(1, 0, 0, vec4(std::numeric_limits<float>::quiet_NaN()));
    map.store(2, 0, 0, vec4(-0.5f));
    const SummedArea<std::int64_t> exact = summed_area<std::int64_t>(t.pass, map, {.fraction_bits = 8});
    CHECK(exact.sum(0, 0, 0) == std::int64_t{1} << 32);
    CHECK(exact.sum(1, 0, 0) == std::int64_t{1} << 32);
    CHECK(exact.sum(2, 0, 0) == (std::int64_t{1} << 32) - 128);
    CHECK(summed_area<std::uint32_t>(t.pass, map, {.fraction_bits = 8}).sum(2, 0, 0) == 0xffffffffu);
}

TEST_CASE("summed areas have the same bits for any number of threads, and count their memory") {
    const Target map = random_target(Format::RGBA32F, 143, 71, 3);
    const auto table = [&](auto kind) {
        check_threads(
            [&] {
                TestPass t;
                return summed_area<decltype(kind)>(t.pass, map).sums;
            },
            [](const auto& a, const auto& b) { return same_bits(a, b); });
    };
    table(0.0f);
    table(0.0);
    table(std::int64_t{0});
    TestPass t;
    {
        const SummedArea<float> kept = summed_area<float>(t.pass, map, {.meter = t.log.memory});
        CHECK(t.log.memory->peak() == 2 * map.bytes());
    }
    t.log.memory->allocate(1);
    CHECK(t.log.memory->peak() == 2 * map.bytes()); // all was released
}
