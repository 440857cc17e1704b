#include <catch2/catch.hpp>

#include <cmath>
#include <random>

#include "raster/sampler.h"

using namespace gnomon;

namespace {

// A cube whose texels of every level are smooth in their direction: f = 2x + 3y + 5z of the unit direction.
float smooth(vec3 d) {
    const vec3 u = glm::normalize(d);
    return 2.0f * u.x + 3.0f * u.y + 5.0f * u.z;
}
Target smooth_cube(int n, int levels) {
    Target cube(Format::R32F, n, n, 6, nullptr, levels);
    for (int level = 0; level < levels; ++level) {
        const int side = cube.width(level);
        for (int face = 0; face < 6; ++face)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    const vec2 uv =
                        vec2(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f) / static_cast<float>(side);
                    cube.store(x, y, face, vec4(smooth(cube_direction(face, uv))), 15, level);
                }
    }
    return cube;
}

// Texels with different values everywhere.
Target numbered_cube(int n) {
    Target cube(Format::R32F, n, n, 6);
    for (int face = 0; face < 6; ++face)
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) cube.store(x, y, face, vec4(static_cast<float>(face * 100 + y * 10 + x)));
    return cube;
}

constexpr Sampler trilinear = {.filter = Filter::Linear, .mip = MipFilter::Linear};

} // namespace

TEST_CASE("directions hit the cube faces of the OpenGL table") {
    const auto hits = [](vec3 d, int face, vec2 uv) {
        const CubePoint p = cube_point(d);
        CHECK(p.face == face);
        CHECK(p.uv().x == Approx(uv.x));
        CHECK(p.uv().y == Approx(uv.y));
    };
    // One direction for every face, with both coordinates off centre: sc and tc of the table give uv.
    hits({1.0f, 0.5f, 0.25f}, 0, {0.375f, 0.25f});  // sc = −z, tc = −y
    hits({-1.0f, 0.5f, 0.25f}, 1, {0.625f, 0.25f}); // sc = +z, tc = −y
    hits({0.5f, 1.0f, 0.25f}, 2, {0.75f, 0.625f});  // sc = +x, tc = +z
    hits({0.5f, -1.0f, 0.25f}, 3, {0.75f, 0.375f}); // sc = +x, tc = −z
    hits({0.5f, 0.25f, 1.0f}, 4, {0.75f, 0.375f});  // sc = +x, tc = −y
    hits({0.5f, 0.25f, -1.0f}, 5, {0.25f, 0.375f}); // sc = −x, tc = −y
    hits({3.0f, 3.0f, 3.0f}, 0, {0.0f, 0.0f});      // ties: x before y before z
    hits({1.0f, -2.0f, 2.0f}, 3, {0.75f, 0.0f});
    hits({0.0f, 0.0f, 0.0f}, 1, {0.5f, 0.5f});
    std::mt19937 random(5);
    const auto between = [&] { return static_cast<float>(random() % 20001) / 10000.0f - 1.0f; };
    for (int i = 0; i < 1000; ++i) {
        const vec3 d(between(), between(), between());
        const CubePoint p = cube_point(d);
        const vec3 back = cube_direction(p.face, p.uv()) * p.major;
        CHECK(glm::length(back - d) < 1e-6f);
    }
}

TEST_CASE("a texel beyond a cube edge is the neighbour that its centre projects on, and the way back leads home") {
    for (const int n : {1, 2, 5, 8, 64})
        for (int face = 0; face < 6; ++face)
            for (int k = 0; k < n; ++k)
                for (const glm::ivec2 at : {glm::ivec2(-1, k), {n, k}, {k, -1}, {k, n}}) {
                    const CubeTexel t = cube_texel(face, at.x, at.y, n);
                    REQUIRE(t.face != face);
                    REQUIRE(t.face / 2 != face / 2); // not the opposite face
                    // On the edge of its face, next to a texel of ours: one of the steps beyond its edges is home.
                    const CubeTexel inner = {face, std::clamp(at.x, 0, n - 1), std::clamp(at.y, 0, n - 1)};
                    int back = 0;
                    for (const glm::ivec2 step : {glm::ivec2(-1, 0), {1, 0}, {0, -1}, {0, 1}}) {
                        const int x = t.x + step.x, y = t.y + step.y;
                        if (x >= 0 && x < n && y >= 0 && y < n) continue;
                        const CubeTexel home = cube_texel(t.face, x, y, n);
                        back += home.face == inner.face && home.x == inner.x && home.y == inner.y;
                    }
                    REQUIRE(back == 1);
                }
}

TEST_CASE("cube look-ups read the nearest texel of the face, whatever the wrap mode") {
    const Target cube = numbered_cube(4);
    PassCounters counters;
    for (int face = 0; face < 6; ++face)
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 4; ++x) {
                const vec2 uv((static_cast<float>(x) + 0.5f) / 4, (static_cast<float>(y) + 0.5f) / 4);
                const vec3 d = cube_direction(face, uv) * 3.0f;
                const float value = static_cast<float>(100 * face + 10 * y + x);
                CHECK(sample_cube(cube, {.wrap = Wrap::Border}, d, counters).x == value);
                CHECK(sample_cube(cube, {.filter = Filter::Linear}, d, counters).x == Approx(value));
            }
    CHECK(counters.texels_fetched >= 96 * 2);
}

TEST_CASE("linear cube filtering has no seams at edges, and all faces agree at corners") {
    const Target cube = numbered_cube(8);
    const Sampler linear = {.filter = Filter::Linear};
    PassCounters counters;
    std::mt19937 random(9);
    // Across an edge: two directions a hair to either side.
    for (int i = 0; i < 3000; ++i) {
        vec3 d(static_cast<float>(random() % 2001) / 1000.0f - 1.0f);
        const int a = static_cast<int>(random() % 3), b = (a + 1) % 3;
        const float hair = 1e-6f;
        d[a] = random() % 2 ? 1.0f : -1.0f;
        d[b] = random() % 2 ? 1.0f : -1.0f;
        vec3 left = d, right = d;
        left[a] *= 1 + hair;
        right[b] *= 1 + hair;
        const float l = sample_cube(cube, linear, left, counters).x, r = sample_cube(cube, linear, right, counters).x;
        CHECK(std::abs(l - r) < 0.02f); // values differ by hundreds between faces
    }
    // At a corner: the mean of its three texels, from each of the three faces.
    for (int corner = 0; corner < 8; ++corner) {
        const vec3 d(corner & 1 ? 1.0f : -1.0f, corner & 2 ? 1.0f : -1.0f, corner & 4 ? 1.0f : -1.0f);
        float sum = 0;
        for (int axis = 0; axis < 3; ++axis) {
            vec3 into = d * 0.99f;
            into[axis] = d[axis];
            sum += sample_cube(cube, {}, into, counters).x;
        }
        for (int axis = 0; axis < 3; ++axis) {
            vec3 near = d;
            near[axis] *= 1 + 1e-6f;
            counters = {};
            CHECK(sample_cube(cube, linear, near, counters).x == Approx(sum / 3).epsilon(1e-4));
            CHECK(counters.texels_fetched == 3);
        }
    }
    // One texel a face: every look-up is near a corner.
    const Target tiny = numbered_cube(1);
    CHECK(sample_cube(tiny, linear, {1, 1, 1}, counters).x == Approx((0 + 200 + 400) / 3.0f));
    CHECK(sample_cube(tiny, linear, {0, 1, 0}, counters).x == 200.0f);
}

TEST_CASE("a smooth function on a cube is reproduced within the filter's error, at every level") {
    const Target cube = smooth_cube(64, 4);
    PassCounters counters;
    std::mt19937 random(3);
    const auto between = [&] { return static_cast<float>(random() % 20001) / 10000.0f - 1.0f; };
    float worst = 0;
    for (int i = 0; i < 5000; ++i) {
        const vec3 d(between(), between(), between());
        if (glm::length(d) < 0.1f) continue;
        const float lod = static_cast<float>(i % 30) / 10.0f;
        worst = std::max(worst, std::abs(sample_cube_lod(cube, trilinear, d, lod, counters).x - smooth(d)));
    }
    CHECK(worst < 0.12f); // level 3 has 8×8 texels a face
}

TEST_CASE("cube gradients give the level of the face's own texels") {
    Target cube(Format::R32F, 16, 16, 12, nullptr, 5);
    for (int level = 0; level < 5; ++level)
        for (int layer = 0; layer < 12; ++layer)
            for (int y = 0; y < cube.height(level); ++y)
                for (int x = 0; x < cube.width(level); ++x)
                    cube.store(x, y, layer, vec4(static_cast<float>(level + 10 * (layer / 6))), 15, level);
    PassCounters counters;
    // On face +Z at major 2, a step of 1 in x is ¼ of the face: 4 of 16 texels, level 2.
    CHECK(sample_cube_grad(cube, trilinear, {0, 0, 2}, {1, 0, 0}, {0, 0.25f, 0}, counters).x == 2.0f);
    CHECK(sample_cube_grad(cube, trilinear, {0, 0, 2}, {1, 0, 0}, {0, 0.25f, 0}, counters, 1).x == 12.0f);
    // Along the view direction nothing moves.
    CHECK(sample_cube_grad(cube, trilinear, {0, 0, 2}, {0, 0, 1}, {0, 0, 1}, counters).x == 0.0f);
    Sampler anisotropic = trilinear;
    anisotropic.max_anisotropy = 8;
    counters = {};
    CHECK(sample_cube_grad(cube, anisotropic, {0, 0, 2}, {1, 0, 0}, {0, 0.25f, 0}, counters).x == 0.0f);
    CHECK(counters.texels_fetched == 4 * 4); // 4×1 texels: four probes at level 0
}

TEST_CASE("cube comparisons filter results across edges") {
    Target cube(Format::D32F, 4, 4, 6);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) cube.store_key(x, y, 0, depth_key(Format::D32F, 1.0)); // face +X far, others near
    PassCounters counters;
    const Sampler linear = {.filter = Filter::Linear};
    const auto lit = [&](vec3 d) { return sample_cube_compare(cube, linear, d, 0.5f, Compare::LessEqual, counters); };
    CHECK(lit({1, 0, 0}) == 1.0f);
    CHECK(lit({0, 1, 0}) == 0.0f);
    CHECK(lit({1, 1, 0}) == 0.5f);
    CHECK(lit({1, 0, 1}) == 0.5f);
    CHECK(lit({1, 1, 1}) == Approx(1.0f / 3));
}
