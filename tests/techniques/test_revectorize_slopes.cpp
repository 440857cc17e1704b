// Discontinuities, sloped receivers, contact, the engine's variant, and steps in float. [Macedo 2018, 5.1 and A13, A14]

#include <catch2/catch.hpp>

#include "raster/target.h"
#include "techniques/revectorize/discontinuity_code.h"
#include "tests/techniques/masks.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

// Stairs of slope 1/n on a receiver whose depth grows by `slope` a texel along u; the map holds it `bias` further away.
struct SlopedStairs {
    int n;
    float slope, bias;
    float receiver(float u) const { return 0.5f + slope * u; }
    float behind(ivec2 t, float depth) const {
        const int row = t.x >= 0 ? t.x / n : (t.x - n + 1) / n;
        return depth - (t.y < row ? 0.25f : receiver(static_cast<float>(t.x) + 0.5f) + bias);
    }
};

// Share of the lit points within a texel of the edge, over whole steps, that rbsm-cons gets wrong: its edge is v = u/n.
double wrong_share(const SlopedStairs& stairs, float eps) {
    const SilhouetteRules rules = default_rules(Variant::Conservative);
    int wrong = 0, lit = 0;
    const float n = static_cast<float>(stairs.n);
    for (float u = 0.03125f; u < 4 * n; u += 0.0625f)
        for (float height = -0.97f; height < 1; height += 0.0625f) {
            const vec2 at(u, u / n + height);
            const Revectorized result = conservative(stairs, rules, {at, stairs.receiver(u), eps});
            if (!result.lit) continue;
            ++lit;
            wrong += result.visibility != (height < 0 ? 0.0f : 1.0f);
        }
    return static_cast<double>(wrong) / lit;
}

} // namespace

TEST_CASE("discontinuities are those of the four neighbours, for every 3 by 3 pattern, and survive 8 bits") {
    Target texture(Format::RGBA8, 1, 1);
    for (int pattern = 0; pattern < 512; ++pattern) {
        const MaskSource mask{[&](int i, int j) { return (pattern >> ((j + 1) * 3 + (i + 1)) & 1) != 0; }};
        const auto rules = default_rules(Variant::Nonconservative);
        const Silhouette silhouette(mask, rules);
        const SilhouettePoint p = silhouette.point({{0.5f, 0.5f}, 0.75f, 0.0f});
        const auto dark = [&](int i, int j) { return mask.shadow(i, j); };
        unsigned expected = 0;
        if (dark(-1, 0) != dark(0, 0)) expected |= x_minus;
        if (dark(1, 0) != dark(0, 0)) expected |= x_plus;
        if (dark(0, -1) != dark(0, 0)) expected |= y_minus;
        if (dark(0, 1) != dark(0, 0)) expected |= y_plus;
        const unsigned sides = silhouette.discontinuities(p.place, p.depth, p.lit);
        REQUIRE(p.lit == !dark(0, 0));
        REQUIRE(sides == expected);
        texture.store(0, 0, 0, pack_discontinuities(sides, p.lit));
        REQUIRE(unpack_discontinuities(texture.load(0, 0)) == sides);
        REQUIRE((texture.load(0, 0).z > 0.5f) == !p.lit);
    }
}

TEST_CASE("sloped receivers end no run where epsilon covers their slope") {
    constexpr float eps = 2.5e-5f;
    for (const int n : {4, 8, 12})
        for (const float bias : {0.5f, 1.0f, 4.0f}) { // in slopes
            const float slope = 0.5f * eps;
            const SlopedStairs stairs = {n, slope, bias * slope};
            INFO("n " << n << ", bias " << bias);
            CHECK(wrong_share(stairs, eps) == 0.0);
            // Without the rule it fails for runs longer than bias/slope + ½ texels.
            CHECK(wrong_share(stairs, 0.0f) > 0.0);
        }
    // Where ε does not cover the slope the rule helps less and less.
    const auto kept = [&](int n, float slope) { // share of the errors without the rule that it leaves, bias slope/2
        const SlopedStairs stairs = {n, slope, 0.5f * slope};
        return wrong_share(stairs, eps) / wrong_share(stairs, 0.0f);
    };
    CHECK(kept(4, 0.9f * eps) > 0.0);
    CHECK(kept(4, 0.9f * eps) < 0.25);
    CHECK(kept(8, 1.2f * eps) < 0.6);
    CHECK(kept(8, 1.2f * eps) > kept(8, 0.9f * eps));
    CHECK(kept(12, 2.0f * eps) == Approx(1.0).margin(0.05));
}

TEST_CASE("a caster nearer than epsilon ends no run") {
    constexpr float eps = 2.5e-5f;
    const auto changed = [&](float gap) { // points that rbsm-nonc sees otherwise than sm
        MaskSource stairs{[](int i, int j) { return j < (i >= 0 ? i / 4 : (i - 3) / 4); }};
        stairs.caster = stairs.receiver - gap;
        stairs.receiver += 0.3f * eps; // the map's bias
        int differ = 0;
        for (float u = 0.1f; u < 8; u += 0.125f)
            for (float v = -1; v < 3; v += 0.109f)
                differ += visibility_at(stairs, Variant::Nonconservative, {u, v}) !=
                          visibility_at(stairs, Variant::Plain, {u, v});
        return differ;
    };
    // A walk on the lit side has moved ε to the front when it meets the caster: that is seen from 2ε on.
    CHECK(changed(2.5f * eps) > 100);
    CHECK(changed(2.5f * eps) == changed(0.5f));
    CHECK(changed(0.5f * eps) < changed(1.5f * eps));
    CHECK(changed(1.5f * eps) < changed(0.5f));
}

TEST_CASE("the engine's sub-coordinates are half a texel off") {
    for (int i = 0; i < 1024; ++i) {
        const float c = static_cast<float>(i) / 1024.0f;
        const float step = c >= 0.5f ? 1.0f : 0.0f;
        const float printed = 1.0f - ((0.5f - c) * (1.0f - step) + (1.5f - c) * step);
        CHECK(printed == c + 0.5f - std::floor(c + 0.5f));
    }
}

TEST_CASE("a run along y that both ends close counts as closed above in the engine's variant") {
    const MaskSource slot{[](int i, int j) { return i < 0 || (i == 0 && (j < 0 || j >= 4)); }};
    const SilhouetteRules rules = default_rules(Variant::Conservative);
    const auto at = [&](float y, bool as_l) {
        return conservative(slot, rules, {{0.25f, y}, 0.75f, 0.0f}, {.vertical_u_as_l = as_l}).relative.y;
    };
    CHECK(at(1.0f, false) == 0.5f); // 2·min(1, 3)/4
    CHECK(at(3.0f, false) == 0.5f);
    CHECK(at(1.0f, true) == 0.75f); // the distance to the upper end, 3/4
    CHECK(at(3.0f, true) == 0.25f);
}

TEST_CASE("steps in float walk the same texels where they do not slip") {
    const MaskSource stairs{[](int i, int j) { return j < i / 5; }};
    SilhouetteRules whole = default_rules(Variant::Nonconservative), fractions = whole;
    fractions.float_steps = 1024;
    int differ = 0;
    for (float u = 100.37f; u < 140; u += 0.311f)
        for (float v = -1; v < 2; v += 0.13f) {
            const vec2 at(u, u / 5 + v);
            differ += visibility_at(stairs, Variant::Nonconservative, at, {.rules = whole}) !=
                      visibility_at(stairs, Variant::Nonconservative, at, {.rules = fractions});
        }
    CHECK(differ == 0);
}
