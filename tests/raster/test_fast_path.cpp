// Tiles in a buffer of their own against the general path, which the scalar specification holds: the same texels and
// the same counters for every state that both can draw.

#include <catch2/catch.hpp>

#include <cstring>
#include <random>

#include "core/error.h"
#include "raster/draw.h"

using namespace gnomon;

namespace {

struct Varyings {
    vec3 smooth;
    float linear, flat;
    static constexpr std::array interpolation = {Interpolation::Perspective, Interpolation::Perspective,
                                                 Interpolation::Perspective, Interpolation::Linear,
                                                 Interpolation::Flat};
};

// Triangles of all sizes, some across the near plane, some behind the eye, with and without perspective.
struct RandomScene {
    std::mt19937 random;
    std::vector<vec4> positions;
    std::vector<Varyings> varyings;
    std::vector<uvec3> triangles;

    explicit RandomScene(std::uint32_t seed, int count) : random(seed) {
        for (int t = 0; t < count; ++t) {
            const float reach = std::array{0.02f, 0.1f, 0.5f, 3.0f, 40.0f}[random() % 5];
            const vec3 center(between(-1.2f, 1.2f), between(-1.2f, 1.2f), between(-1.1f, 1.1f));
            const bool flat_depth = random() % 8 == 0, perspective = random() % 2 == 0;
            const auto first = static_cast<std::uint32_t>(positions.size());
            for (int i = 0; i < 3; ++i) {
                const float w = perspective ? between(0.3f, 3.0f) - (random() % 16 == 0 ? 3.0f : 0.0f) : 1.0f;
                const vec3 offset(between(-reach, reach), between(-reach, reach),
                                  flat_depth ? 0.0f : between(-0.2f, 0.2f));
                positions.emplace_back((center + offset) * w, w);
                varyings.push_back({vec3(between(-5, 5), between(-5, 5), 1.0f), between(0, 1), static_cast<float>(t)});
            }
            triangles.push_back({first, first + 1, first + 2});
        }
    }
    float between(float low, float high) {
        return low + (high - low) * static_cast<float>(random() % 65537) / 65536.0f;
    }
    int below(int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); }
    Geometry geometry() const { return {static_cast<std::uint32_t>(positions.size()), triangles}; }
};

PipelineState random_state(RandomScene& scene, int width, int height) {
    PipelineState state;
    state.depth = {.test = scene.below(2) ? Compare::Less : static_cast<Compare>(scene.below(8)),
                   .write = scene.below(4) > 0,
                   .clamp = scene.below(3) == 0};
    state.cull = static_cast<Cull>(scene.below(3));
    state.front_face = static_cast<FrontFace>(scene.below(2));
    state.conservative = scene.below(4) == 0;
    if (scene.below(2))
        state.polygon_offset = {scene.between(-4, 4), scene.between(-2000, 2000), scene.between(-0.01f, 0.01f)};
    if (scene.below(3) == 0) state.scissor = Rectangle{scene.below(width), scene.below(height), width / 2, height / 2};
    if (scene.below(3) == 0) state.viewport = Rectangle{scene.below(40) - 20, scene.below(40) - 20, width, height};
    return state;
}

bool same_texels(const Target& a, const Target& b) {
    return std::memcmp(a.texel(0, 0, 0), b.texel(0, 0, 0), static_cast<size_t>(a.bytes())) == 0;
}

void check_same_counters(const PassCounters& a, const PassCounters& b) {
    CHECK(a.clipped == b.clipped);
    CHECK(a.culled == b.culled);
    CHECK(a.fragments_covered == b.fragments_covered);
    CHECK(a.fragments_passed == b.fragments_passed);
    CHECK(a.bytes_read == b.bytes_read);
    CHECK(a.bytes_written == b.bytes_written);
}

// A program, even an empty one, takes the general path unless it says that it runs for visible fragments only.
const auto empty_program = [](const Fragment<NoVaryings>&, FragmentOutput&) {};

void fill_random(Target& target, RandomScene& scene) {
    for (int y = 0; y < target.height(); ++y)
        for (int x = 0; x < target.width(); ++x)
            target.store_key(x, y, 0, depth_key(target.format(), static_cast<double>(scene.between(0.3f, 0.9f))));
}

} // namespace

TEST_CASE("a tile in a buffer of its own gives the same depths and stencil counts", "[bits]") {
    const std::uint32_t seed = GENERATE(range(1u, 41u));
    CAPTURE(seed);
    RandomScene scene(seed, 300);
    const int width = 65 + scene.below(200), height = 1 + scene.below(150);
    const Format format = std::array{Format::D32F, Format::D24, Format::D16}[static_cast<size_t>(scene.below(3))];
    PipelineState state = random_state(scene, width, height);
    const bool counting = scene.below(2) == 0;
    const Format counters = scene.below(2) ? Format::S8 : Format::S32;
    if (counting) {
        constexpr std::array ops = {StencilOp::Keep, StencilOp::IncrementWrap, StencilOp::DecrementWrap};
        const auto op = [&] { return ops[static_cast<size_t>(scene.below(3))]; };
        state.depth.write = false;
        state.stencil.enabled = true;
        state.stencil.front = {.depth_fail = op(), .pass = op()};
        state.stencil.back = {.depth_fail = op(), .pass = op()};
    }
    PassLog log;
    std::array<Target, 2> depth = {Target(format, width, height), Target(format, width, height)};
    std::array<Target, 2> stencil = {Target(counters, width, height), Target(counters, width, height)};
    fill_random(depth[0], scene);
    std::memcpy(depth[1].texel(0, 0, 0), depth[0].texel(0, 0, 0), static_cast<size_t>(depth[0].bytes()));
    const auto vertex = [&](std::uint32_t i) { return scene.positions[i]; };
    Pass fast(log, "fast");
    draw(fast, scene.geometry(), state, vertex, depth_only, Targets{.depth = &depth[0], .stencil = &stencil[0]});
    Pass general(log, "general");
    draw(general, scene.geometry(), state, vertex, empty_program, Targets{.depth = &depth[1], .stencil = &stencil[1]});
    CHECK(same_texels(depth[0], depth[1]));
    CHECK(same_texels(stencil[0], stencil[1]));
    check_same_counters(fast.counters(), general.counters());
}

// Depths reach large targets past the caches, and whole tiles while others are drawn.
TEST_CASE("large targets get every tile, with triangles and without", "[bits]") {
    const ivec2 size = GENERATE(ivec2(2048, 832), ivec2(1664, 1000), ivec2(1301, 1290), ivec2(768, 512));
    const bool crowded = GENERATE(false, true);
    CAPTURE(size.x, size.y, crowded);
    RandomScene scene(7, crowded ? 3000 : 40);
    if (crowded) // a corner of the target: some tiles get hundreds, others none
        for (vec4& p : scene.positions) p = vec4(p.x * 0.2f - p.w * 0.6f, p.y * 0.2f - p.w * 0.7f, p.z, p.w);
    PipelineState state;
    state.depth = {.test = Compare::Less, .write = true};
    PassLog log;
    std::array<Target, 2> depth = {Target(Format::D32F, size.x, size.y), Target(Format::D32F, size.x, size.y)};
    const auto vertex = [&](std::uint32_t i) { return scene.positions[i]; };
    for (const float cleared : {0.75f, 1.0f}) {
        Pass fast(log, "fast");
        draw(fast, scene.geometry(), state, vertex, depth_only, Targets{.depth = &depth[0], .clear_depth = cleared});
        Pass general(log, "general");
        draw(general, scene.geometry(), state, vertex, empty_program,
             Targets{.depth = &depth[1], .clear_depth = cleared});
        CHECK(same_texels(depth[0], depth[1]));
        check_same_counters(fast.counters(), general.counters());
    }
}

TEST_CASE("programs that run for visible fragments only leave the same colours", "[bits]") {
    const std::uint32_t seed = GENERATE(range(1u, 31u));
    CAPTURE(seed);
    RandomScene scene(seed, 300);
    const int width = 65 + scene.below(200), height = 1 + scene.below(150);
    PipelineState state = random_state(scene, width, height);
    const bool derivatives = scene.below(2) == 0, cleared = scene.below(2) == 0;
    for (std::uint8_t& mask : state.color_mask)
        if (scene.below(3) == 0) mask = static_cast<std::uint8_t>(scene.below(16)); // does not bound the clears
    PassLog log;
    struct Buffers {
        Target depth, exact, narrow, ids;
        Buffers(int w, int h)
            : depth(Format::D32F, w, h), exact(Format::RGBA32F, w, h), narrow(Format::RGBA8, w, h),
              ids(Format::R32UI, w, h) {}
    };
    std::array<Buffers, 2> buffers = {Buffers(width, height), Buffers(width, height)};
    const auto program = [&](const Fragment<Varyings>& in, FragmentOutput& out) {
        out.color[0] = vec4(in.varyings.smooth + in.ddx.smooth, in.varyings.linear + in.depth);
        out.color[1] = vec4(in.ddy.smooth, in.inverse_w);
        out.color[2].x = glm::uintBitsToFloat(in.primitive + static_cast<std::uint32_t>(in.varyings.flat));
    };
    for (const bool visible_only : {true, false}) {
        Buffers& b = buffers[visible_only];
        Pass pass(log, "pass");
        Targets targets{.depth = &b.depth, .color = {&b.exact, &b.narrow, &b.ids}, .clear_depth = 0.9f};
        if (cleared) targets.clear_color = vec4(0.25f, 0.5f, 0.0f, 1.0f);
        draw(
            pass, scene.geometry(), state,
            [&](std::uint32_t i) {
                return Vertex<Varyings>{scene.positions[i], scene.varyings[i]};
            },
            FragmentProgram{program, {.derivatives = derivatives, .visible_only = visible_only}}, targets);
    }
    CHECK(same_texels(buffers[0].depth, buffers[1].depth));
    CHECK(same_texels(buffers[0].exact, buffers[1].exact));
    CHECK(same_texels(buffers[0].narrow, buffers[1].narrow));
    CHECK(same_texels(buffers[0].ids, buffers[1].ids));
    check_same_counters(log.passes[0], log.passes[1]);
    CHECK(log.passes[0].fragments_shaded == log.passes[1].fragments_shaded);
}

TEST_CASE("load operations are clears of one layer and level", "[bits]") {
    const bool general = GENERATE(false, true), empty = GENERATE(false, true);
    CAPTURE(general, empty);
    RandomScene scene(7, empty ? 0 : 100);
    constexpr int width = 150, height = 90, layers = 3, levels = 2;
    PipelineState state;
    state.depth = {.test = Compare::Less, .write = true};
    state.scissor = Rectangle{10, 10, 20, 20}; // does not bound the clears
    PassLog log;
    Target depth(Format::D24, width, height, layers, nullptr, levels),
        stencil(Format::S8, width, height, layers, nullptr, levels),
        color(Format::RGBA16F, width, height, layers, nullptr, levels);
    const auto program = [](const Fragment<NoVaryings>&, FragmentOutput& out) { out.color[0] = vec4(0.5f); };
    Pass pass(log, "pass");
    draw(
        pass, scene.geometry(), state, [&](std::uint32_t i) { return scene.positions[i]; },
        FragmentProgram{program, {.visible_only = !general}},
        Targets{.depth = &depth,
                .stencil = &stencil,
                .color = {&color},
                .layer = 1,
                .level = 1,
                .clear_depth = 0.5f,
                .clear_stencil = 9,
                .clear_color = vec4(1, 2, 3, 4)});
    int inside = 0;
    for (int level = 0; level < levels; ++level)
        for (int layer = 0; layer < layers; ++layer)
            for (int y = 0; y < color.height(level); ++y)
                for (int x = 0; x < color.width(level); ++x) {
                    const bool cleared = level == 1 && layer == 1;
                    const vec4 texel = color.load(x, y, layer, level);
                    if (texel == vec4(0.5f)) {
                        ++inside;
                        CHECK((cleared && x >= 10 && y >= 10 && x < 30 && y < 30));
                        continue;
                    }
                    if (texel != (cleared ? vec4(1, 2, 3, 4) : vec4(0.0f)) ||
                        stencil.load_key(x, y, layer, level) != (cleared ? 9u : 0u) ||
                        depth.load_key(x, y, layer, level) != (cleared ? depth_key(Format::D24, 0.5) : 0u))
                        FAIL("level " << level << ", layer " << layer << ", pixel " << x << ", " << y);
                }
    CHECK((inside > 0) == !empty);
    const std::int64_t texels = std::int64_t{color.width(1)} * color.height(1);
    CHECK(pass.counters().bytes_written - pass.counters().fragments_passed * (4 + 8) == texels * (4 + 1 + 8));
}

TEST_CASE("a viewport beyond the largest target is refused") {
    PassLog log;
    Pass pass(log, "pass");
    Target depth(Format::D32F, 8, 8);
    const RandomScene scene(1, 1);
    PipelineState state;
    const auto vertex = [&](std::uint32_t i) { return scene.positions[i]; };
    for (const Rectangle& viewport : {Rectangle{0, 0, 32769, 8}, Rectangle{0, 0, 8, -1}, Rectangle{-40000, 0, 8, 8}}) {
        state.viewport = viewport;
        CHECK_THROWS_AS(draw(pass, scene.geometry(), state, vertex, depth_only, Targets{.depth = &depth}), UsageError);
    }
    state.viewport = Rectangle{-32768, 0, 32768, 32768};
    CHECK_NOTHROW(draw(pass, scene.geometry(), state, vertex, depth_only, Targets{.depth = &depth}));
}
