#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.h"
#include "raytrace/pattern.h"

using namespace gnomon;

namespace {

std::vector<vec2> points_of(Pattern pattern, std::uint32_t pixel, std::uint32_t seed, size_t count) {
    std::vector<vec2> points(count);
    fill_pattern(pattern, pixel, seed, points);
    return points;
}

// Whether each of the columns × rows cells holds exactly one of the points.
bool one_in_each_cell(const std::vector<vec2>& points, int columns, int rows) {
    std::vector<int> hits(static_cast<size_t>(columns * rows));
    for (const vec2 p : points) {
        const int column = static_cast<int>(p.x * static_cast<float>(columns));
        const int row = static_cast<int>(p.y * static_cast<float>(rows));
        ++hits[static_cast<size_t>(row * columns + column)];
    }
    return std::all_of(hits.begin(), hits.end(), [](int n) { return n == 1; });
}

bool left_then_lower(vec2 a, vec2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }

constexpr Pattern all_patterns[] = {Pattern::Sobol,  Pattern::Stratified, Pattern::Grid,
                                    Pattern::Random, Pattern::Halton,     Pattern::Poisson};

} // namespace

TEST_CASE("sobol points fill every elementary interval once", "[raytrace][pattern]") {
    for (const std::uint32_t pixel : {0u, 1u, 77u, 2073599u})
        for (int bits = 0; bits <= 12; ++bits) {
            const std::vector<vec2> points = points_of(Pattern::Sobol, pixel, 5, size_t{1} << bits);
            for (int columns = 0; columns <= bits; ++columns) {
                INFO("pixel " << pixel << ", 2^" << bits << " points, 2^" << columns << " columns");
                REQUIRE(one_in_each_cell(points, 1 << columns, 1 << (bits - columns)));
            }
        }
}

TEST_CASE("every aligned block of a sobol sequence is a net as well", "[raytrace][pattern]") {
    const std::vector<vec2> points = points_of(Pattern::Sobol, 3, 9, 1024);
    for (size_t first = 0; first < points.size(); first += 64) {
        const std::vector<vec2> block(points.begin() + static_cast<std::ptrdiff_t>(first),
                                      points.begin() + static_cast<std::ptrdiff_t>(first + 64));
        for (int columns = 1; columns <= 64; columns *= 2) REQUIRE(one_in_each_cell(block, columns, 64 / columns));
    }
}

TEST_CASE("the points of a sequence are the first of more", "[raytrace][pattern]") {
    for (const Pattern pattern : all_patterns) {
        if (!is_sequence(pattern)) continue;
        INFO("pattern " << static_cast<int>(pattern));
        const std::vector<vec2> many = points_of(pattern, 42, 1, 65536);
        for (const size_t count : std::initializer_list<size_t>{1, 2, 100, 243, 244, 256, 1000, 1024}) {
            const std::vector<vec2> few = points_of(pattern, 42, 1, count);
            CHECK(std::equal(few.begin(), few.end(), many.begin()));
        }
        const PreparedPattern rest = prepare_pattern(pattern, 1024, SampleOrder::Packed, 256);
        std::vector<float> u(rest.size()), v(rest.size());
        fill_pattern(rest, 42, 1, u, v);
        REQUIRE(rest.size() == 768);
        for (size_t k = 0; k < rest.size(); ++k) CHECK(vec2(u[k], v[k]) == many[rest.index[k]]);
        CHECK(*std::min_element(rest.index.begin(), rest.index.end()) == 256);
    }
    CHECK_THROWS_AS(prepare_pattern(Pattern::Sobol, 64, SampleOrder::Packed, 64), UsageError);
}

TEST_CASE("halton points fill every interval of halves and thirds once", "[raytrace][pattern]") {
    for (const std::uint32_t pixel : {0u, 7u, 123456u})
        for (const auto& [columns, rows] : {std::pair(1, 1), {2, 3}, {4, 3}, {8, 9}, {16, 27}, {64, 243}, {256, 3}})
            CHECK(one_in_each_cell(points_of(Pattern::Halton, pixel, 4, size_t(columns * rows)), columns, rows));
}

// Rows of equal cells: each of N cells has area 1/N and one point in it, for any N.
TEST_CASE("grid and stratified divide the square into equal cells", "[raytrace][pattern]") {
    for (const int count : {3, 7, 11, 97, 1000, 1021})
        for (const Pattern pattern : {Pattern::Grid, Pattern::Stratified}) {
            INFO(count << " points, pattern " << static_cast<int>(pattern));
            const std::vector<vec2> points = points_of(pattern, 5, 2, size_t(count));
            const int rows = static_cast<int>(std::lround(std::sqrt(count)));
            int misplaced = 0;
            for (int i = 0, row = 0; i < count; ++i) {
                while ((row + 1) * count / rows <= i) ++row;
                const int start = row * count / rows, columns = (row + 1) * count / rows - start;
                const vec2 low(float(i - start) / float(columns), float(start) / float(count));
                const vec2 high(float(i - start + 1) / float(columns), float(start + columns) / float(count));
                const vec2 p = points[size_t(i)];
                misplaced += p.x < low.x - 1e-6f || p.x > high.x + 1e-6f || p.y < low.y - 1e-6f || p.y > high.y + 1e-6f;
            }
            CHECK(misplaced == 0);
        }
}

// No two of N best candidates are nearer than half the distance of a hexagonal packing, √(2/(√3·N)); independent points
// have far nearer pairs.
TEST_CASE("poisson points keep apart, around the edges too", "[raytrace][pattern]") {
    for (const size_t count : std::initializer_list<size_t>{2, 16, 100, 256, 1024}) {
        const std::vector<vec2> points = points_of(Pattern::Poisson, 9, 1, count);
        float nearest = 1;
        for (size_t i = 0; i < count; ++i)
            for (size_t j = 0; j < i; ++j) {
                vec2 d = glm::abs(points[i] - points[j]);
                d = glm::min(d, 1.0f - d);
                nearest = std::min(nearest, glm::length(d));
            }
        INFO(count << " points, nearest pair " << nearest);
        CHECK(nearest > 0.5f * std::sqrt(2.0f / (std::sqrt(3.0f) * float(count))));
    }
}

TEST_CASE("points lie in the half-open unit square and depend on pixel and seed", "[raytrace][pattern]") {
    for (const Pattern pattern : all_patterns) {
        INFO("pattern " << static_cast<int>(pattern));
        for (const size_t count : std::initializer_list<size_t>{1, 2, 3, 4, 12, 100, 1024}) {
            const std::vector<vec2> points = points_of(pattern, 6, 0, count);
            for (const vec2 p : points) {
                CHECK((p.x >= 0.0f && p.x < 1.0f));
                CHECK((p.y >= 0.0f && p.y < 1.0f));
            }
            if (pattern == Pattern::Grid) {
                CHECK(points == points_of(pattern, 7, 1, count));
            } else {
                CHECK(points != points_of(pattern, 7, 0, count));
                CHECK(points != points_of(pattern, 6, 1, count));
                CHECK(points == points_of(pattern, 6, 0, count));
            }
        }
    }
}

TEST_CASE("scrambles of neighbouring pixels are independent", "[raytrace][pattern]") {
    // The first point of 4096 pixels: uniform in each of 8×8 cells (63 degrees of freedom: chi² < 114.8 at 1 in 10⁴),
    // in each coordinate uncorrelated with that of the pixel to the right (|r| < 3.9 / √4096 at 1 in 10⁴).
    for (const Pattern pattern : all_patterns) {
        if (pattern == Pattern::Grid) continue;
        INFO("pattern " << static_cast<int>(pattern));
        std::vector<double> cells(64);
        double products = 0;
        vec2 before(0.5f);
        for (std::uint32_t pixel = 0; pixel < 4096; ++pixel) {
            const vec2 p = points_of(pattern, pixel, 0, 1)[0];
            cells[static_cast<size_t>(p.x * 8) + 8 * static_cast<size_t>(p.y * 8)] += 1;
            products += 12.0 * double(p.x - 0.5f) * double(before.x - 0.5f);
            before = p;
        }
        double chi2 = 0;
        for (const double n : cells) chi2 += (n - 64.0) * (n - 64.0) / 64.0;
        CHECK(chi2 < 114.8);
        CHECK(std::abs(products / 4096) < 3.9 / 64);
    }
}

TEST_CASE("grid and stratified use the squarest grid of the count", "[raytrace][pattern]") {
    for (const Pattern pattern : {Pattern::Grid, Pattern::Stratified}) {
        CHECK(one_in_each_cell(points_of(pattern, 1, 0, 1024), 32, 32));
        CHECK(one_in_each_cell(points_of(pattern, 1, 0, 12), 4, 3));
        CHECK(one_in_each_cell(points_of(pattern, 1, 0, 2), 2, 1));
    }
    const std::vector<vec2> points = points_of(Pattern::Grid, 0, 0, 4);
    CHECK(points == std::vector<vec2>{{0.25f, 0.25f}, {0.75f, 0.25f}, {0.25f, 0.75f}, {0.75f, 0.75f}});
}

TEST_CASE("packing reorders the points and changes none", "[raytrace][pattern]") {
    for (const Pattern pattern : all_patterns)
        for (const int count : {1, 12, 100, 256, 1024}) {
            INFO("pattern " << static_cast<int>(pattern) << ", " << count << " points");
            const PreparedPattern packed = prepare_pattern(pattern, count, SampleOrder::Packed);
            std::vector<float> u(packed.size()), v(packed.size());
            fill_pattern(packed, 11, 3, u, v);
            std::vector<vec2> reordered(packed.size());
            for (size_t i = 0; i < u.size(); ++i) reordered[i] = {u[i], v[i]};
            if (pattern == Pattern::Sobol && count == 1024)
                for (size_t first = 0; first < u.size(); first += 16) {
                    const auto [low, high] = std::minmax_element(&u[first], &u[first] + 16);
                    CHECK(*high - *low <= 0.125f); // a packet stays within one of 8×8 cells of the light
                }
            std::vector<vec2> sequence = points_of(pattern, 11, 3, packed.size());
            std::sort(reordered.begin(), reordered.end(), left_then_lower);
            std::sort(sequence.begin(), sequence.end(), left_then_lower);
            CHECK(reordered == sequence);
        }
}
