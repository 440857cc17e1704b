// Closed forms of revectorization on masks. [Macedo 2018, 5.1 and section 4, A3 to A14]

#include <catch2/catch.hpp>

#include <random>

#include "tests/techniques/masks.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

constexpr Variant revectorized[] = {Variant::Conservative, Variant::Nonconservative, Variant::Filtered};

int floor_divide(int a, int n) { return (a >= 0 ? a : a - n + 1) / n; }

// One of the mask's eight images under mirroring and transposition: where its point (x, y) comes from.
struct Orientation {
    bool mirror_x, mirror_y, transpose;
    ivec2 texel(int i, int j) const {
        if (transpose) std::swap(i, j);
        return {mirror_x ? -1 - i : i, mirror_y ? -1 - j : j};
    }
    vec2 point(vec2 p) const { // the image's point of the mask's point p
        p = {mirror_x ? -p.x : p.x, mirror_y ? -p.y : p.y};
        return transpose ? vec2(p.y, p.x) : p;
    }
};

// What the stairs of slope 1/n must become: shadow below a line, or a ramp beside it.
float stairs_expected(Variant variant, int n, vec2 p) {
    const float height = p.y - p.x / static_cast<float>(n);
    if (variant == Variant::Conservative) return height < 0 ? 0.0f : 1.0f;
    if (variant == Variant::Nonconservative) return height < -0.5f ? 0.0f : 1.0f;
    return std::clamp(1.0f + height, 0.0f, 1.0f);
}

// Too near to a line or to a texel's edge for float32 to tell the sides apart.
bool on_a_line(int n, vec2 p) {
    const float twice = 2.0f * (p.y - p.x / static_cast<float>(n));
    const auto near_whole = [](float value) { return std::abs(value - std::round(value)) < 1e-4f; };
    return near_whole(twice) || near_whole(p.x) || near_whole(p.y);
}

} // namespace

TEST_CASE("stairs of slope 1 over n become the very line, in every orientation and reading") {
    const unsigned seed = 20181;
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> u(-40.0f, 40.0f), v(-2.0f, 2.0f);
    const int n = GENERATE(1, 2, 3, 5, 8, 16);
    const int mirrored = GENERATE(range(0, 8));
    const Orientation image = {(mirrored & 1) != 0, (mirrored & 2) != 0, (mirrored & 4) != 0};
    const MaskSource stairs{[&](int i, int j) {
        const ivec2 t = image.texel(i, j);
        return t.y < floor_divide(t.x, n);
    }};
    int wrong = 0, tried = 0;
    for (int k = 0; k < 400; ++k) {
        const float x = u(random);
        const vec2 p(x, x / static_cast<float>(n) + v(random));
        if (on_a_line(n, p)) continue;
        for (const Variant variant : revectorized)
            for (const Continuation reading : {Continuation::Any, Continuation::Share, Continuation::Perp})
                for (const bool reject : {false, true}) {
                    const SilhouetteRules rules = {.continuation = reading, .reject_isolated_end = reject};
                    const float seen = visibility_at(stairs, variant, image.point(p), {.rules = rules});
                    wrong += std::abs(seen - stairs_expected(variant, n, p)) > 1e-5f;
                    ++tried;
                }
    }
    CHECK(tried > 5000);
    CHECK(wrong == 0);
}

TEST_CASE("edges along the map's axes and lines of one or two texels stay as they are") {
    const auto check = [](const auto& shadow) {
        const MaskSource mask{shadow};
        int differ = 0;
        for (const Variant variant : revectorized)
            for (float y = -5.03f; y < 5; y += 0.093f)
                for (float x = -5.03f; x < 5; x += 0.093f)
                    differ += visibility_at(mask, variant, {x, y}) != visibility_at(mask, Variant::Plain, {x, y});
        CHECK(differ == 0);
    };
    check([](int, int j) { return j < 0; });
    check([](int i, int) { return i >= 0; });
    for (const int width : {1, 2}) {
        check([=](int i, int) { return i >= 0 && i < width; });
        check([=](int i, int) { return i < 0 || i >= width; });
        check([=](int, int j) { return j >= 0 && j < width; });
    }
}

TEST_CASE("corners of a square of 40 texels are cut and filled by the closed forms") {
    const auto square = [](int i, int j) { return i >= 0 && i < 40 && j >= 0 && j < 40; };
    const MaskSource shadow{square};
    const MaskSource hole{[&](int i, int j) { return !square(i, j); }};
    const auto corner_of = [](const auto& mask, Variant variant) {
        const double all = shadow_area(mask, variant, {-20, -20}, {60, 60});
        return (all - shadow_area(mask, Variant::Plain, {-20, -20}, {60, 60})) / 4;
    };
    CHECK(corner_of(shadow, Variant::Conservative) == 0.0);
    CHECK(corner_of(shadow, Variant::Nonconservative) == Approx(-4.0625).margin(0.01));
    CHECK(corner_of(shadow, Variant::Filtered) == Approx(-5.3320).margin(0.01));
    CHECK(corner_of(hole, Variant::Conservative) == Approx(15.0625).margin(0.01));
    CHECK(corner_of(hole, Variant::Nonconservative) == Approx(4.0625).margin(0.01));
    CHECK(corner_of(hole, Variant::Filtered) == Approx(5.3320).margin(0.01));
}

TEST_CASE("notches, bumps and long steps change areas by the closed forms") {
    for (const int w : {1, 3, 8, 16}) {
        INFO("width " << w);
        const MaskSource notch{[&](int i, int j) { return j < 0 || (j == 0 && (i < 0 || i >= w)); }};
        const auto lit = [&](Variant variant) { return w - shadow_area(notch, variant, {0, 0}, {w, 1}); };
        CHECK(lit(Variant::Conservative) == Approx(w / 2.0).margin(0.02 * w));
        CHECK(lit(Variant::Nonconservative) == Approx(7 * w / 8.0).margin(0.02 * w));
        CHECK(lit(Variant::Filtered) == Approx(w / 2.0).margin(0.02 * w));

        const MaskSource bump{[&](int i, int j) { return j < 0 || (j == 0 && i >= 0 && i < w); }};
        const auto dark = [&](Variant variant) { return shadow_area(bump, variant, {-20, 0}, {w + 20, 3}); };
        CHECK(dark(Variant::Conservative) == Approx(w + 16.0).margin(0.02 * w));
        CHECK(dark(Variant::Nonconservative) == Approx(7 * w / 8.0 + 4).margin(0.02 * w));
        CHECK(dark(Variant::Filtered) == Approx(w / 2.0 + 16.0 / 3).margin(0.02 * w));
    }
    for (const int n : {17, 20, 24, 32, 40}) {
        INFO("step of " << n);
        const MaskSource stairs{[&](int i, int j) { return j < floor_divide(i, n); }};
        const auto grown = [&](Variant variant) { // one step of an endless stair
            return shadow_area(stairs, variant, {0, -3}, {n, 4}) - shadow_area(stairs, Variant::Plain, {0, -3}, {n, 4});
        };
        CHECK(grown(Variant::Conservative) == Approx(8.0).margin(0.02));
        CHECK(grown(Variant::Nonconservative) == Approx(0.0).margin(0.02));
        CHECK(grown(Variant::Filtered) == Approx(0.0).margin(0.02));
    }
}

TEST_CASE("isolated texels and thin diagonals vanish where they are flipped") {
    const MaskSource speck{[](int i, int j) { return i == 0 && j == 0; }};
    const MaskSource hole{[](int i, int j) { return i != 0 || j != 0; }};
    const auto area = [](const auto& mask, Variant variant, bool flip, bool fill = false) {
        return shadow_area(
            mask, variant, {-2, -2}, {3, 3},
            {.rules = default_rules(variant), .flip_isolated = flip, .conservative = {.fill_gaps = fill}});
    };
    CHECK(area(speck, Variant::Conservative, true) == 1.0);
    CHECK(area(speck, Variant::Nonconservative, true) == 0.0);
    CHECK(area(speck, Variant::Nonconservative, false) == Approx(7.0 / 8).margin(0.01));
    CHECK(area(speck, Variant::Filtered, false) == 0.0);
    CHECK(25 - area(hole, Variant::Conservative, true) == Approx(0.5).margin(0.02));
    CHECK(25 - area(hole, Variant::Conservative, true, true) == 0.0);
    CHECK(25 - area(hole, Variant::Nonconservative, true) == 0.0);
    CHECK(25 - area(hole, Variant::Nonconservative, false) == Approx(7.0 / 8).margin(0.01));
    CHECK(25 - area(hole, Variant::Filtered, false) == 0.0);

    const MaskSource diagonal{[](int i, int j) { return i == j; }};
    CHECK(shadow_area(diagonal, Variant::Plain, {-8, -8}, {8, 8}) == 16.0);
    CHECK(shadow_area(diagonal, Variant::Nonconservative, {-8, -8}, {8, 8}) == 0.0);
    CHECK(shadow_area(diagonal, Variant::Filtered, {-8, -8}, {8, 8}) == 0.0);
}

TEST_CASE("runs are walked for 16 texels and no further") {
    const auto rules = default_rules(Variant::Nonconservative);
    const auto distances = [&](int n, float x) { // in row 0 of the step from 0 to n; the lit side's run ends at n
        const MaskSource stairs{[=](int i, int j) { return j < floor_divide(i, n); }};
        const Silhouette silhouette(stairs, rules);
        const SilhouettePoint p = silhouette.point({{x, 0.5f}, 0.75f, 0.0f});
        REQUIRE(p.lit);
        return silhouette.distances(p, silhouette.discontinuities(p.place, p.depth, true));
    };
    CHECK(distances(16, 0.25f).x_plus == 15.75f); // the farthest texel finds the end at offset 16
    CHECK(distances(16, 0.25f).x_minus == -0.25f);
    CHECK(relative_position(distances(16, 0.25f), true, 16).x == 15.75f / 16);
    CHECK(distances(17, 0.25f).x_plus == -16.75f); // here it would be at 17
    CHECK(relative_position(distances(17, 0.25f), true, 16).x == 0.0f);
    CHECK(distances(17, 1.25f).x_plus == 15.75f);
    CHECK(relative_position(distances(17, 1.25f), true, 16).x == 15.75f / 16); // of 17, but divided by 16
}

TEST_CASE("shapes and relative positions follow their table") {
    CHECK(run_shape(3, -1) == 1);
    CHECK(run_shape(2, 6) == -2);
    CHECK(run_shape(-2, -6) == 0);
    CHECK(run_shape(0, -1) == 1); // exactly zero is neither sign
    const auto hard = [](float a, float b, bool lit) { return relative_position({a, b, -1, -1}, lit, 16).x; };
    const auto filtered_position = [](float a, float b) { return signed_relative_position({a, b, -1, -1}, 16).x; };
    CHECK(hard(3, -1, true) == 0.75f);
    CHECK(hard(-1, 3, false) == 0.75f);
    CHECK(hard(2, 6, true) == 0.5f);
    CHECK(hard(2, 6, false) == -0.5f);
    CHECK(hard(-2, -6, true) == 0.0f);
    CHECK(filtered_position(2, 6) == -1.0f);
    CHECK(filtered_position(3, -1) == 0.75f);
    CHECK(filtered_position(-2, -6) == 0.0f);
    // As printed, (4.1) has no absolute value: the sign differs where both ends are closed, and nowhere else.
    for (float a = -8.25f; a <= 8; a += 0.5f)
        for (float b = -8.25f; b <= 8; b += 0.5f) {
            const float shape = run_shape(a, b);
            const float printed = shape * std::max(shape * a, shape * b) / run_length(a, b, 16);
            CHECK((printed == filtered_position(a, b)) == (shape != -2));
            CHECK(std::abs(printed) == std::abs(filtered_position(a, b)));
        }
}

TEST_CASE("the merged visibility function is its two cases") {
    for (int i = -4; i <= 4; ++i)
        for (int j = -4; j <= 4; ++j) {
            const vec2 r = vec2(static_cast<float>(i), static_cast<float>(j)) / 4.0f;
            const float sum = std::abs(r.x) + std::abs(r.y);
            const bool umbra = !(r.x * r.y == 0 || sum > 0.5f); // (3.7)
            CHECK(nonconservative_visibility(r, false) == umbra);
            if (i < 0 || j < 0) continue;                          // a lit point's r is not negative
            const bool lit = !(r.x * r.y > 0 && r.x + r.y < 0.5f); // (3.8)
            CHECK(nonconservative_visibility(r, true) == lit);
        }
    CHECK(nonconservative_visibility({0.25f, 0.25f}, true));
    CHECK(nonconservative_visibility({0.25f, 0.25f}, false));
}

TEST_CASE("dense detail turns over: a checkerboard's texels take their neighbours' state") {
    const MaskSource board{[](int i, int j) { return ((i + j) & 1) != 0; }};
    int same = 0, darker = 0;
    for (float y = 0.03f; y < 4; y += 0.11f)
        for (float x = 0.03f; x < 4; x += 0.11f) {
            const float plain = visibility_at(board, Variant::Plain, {x, y});
            same += visibility_at(board, Variant::Nonconservative, {x, y}) == plain;
            darker += visibility_at(board, Variant::Conservative, {x, y}) < plain;
        }
    CHECK(same == 0);
    CHECK(darker > 0);
}

TEST_CASE("a run that leaves the map ends there as the border says") {
    // Shadow below row 0 as far as column 5; the border begins at column 6.
    const auto x_plus_distance = [](float border) {
        struct Source {
            float border;
            float behind(ivec2 t, float depth) const {
                if (t.x >= 6) return border;
                return depth - (t.y < 0 ? 0.25f : 0.75f);
            }
        };
        const Source source{border};
        const SilhouetteRules rules = default_rules(Variant::Nonconservative);
        const Silhouette silhouette(source, rules);
        const SilhouettePoint p = silhouette.point({{2.25f, 0.5f}, 0.75f, 0.0f});
        return silhouette.distances(p, silhouette.discontinuities(p.place, p.depth, p.lit)).x_plus;
    };
    CHECK(x_plus_distance(infinity) == 3.75f);   // shadow outside closes the run
    CHECK(x_plus_distance(-infinity) == -3.75f); // light outside lets it fade out
}
