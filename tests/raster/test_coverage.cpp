#include <catch2/catch.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>

#include "core/camera.h"
#include "raster/kernels.h"
#include "tests/raster/scalar.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

constexpr int side = 128;

// Depths that survive z·2 − 1 and back exactly: multiples of 2⁻²⁰ in [0.25, 0.75).
float exact_depth(std::mt19937& random) { return static_cast<float>(262144 + random() % 524288) / 1048576.0f; }

// A mix of classes: small, huge, slivers, on the pixel grid, off the target, degenerate.
FixedTriangle random_triangle(std::mt19937& random) {
    const auto between = [&](int low, int high) {
        return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
    };
    FixedTriangle t{};
    const int kind = between(0, 5);
    const int x = between(-20, side + 20) * 256, y = between(-20, side + 20) * 256;
    for (FixedVertex& v : t.v) {
        v.z = exact_depth(random);
        switch (kind) {
        case 0:
            v.x = x + between(-600, 600), v.y = y + between(-600, 600);
            break; // a few pixels
        case 1:
            v.x = between(-4000, 4000) * 256, v.y = between(-4000, 4000) * 256;
            break; // thousands
        case 2:
            v.x = x + between(-3, 3), v.y = y + between(-30000, 30000);
            break; // slivers
        case 3:
            v.x = between(-2, side / 2 + 2) * 512 + 128, v.y = between(-2, side / 2 + 2) * 512 + 128;
            break; // centres
        case 4:
            v.x = between(-300, 300) + side * 256, v.y = between(0, side * 256);
            break; // across the border
        default:
            v.x = x + between(0, 1) * 256, v.y = y + between(0, 1) * 256; // often without area
        }
    }
    return t;
}

// CTest runs the cases tagged [bits] once for each instruction set; one that the machine lacks is skipped.
bool machine_has_isa() {
    try {
        detail::kernels();
        return true;
    } catch (const UsageError& error) {
        skip(error.what());
        return false;
    }
}

struct Drawing {
    PassLog log;
    Target depth{Format::D32F, side, side}, stencil{Format::S8, side, side}, ids{Format::R32UI, side, side};
};

// The fast path, over all triangles in one draw.
void draw_fixed(Drawing& d, const std::vector<FixedTriangle>& triangles, const PipelineState& state) {
    std::vector<vec4> positions;
    std::vector<uvec3> indices;
    for (const FixedTriangle& t : triangles) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        indices.push_back({first, first + 1, first + 2});
        for (const FixedVertex& v : t.v) positions.push_back(to_clip(v, side, side));
    }
    Pass pass(d.log, "test");
    draw(
        pass, {static_cast<std::uint32_t>(positions.size()), indices}, state,
        [&](std::uint32_t i) { return positions[i]; },
        [](const Fragment<NoVaryings>& in, FragmentOutput& out) {
            out.color[0].x = glm::uintBitsToFloat(in.primitive);
        },
        Targets{.depth = &d.depth, .stencil = &d.stencil, .color = {&d.ids}});
}

PipelineState counting_state() {
    PipelineState state;
    state.depth = {.test = Compare::Less, .write = true};
    state.stencil.enabled = true;
    state.stencil.front = {.depth_fail = StencilOp::DecrementWrap, .pass = StencilOp::IncrementWrap};
    state.stencil.back = {.depth_fail = StencilOp::IncrementWrap, .pass = StencilOp::Invert};
    return state;
}

} // namespace

TEST_CASE("the tile path equals the scalar specification bit for bit", "[bits]") {
    if (!machine_has_isa()) return;
    const unsigned seed = GENERATE(1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u);
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::vector<FixedTriangle> triangles;
    for (int i = 0; i < 3000; ++i) triangles.push_back(random_triangle(random));

    Drawing d;
    {
        Pass clear(d.log, "clear");
        d.depth.clear_depth(clear, 1.0f);
        d.ids.clear_uint(clear, 0xffffffffu);
    }
    draw_fixed(d, triangles, counting_state());

    int wrong = 0;
    std::int64_t covered = 0, passed = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            float z = 1.0f;
            std::uint8_t stencil = 0;
            std::uint32_t id = 0xffffffffu;
            for (std::uint32_t i = 0; i < triangles.size(); ++i) {
                if (!covers(triangles[i], x, y)) continue;
                ++covered;
                const auto fresh = static_cast<float>(depth(triangles[i], x, y));
                const bool is_front = front(triangles[i]);
                if (fresh < z) {
                    ++passed;
                    z = fresh, id = i;
                    stencil = static_cast<std::uint8_t>(is_front ? stencil + 1 : ~stencil);
                } else {
                    stencil = static_cast<std::uint8_t>(is_front ? stencil - 1 : stencil + 1);
                }
            }
            wrong += std::bit_cast<std::uint32_t>(z) != d.depth.load_key(x, y) || stencil != d.stencil.load_key(x, y) ||
                     id != d.ids.load_key(x, y);
        }
    CHECK(wrong == 0);
    CHECK(covered > 100000); // the comparison had something to compare
    CHECK(d.log.passes.back().fragments_covered == covered);
    CHECK(d.log.passes.back().fragments_passed == passed);
    CHECK(d.log.passes.back().fragments_shaded == passed);
}

TEST_CASE("a shared edge draws every pixel exactly once", "[bits]") {
    if (!machine_has_isa()) return;
    const unsigned seed = GENERATE(11u, 12u, 13u);
    INFO("seed " << seed);
    std::mt19937 random(seed);
    // A triangulated grid of jittered vertices that covers the whole target.
    constexpr int cells = 24;
    std::vector<FixedVertex> grid;
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i) {
            const auto jitter = [&] { return static_cast<std::int64_t>(random() % 600) - 300; }; // folds no triangle
            grid.push_back({i * side * 256 / cells + jitter(), j * side * 256 / cells + jitter(), 0.5f});
            if (i == 0) grid.back().x = -2000;
            if (i == cells) grid.back().x = side * 256 + 2000;
            if (j == 0) grid.back().y = -2000;
            if (j == cells) grid.back().y = side * 256 + 2000;
        }
    std::vector<FixedTriangle> triangles;
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            const auto at = [&](int di, int dj) { return grid[static_cast<size_t>((j + dj) * (cells + 1) + i + di)]; };
            triangles.push_back({{at(0, 0), at(1, 0), at(1, 1)}});
            triangles.push_back({{at(0, 0), at(0, 1), at(1, 1)}}); // the other winding
        }
    PipelineState state;
    state.stencil.enabled = true;
    state.stencil.front.pass = state.stencil.back.pass = StencilOp::Increment;
    Drawing d;
    draw_fixed(d, triangles, state);
    int wrong = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) wrong += d.stencil.load_key(x, y) != 1;
    CHECK(wrong == 0);
}

TEST_CASE("results and counters do not depend on the number of threads") {
    std::mt19937 random(99);
    std::vector<FixedTriangle> triangles;
    for (int i = 0; i < 20000; ++i) triangles.push_back(random_triangle(random));
    std::vector<std::uint32_t> first;
    std::int64_t first_covered = 0;
    for (const int threads : {1, 2, 7}) {
        Drawing d;
        with_threads(threads, [&] {
            Pass clear(d.log, "clear");
            d.depth.clear_depth(clear, 1.0f);
            draw_fixed(d, triangles, counting_state());
        });
        std::vector<std::uint32_t> values;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                for (const Target* target : {&d.depth, &d.stencil, &d.ids}) values.push_back(target->load_key(x, y));
        if (first.empty()) first = values, first_covered = d.log.passes.back().fragments_covered;
        CHECK(values == first);
        CHECK(d.log.passes.back().fragments_covered == first_covered);
    }
}

TEST_CASE("depth does not depend on winding or on the first vertex", "[bits]") {
    if (!machine_has_isa()) return;
    std::mt19937 random(5);
    for (int i = 0; i < 200; ++i) {
        const FixedTriangle t = random_triangle(random);
        Drawing once, turned;
        PipelineState state;
        state.depth = {.test = Compare::Always, .write = true};
        draw_fixed(once, {t}, state);
        draw_fixed(turned, {{{t.v[2], t.v[1], t.v[0]}}}, state);
        int wrong = 0;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) wrong += once.depth.load_key(x, y) != turned.depth.load_key(x, y);
        REQUIRE(wrong == 0);
    }
}

TEST_CASE(
    "a closed mesh leaves no trace outside and winds once inside, however the near plane and the guard band cut it") {
    // A box around and in front of the eye, front +1 and back −1: zero outside the silhouette. With depth clamp nothing
    // is cut away, so inside the box every pixel sees one back face only.
    const std::vector<vec3> corners = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                       {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
    const std::vector<uvec3> faces_of_box = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                             {2, 3, 7}, {2, 7, 6}, {0, 4, 7}, {0, 7, 3}, {1, 2, 6}, {1, 6, 5}};
    PipelineState state;
    state.depth.clamp = true;
    state.stencil.enabled = true;
    state.stencil.front.pass = StencilOp::IncrementWrap;
    state.stencil.back.pass = StencilOp::DecrementWrap;
    const auto count = [&](vec3 eye, vec3 target) {
        const Camera camera = look_at(eye, target, 1.2f);
        const mat4 to_clip(infinite_projection_matrix(camera, 1.0) * view_matrix(camera));
        PassLog log;
        Pass pass(log, "box");
        Target stencil(Format::S8, side, side);
        draw(
            pass, {8, faces_of_box}, state, [&](std::uint32_t i) { return transform(to_clip, corners[i]); }, depth_only,
            Targets{.stencil = &stencil});
        std::vector<int> histogram(256);
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) ++histogram[stencil.load_key(x, y)];
        return histogram;
    };
    std::mt19937 random(21);
    const auto unit = [&] { return static_cast<float>(random() % 2001) / 1000.0f - 1.0f; };
    for (int i = 0; i < 100; ++i) {
        const vec3 target(unit(), unit(), unit());
        const std::vector<int> outside = count(vec3(unit(), unit(), unit()) + vec3(3.0f, 0.0f, 0.0f), target * 0.5f);
        CHECK(outside[0] == side * side); // +1 and −1 cancel everywhere
        const vec3 eye = vec3(unit(), unit(), unit()) * 0.9f;
        if (glm::length(target - eye) < 0.1f) continue;
        const std::vector<int> inside = count(eye, target);
        CHECK(inside[255] == side * side); // one back face everywhere
    }
}

TEST_CASE("formats quantise as the API says") {
    CHECK(half_from_float(1.0f) == 0x3c00);
    CHECK(half_from_float(65504.0f) == 0x7bff);
    CHECK(half_from_float(65520.0f) == 0x7c00); // the tie goes to even, which is infinity
    CHECK(half_from_float(65519.996f) == 0x7bff);
    CHECK(half_from_float(1.0f + 0x1p-11f) == 0x3c00); // tie to even
    CHECK(half_from_float(1.0f + 3 * 0x1p-11f) == 0x3c02);
    CHECK(half_from_float(0x1p-24f) == 1);
    CHECK(half_from_float(0x1p-25f) == 0); // tie to even
    CHECK(half_from_float(-0x1.8p-25f) == 0x8001);
    for (std::uint32_t h = 0; h < 0x10000; ++h) {
        const float value = float_from_half(static_cast<std::uint16_t>(h));
        if (std::isnan(value)) continue;
        REQUIRE(half_from_float(value) == h);
    }
    CHECK(unorm_from_float(0.5f, 8) == 128);
    CHECK(unorm_from_float(-1.0f, 8) == 0);
    CHECK(unorm_from_float(std::nanf(""), 8) == 0);
    CHECK(unorm_from_float(2.0f, 16) == 65535);
    CHECK(depth_key(Format::D16, 0.5) == 32768);
    CHECK(depth_key(Format::D24, 1.0) == 16777215);
    CHECK(depth_key(Format::D24, -0.1) == 0);
    CHECK(depth_from_key(Format::D32F, depth_key(Format::D32F, 0.3)) == 0.3f);
}
