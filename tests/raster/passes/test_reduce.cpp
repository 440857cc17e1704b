#include "raster/passes/reduce.h"
#include "tests/raster/passes/images.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

const float not_a_number = std::numeric_limits<float>::quiet_NaN();

std::vector<float> random_floats(size_t count, std::uint32_t seed) {
    std::vector<float> values;
    for (size_t i = 0; i < count; ++i) values.push_back(random_unit(static_cast<int>(i), 0, 0, seed) - 0.25f);
    return values;
}

template <class T> std::vector<T> random_integers(size_t count, std::uint32_t seed) {
    std::vector<T> values;
    for (size_t i = 0; i < count; ++i) values.push_back(static_cast<T>(hash(static_cast<std::uint32_t>(i), seed)));
    return values;
}

} // namespace

TEST_CASE("minimum and maximum are those of a plain loop") {
    const auto count = GENERATE(size_t{1}, size_t{7}, size_t{4096}, size_t{4097}, size_t{100003});
    const std::uint32_t seed = 3;
    CAPTURE(count, seed);
    TestPass t;
    std::vector<float> values = random_floats(count, seed);
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    CHECK(reduce_min_max(t.pass, values) == MinMax{*low, *high});
    CHECK(reduce_min_max(t.pass, std::span(values).subspan(count)) == MinMax{});
}

TEST_CASE("NaN is passed over by minimum and maximum, and kept by sums") {
    TestPass t;
    for (size_t place = 0; place < 11; ++place) {
        std::vector<float> values = {3, 1, 4, 1, 5, 9, 2, 6, 5, 3, 5};
        values[place] = not_a_number;
        const MinMax bounds = reduce_min_max(t.pass, values);
        CHECK(bounds.minimum == 1.0f);
        CHECK(bounds.maximum == (place == 5 ? 6.0f : 9.0f));
        CHECK(std::isnan(reduce_sum(t.pass, values)));
    }
    CHECK(reduce_min_max(t.pass, std::vector<float>(20, not_a_number)) == MinMax{});
}

TEST_CASE("the range of a target is that of its first channel") {
    TestPass t;
    Target depth(Format::D24, 300, 21, 2);
    depth.clear_depth(t.pass, 1.0f);
    depth.store_key(299, 20, 1, depth_key(Format::D24, 0.5));
    CHECK(reduce_min_max(t.pass, depth, 0) == MinMax{1.0f, 1.0f});
    CHECK(reduce_min_max(t.pass, depth, 1) == MinMax{depth.depth(299, 20, 1), 1.0f});
    const Target colours = random_target(Format::RGBA32F, 33, 9, 4);
    MinMax truth;
    for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 33; ++x) {
            truth.minimum = std::min(truth.minimum, colours.load(x, y).x);
            truth.maximum = std::max(truth.maximum, colours.load(x, y).x);
        }
    CHECK(reduce_min_max(t.pass, colours) == truth);
}

TEST_CASE("sums and counts") {
    TestPass t;
    const std::vector<float> values = random_floats(50021, 8);
    double truth = 0;
    for (const float value : values) truth += static_cast<double>(value);
    CHECK(reduce_sum(t.pass, values) == Approx(truth).epsilon(1e-13));
    // The stated order: 2^53 and 1 meet in the first lane, so the 1 is lost; a 1 in another lane is not, nor its twin.
    std::vector<double> ordered(4096, 0.0);
    ordered[0] = 0x1p53;
    ordered[8] = 1.0;
    ordered[1] = ordered[5] = 1.0;
    CHECK(reduce_sum(t.pass, ordered) == 0x1p53 + 2.0);

    const std::vector<std::int32_t> integers = random_integers<std::int32_t>(9999, 5);
    std::int64_t sum = 0, count = 0;
    for (const std::int32_t value : integers) sum += value;
    CHECK(reduce_sum(t.pass, integers) == sum);
    CHECK(reduce_sum(t.pass, std::vector<std::uint32_t>(5000, 0xffffffffu)) == 5000 * std::int64_t{0xffffffffu});
    const Image<std::uint8_t> mask = random_mask(99, 101, 0.3f, 6);
    for (const std::uint8_t value : mask.values()) count += value;
    CHECK(reduce_count(t.pass, mask.values()) == count);
    CHECK(reduce_sum(t.pass, mask.values()) == count);
    CHECK(reduce_sum(t.pass, std::span<const float>()) == 0.0);
}

TEST_CASE("a reduction takes any map and counts its fetches") {
    TestPass t;
    const std::vector<float> values = random_floats(10000, 2);
    // The largest value below a half, with its index.
    using Found = std::pair<float, size_t>;
    const Found found = reduce<Found>(
        t.pass, values.size(), sizeof(float), {-infinity, 0},
        [&](size_t i) {
            return values[i] < 0.5f ? Found{values[i], i} : Found{-infinity, i};
        },
        [](Found a, Found b) { return b.first > a.first ? b : a; });
    CHECK(values[found.second] == found.first);
    CHECK(std::none_of(values.begin(), values.end(), [&](float v) { return v < 0.5f && v > found.first; }));
    CHECK(t.pass.counters().draws == 1);
    CHECK(t.pass.counters().texels_fetched == 10000 + 2 * 2); // three leaves, two nodes above
    CHECK(t.pass.counters().bytes_written == 5 * static_cast<std::int64_t>(sizeof(Found)));
}

TEST_CASE("prefix sums of integers are those of a plain loop") {
    const auto count = GENERATE(size_t{0}, size_t{1}, size_t{4096}, size_t{12289});
    CAPTURE(count);
    TestPass t;
    const std::vector<std::uint32_t> values = random_integers<std::uint32_t>(count, 7);
    std::vector<std::uint32_t> inclusive = values, exclusive = values;
    scan<std::uint32_t>(t.pass, inclusive, Scan::Inclusive);
    scan<std::uint32_t>(t.pass, exclusive, Scan::Exclusive);
    std::uint32_t sum = 0; // wraps around
    bool same = true;
    for (size_t i = 0; i < count; ++i) {
        same = same && exclusive[i] == sum;
        sum += values[i];
        same = same && inclusive[i] == sum;
    }
    CHECK(same);
}

TEST_CASE("prefix sums of rows and columns are transposes of each other") {
    TestPass t;
    const int width = 301, height = 77;
    const Scan kind = GENERATE(Scan::Inclusive, Scan::Exclusive);
    Image<float> rows(width, height), columns(height, width);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) rows(x, y) = columns(y, x) = random_unit(x, y, 0, 5);
    const float first = rows(0, 3), second = rows(1, 3), third = rows(2, 3);
    scan_rows(t.pass, rows, kind);
    scan_columns(t.pass, columns, kind);
    bool same = true;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) same = same && rows(x, y) == columns(y, x);
    CHECK(same);
    CHECK(rows(2, 3) == (kind == Scan::Inclusive ? (first + second) + third : first + second));
    CHECK(t.pass.counters().texels_fetched == 2 * width * height);
}

TEST_CASE("histograms clamp or drop outliers, drop NaN and close the last bin") {
    TestPass t;
    const std::vector<float> values = {-1.0f, 0.0f, 0.24f,    0.25f,     0.5f,        0.99f,
                                       1.0f,  1.5f, infinity, -infinity, not_a_number};
    HistogramRange range = {.bins = 4};
    CHECK(histogram(t.pass, values, range) == std::vector<std::int64_t>{4, 1, 1, 4});
    range.outliers = Outliers::Drop;
    CHECK(histogram(t.pass, values, range) == std::vector<std::int64_t>{2, 1, 1, 2});
    const std::vector<float> many = random_floats(200000, 9); // more than one partial histogram
    range = {.low = -0.25, .high = 0.75, .bins = 10, .outliers = Outliers::Drop};
    const std::vector<std::int64_t> counts = histogram(t.pass, many, range);
    std::int64_t total = 0;
    for (const std::int64_t count : counts) {
        CHECK(std::abs(count - 20000) < 6 * 134); // six standard deviations of a binomial
        total += count;
    }
    CHECK(total == 200000);
}

TEST_CASE("reductions and prefix sums have the same bits for any number of threads") {
    const std::vector<float> values = random_floats(123457, 11);
    check_threads(
        [&] {
            TestPass t;
            std::vector<float> scanned = values;
            scan<float>(t.pass, scanned, Scan::Inclusive);
            scanned.push_back(reduce_min_max(t.pass, values).minimum);
            return std::pair(scanned, reduce_sum(t.pass, values));
        },
        [](const auto& a, const auto& b) { return same_bits(a.first, b.first) && a.second == b.second; });
    Image<float> image(517, 203);
    std::copy_n(values.begin(), image.size(), image.values().begin());
    check_threads(
        [&] {
            TestPass t;
            Image<float> scanned = image;
            scan_columns(t.pass, scanned, Scan::Inclusive);
            scan_rows(t.pass, scanned, Scan::Exclusive);
            return scanned;
        },
        [](const auto& a, const auto& b) { return same_bits(a, b); });
}
