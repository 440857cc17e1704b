// Every pipeline state against the scalar specification, in random combinations.

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "raster/blend.h"
#include "raster/kernels.h"
#include "tests/raster/scalar.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

constexpr int side = 64;

struct Random {
    std::mt19937 engine;
    int below(int n) { return static_cast<int>(engine() % static_cast<unsigned>(n)); }
    float unit() { return static_cast<float>(below(1025)) / 1024.0f; }
    template <class Enum> Enum any(int count) { return static_cast<Enum>(below(count)); }
};

FixedTriangle random_triangle(Random& random) {
    FixedTriangle t{};
    const bool large = random.below(2) == 0;
    const int x = random.below(side * 256), y = random.below(side * 256);
    for (FixedVertex& v : t.v) {
        const int reach = large ? 40000 : 3000;
        v = {x + random.below(2 * reach) - reach, y + random.below(2 * reach) - reach,
             static_cast<float>(random.below(1048577)) / 1048576.0f};
    }
    return t;
}

StencilFace random_face(Random& random) {
    return {.test = random.any<Compare>(8),
            .reference = static_cast<std::uint32_t>(random.below(256)),
            .read_mask = static_cast<std::uint32_t>(random.below(2) ? 255 : random.below(256)),
            .write_mask = static_cast<std::uint32_t>(random.below(2) ? 255 : random.below(256)),
            .fail = random.any<StencilOp>(8),
            .depth_fail = random.any<StencilOp>(8),
            .pass = random.any<StencilOp>(8)};
}

PipelineState random_state(Random& random) {
    PipelineState state;
    state.depth.test = random.any<Compare>(8);
    state.depth.write = random.below(2) == 0;
    state.depth.clamp = random.below(2) == 0;
    if (random.below(4) == 0)
        state.depth.bounds = DepthState::Bounds{0.25f * random.unit(), 1.0f - 0.25f * random.unit()};
    state.stencil.enabled = random.below(2) == 0;
    state.stencil.front = random_face(random);
    state.stencil.back = random_face(random);
    state.cull = random.any<Cull>(3);
    state.front_face = random.any<FrontFace>(2);
    if (random.below(3) == 0)
        state.polygon_offset = {4.0f * random.unit() - 2.0f, 1000.0f * random.unit() - 500.0f,
                                random.below(2) ? 0.0f : 0.02f * random.unit() - 0.01f};
    if (random.below(2) == 0)
        state.scissor =
            Rectangle{random.below(side) - 8, random.below(side) - 8, random.below(side), random.below(side)};
    state.blend.enabled = random.below(2) == 0;
    state.blend.source_color = random.any<BlendFactor>(12);
    state.blend.destination_color = random.any<BlendFactor>(12);
    state.blend.source_alpha = random.any<BlendFactor>(12);
    state.blend.destination_alpha = random.any<BlendFactor>(12);
    state.blend.color = random.any<BlendOp>(5);
    state.blend.alpha = random.any<BlendOp>(5);
    state.blend.constant = {random.unit(), random.unit(), random.unit(), random.unit()};
    for (std::uint8_t& mask : state.color_mask)
        mask = static_cast<std::uint8_t>(random.below(2) ? 15 : random.below(16));
    state.logic_op = random.any<LogicOp>(7);
    return state;
}

// What the fragment program writes; the scalar model calls the same function. A tenth of the fragments is discarded
// where asked.
vec4 color_of(std::uint32_t primitive, int x, int y) {
    const auto channel = [&](std::uint32_t salt) {
        return static_cast<float>((primitive * 7919u + static_cast<std::uint32_t>(x) * 31u +
                                   static_cast<std::uint32_t>(y) * 17u + salt) %
                                  97u) /
               96.0f;
    };
    return {channel(1), channel(20), channel(40), channel(60)};
}
bool discarded(std::uint32_t primitive, int x, int y) {
    return (primitive + static_cast<std::uint32_t>(x * 3 + y)) % 10 == 0;
}

struct Buffers {
    Target depth, stencil, color, integer;
};

Buffers make_buffers(Format depth_format, Format stencil_format, Format color_format) {
    Buffers b{Target(depth_format, side, side), Target(stencil_format, side, side), Target(color_format, side, side),
              Target(Format::R32UI, side, side)};
    PassLog log;
    Pass pass(log, "clear");
    b.depth.clear_depth(pass, 0.6f);
    b.stencil.clear_uint(pass, 77);
    b.color.clear(pass, {0.2f, 0.4f, 0.6f, 0.8f});
    b.integer.clear_uint(pass, 0x0f0f0f0fu);
    return b;
}

bool holds(Compare test, std::uint32_t a, std::uint32_t b) {
    switch (test) {
    case Compare::Never:
        return false;
    case Compare::Less:
        return a < b;
    case Compare::Equal:
        return a == b;
    case Compare::LessEqual:
        return a <= b;
    case Compare::Greater:
        return a > b;
    case Compare::NotEqual:
        return a != b;
    case Compare::GreaterEqual:
        return a >= b;
    case Compare::Always:
        return true;
    }
    return false;
}

std::uint32_t stencil_op(StencilOp op, std::uint32_t value, std::uint32_t reference, std::uint32_t most) {
    switch (op) {
    case StencilOp::Keep:
        return value;
    case StencilOp::Zero:
        return 0;
    case StencilOp::Replace:
        return reference;
    case StencilOp::Increment:
        return value < most ? value + 1 : most;
    case StencilOp::Decrement:
        return value > 0 ? value - 1 : 0;
    case StencilOp::Invert:
        return most - value;
    case StencilOp::IncrementWrap:
        return value == most ? 0 : value + 1;
    case StencilOp::DecrementWrap:
        return value == 0 ? most : value - 1;
    }
    return value;
}

std::uint32_t logic(LogicOp op, std::uint32_t s, std::uint32_t d) {
    switch (op) {
    case LogicOp::Copy:
        return s;
    case LogicOp::Clear:
        return 0;
    case LogicOp::Set:
        return 0xffffffffu;
    case LogicOp::And:
        return s & d;
    case LogicOp::Or:
        return s | d;
    case LogicOp::Xor:
        return s ^ d;
    case LogicOp::Invert:
        return ~d;
    }
    return s;
}

// One fragment through all tests, in the order that the API prescribes.
void scalar_fragment(Buffers& b, const PipelineState& state, const FixedTriangle& t, std::uint32_t primitive, int x,
                     int y, bool may_discard) {
    const bool counter_clockwise = front(t);
    const bool is_front = counter_clockwise == (state.front_face == FrontFace::CounterClockwise);
    if (state.cull == (is_front ? Cull::Front : Cull::Back)) return;
    if (state.scissor) {
        const Rectangle& r = *state.scissor;
        if (x < r.x || y < r.y || x >= r.x + r.width || y >= r.y + r.height) return;
    }
    if (may_discard && discarded(primitive, x, y)) return;
    const Format format = b.depth.format();
    const double z = depth(t, x, y) + offset(t, state.polygon_offset, format);
    const std::uint32_t key = depth_key(format, z), old_depth = b.depth.load_key(x, y);
    if (state.depth.bounds) {
        const float stored = depth_from_key(format, old_depth);
        if (stored < state.depth.bounds->minimum || stored > state.depth.bounds->maximum) return;
    }
    const std::uint32_t most = b.stencil.format() == Format::S8 ? 255u : 0xffffffffu;
    const StencilFace& face = is_front ? state.stencil.front : state.stencil.back;
    const auto update = [&](StencilOp op) {
        if (!state.stencil.enabled) return;
        const std::uint32_t old = b.stencil.load_key(x, y);
        const std::uint32_t fresh = stencil_op(op, old, face.reference, most);
        b.stencil.store_key(x, y, 0, (old & ~face.write_mask) | (fresh & face.write_mask));
    };
    if (state.stencil.enabled &&
        !holds(face.test, face.reference & face.read_mask, b.stencil.load_key(x, y) & face.read_mask))
        return update(face.fail);
    if (!holds(state.depth.test, key, old_depth)) return update(face.depth_fail);
    update(face.pass);
    if (state.depth.write) b.depth.store_key(x, y, 0, key);
    const vec4 source = color_of(primitive, x, y);
    b.color.store(x, y, 0, state.blend.enabled ? blend(state.blend, source, b.color.load(x, y)) : source,
                  state.color_mask[0]);
    if (state.color_mask[1] & 1)
        b.integer.store_key(x, y, 0, logic(state.logic_op, primitive * 2654435761u, b.integer.load_key(x, y)));
}

void draw_fast(Buffers& b, const PipelineState& state, const std::vector<FixedTriangle>& triangles, bool may_discard) {
    std::vector<vec4> positions;
    std::vector<uvec3> indices;
    for (const FixedTriangle& t : triangles) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        indices.push_back({first, first + 1, first + 2});
        for (const FixedVertex& v : t.v) positions.push_back(to_clip(v, side, side));
    }
    PassLog log;
    Pass pass(log, "states");
    const auto program = [&](const Fragment<NoVaryings>& in, FragmentOutput& out) {
        out.discarded = may_discard && discarded(in.primitive, in.pixel.x, in.pixel.y);
        out.color[0] = color_of(in.primitive, in.pixel.x, in.pixel.y);
        out.color[1].x = glm::uintBitsToFloat(in.primitive * 2654435761u);
    };
    draw(
        pass, {static_cast<std::uint32_t>(positions.size()), indices}, state,
        [&](std::uint32_t i) { return positions[i]; }, FragmentProgram{program, {.discards = may_discard}},
        Targets{.depth = &b.depth, .stencil = &b.stencil, .color = {&b.color, &b.integer}});
}

} // namespace

TEST_CASE("every state in random combinations equals the scalar specification bit for bit", "[bits]") {
    const unsigned seed = GENERATE(range(100u, 104u));
    INFO("seed " << seed);
    Random random{std::mt19937(seed)};
    constexpr Format colors[] = {Format::R8,      Format::RG8,    Format::RGBA8, Format::R16,
                                 Format::RG16,    Format::RGBA16, Format::R16F,  Format::RG16F,
                                 Format::RGBA16F, Format::R32F,   Format::RG32F, Format::RGBA32F};
    for (int trial = 0; trial < 60; ++trial) {
        const auto depth_format = random.any<Format>(3);
        const Format stencil_format = random.below(2) ? Format::S8 : Format::S32;
        const Format color_format = colors[random.below(12)];
        const PipelineState state = random_state(random);
        const bool may_discard = random.below(2) == 0;
        std::vector<FixedTriangle> triangles;
        for (int i = 0; i < 40; ++i) triangles.push_back(random_triangle(random));

        Buffers fast = make_buffers(depth_format, stencil_format, color_format);
        Buffers scalar = make_buffers(depth_format, stencil_format, color_format);
        draw_fast(fast, state, triangles, may_discard);
        for (std::uint32_t i = 0; i < triangles.size(); ++i)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x)
                    if (covers(triangles[i], x, y)) scalar_fragment(scalar, state, triangles[i], i, x, y, may_discard);

        int wrong_depth = 0, wrong_stencil = 0, wrong_color = 0, wrong_integer = 0;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                wrong_depth += fast.depth.load_key(x, y) != scalar.depth.load_key(x, y);
                wrong_stencil += fast.stencil.load_key(x, y) != scalar.stencil.load_key(x, y);
                wrong_integer += fast.integer.load_key(x, y) != scalar.integer.load_key(x, y);
                wrong_color += std::memcmp(fast.color.texel(x, y, 0), scalar.color.texel(x, y, 0),
                                           static_cast<size_t>(info(color_format).bytes)) != 0;
            }
        CAPTURE(trial, info(depth_format).name, info(stencil_format).name, info(color_format).name);
        REQUIRE(wrong_depth == 0);
        REQUIRE(wrong_stencil == 0);
        REQUIRE(wrong_color == 0);
        REQUIRE(wrong_integer == 0);
    }
}

TEST_CASE("conservative rasterization covers every pixel that a triangle's inside touches", "[bits]") {
    Random random{std::mt19937(7)};
    PipelineState state;
    state.conservative = true;
    for (int i = 0; i < 100; ++i) {
        const FixedTriangle t = random_triangle(random);
        Buffers b = make_buffers(Format::D32F, Format::S8, Format::R8);
        draw_fast(b, state, {t}, false);
        // A pixel with any of 17×17 points inside must be drawn; drawn pixels lie within a pixel of the triangle's box.
        for (int y = 0; y < side; y += 3)
            for (int x = 0; x < side; ++x) {
                bool touched = false;
                for (int k = 0; k < 289 && !touched; ++k) {
                    FixedTriangle moved = t; // the point moves to the centre
                    for (FixedVertex& v : moved.v) v.x -= (k % 17) * 16 - 128, v.y -= (k / 17) * 16 - 128;
                    touched = covers(moved, x, y);
                }
                const bool drawn = b.integer.load_key(x, y) != 0x0f0f0f0fu;
                if (touched) REQUIRE(drawn);
                const auto [x0, x1] = std::minmax({t.v[0].x, t.v[1].x, t.v[2].x});
                if (drawn) REQUIRE((x * 256 + 256 >= x0 && x * 256 <= x1));
            }
    }
}

namespace {
struct AllKinds {
    float smooth, linear, flat;
    static constexpr std::array interpolation = {Interpolation::Perspective, Interpolation::Linear,
                                                 Interpolation::Flat};
};
} // namespace

TEST_CASE("varyings are perspective-correct, linear in the window, or flat from the provoking vertex") {
    // A wall that recedes from w = 1 at the left to w = 4 at the right: at the middle of the window the smooth value is
    // nearer to the left's.
    const std::vector<vec4> corners = {{-1, -1, 0, 1}, {4, -4, 0, 4}, {4, 4, 0, 4}, {-1, 1, 0, 1}};
    const std::vector<uvec3> triangles = {{0, 1, 2}, {0, 2, 3}};
    PassLog log;
    Pass pass(log, "wall");
    Target values(Format::RGBA32F, side, side);
    for (const ProvokingVertex provoking : {ProvokingVertex::Last, ProvokingVertex::First}) {
        PipelineState state;
        state.provoking_vertex = provoking;
        const auto vertex = [&](std::uint32_t i) {
            const float u = i == 1 || i == 2 ? 1.0f : 0.0f;
            return Vertex<AllKinds>{corners[i], {u, u, static_cast<float>(10 + i)}};
        };
        draw(
            pass, {4, triangles}, state, vertex,
            [](const Fragment<AllKinds>& in, FragmentOutput& out) {
                out.color[0] = {in.varyings.smooth, in.varyings.linear, in.varyings.flat, in.inverse_w};
            },
            Targets{.color = {&values}});
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const double s = (x + 0.5) / side;                                      // across the window
                const double inverse_w = (1 - s) + s / 4, smooth = (s / 4) / inverse_w; // hyperbolic
                const vec4 v = values.load(x, y);
                REQUIRE(std::abs(static_cast<double>(v.x) - smooth) < 1e-6);
                REQUIRE(std::abs(static_cast<double>(v.y) - s) < 1e-6);
                REQUIRE(std::abs(static_cast<double>(v.w) - inverse_w) < 1e-6);
                const bool lower = values.load(side - 1, 0).z == v.z;
                REQUIRE(v.z == (provoking == ProvokingVertex::First ? 10.0f : lower ? 12.0f : 13.0f));
            }
        CHECK(values.load(side - 1, 0).z == (provoking == ProvokingVertex::First ? 10.0f : 12.0f));
        CHECK(values.load(0, side - 1).z == (provoking == ProvokingVertex::First ? 10.0f : 13.0f));
    }
}

TEST_CASE("derivatives are the differences of 2x2 quads, helpers included") {
    // One thin triangle whose varying is 3x + 5y in pixels: every fragment sees exactly those differences, though its
    // neighbours are outside.
    const auto at = [](float x, float y) { return vec4(x / 32 - 1, y / 32 - 1, 0, 1); };
    const std::vector<vec4> corners = {at(3, 2), at(60, 50), at(59, 52)};
    PassLog log;
    Pass pass(log, "sliver");
    Target values(Format::RG32F, side, side), drawn(Format::R8, side, side);
    struct Value {
        float v;
    };
    draw(
        pass, {3, std::vector<uvec3>{{0, 1, 2}}}, PipelineState{},
        [&](std::uint32_t i) {
            const vec4 p = corners[i];
            return Vertex<Value>{p, {3 * (p.x + 1) * 32 + 5 * (p.y + 1) * 32}};
        },
        FragmentProgram{[](const Fragment<Value>& in, FragmentOutput& out) {
                            out.color[0] = vec4(in.ddx.v, in.ddy.v, 0, 0);
                            out.color[1] = vec4(1);
                        },
                        {.derivatives = true}},
        Targets{.color = {&values, &drawn}});
    int count = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            if (drawn.load(x, y).x == 0) continue;
            ++count;
            REQUIRE(std::abs(values.load(x, y).x - 3) < 1e-2f);
            REQUIRE(std::abs(values.load(x, y).y - 5) < 1e-2f);
        }
    CHECK(count > 40);
}
