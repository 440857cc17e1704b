#include <catch2/catch.hpp>

#include <algorithm>
#include <cstring>

#include "raster/bins.h"
#include "raster/draw.h"

using namespace gnomon;

namespace {

constexpr int side = 4096; // 64 × 64 tiles, as many as it takes for the largest chunks
constexpr size_t largest_chunk = 16384, batch = 64 * largest_chunk;

struct Triangles {
    std::vector<vec4> positions;
    std::vector<uvec3> triangles;

    void add(vec3 a, vec3 b, vec3 c) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (const vec3 p : {a, b, c}) positions.emplace_back(p, 1.0f);
        triangles.push_back({first, first + 1, first + 2});
    }
    // Corners in pixels.
    void add_in_window(vec2 a, vec2 b, vec2 c) {
        const auto ndc = [](vec2 p) { return vec3(p / (0.5f * side) - 1.0f, 0.0f); };
        add(ndc(a), ndc(b), ndc(c));
    }
};

// Counts the fragments of every pixel in `stencil`; the triangles are drawn in so many draws.
PassLog count_fragments(const Triangles& scene, Target& stencil, size_t draws) {
    PipelineState state;
    state.stencil.enabled = true;
    state.stencil.front.pass = state.stencil.back.pass = StencilOp::IncrementWrap;
    PassLog log;
    Pass pass(log, "count");
    const std::span<const uvec3> all(scene.triangles);
    for (size_t i = 0; i < draws; ++i)
        draw(
            pass,
            {static_cast<std::uint32_t>(scene.positions.size()),
             all.subspan(i * all.size() / draws, all.size() / draws)},
            state, [&](std::uint32_t v) { return scene.positions[v]; }, depth_only, Targets{.stencil = &stencil});
    return log;
}

// A chunk's worth of small triangles, each on the corner of four tiles.
Triangles small_triangles() {
    Triangles scene;
    for (size_t i = 0; i < largest_chunk; ++i) {
        const vec2 tile(64.0f * static_cast<float>(i % 64), 64.0f * static_cast<float>(i / 64 % 64));
        scene.add_in_window(tile + vec2(-2, -2), tile + vec2(3, -1), tile + vec2(1, 3));
    }
    return scene;
}

// A chunk's worth of thin ones that touch some hundred tiles and, every other, some forty.
Triangles long_triangles() {
    Triangles scene;
    for (size_t i = 0; i < largest_chunk; ++i) {
        const float along = static_cast<float>(i % 61), up = 64.0f * static_cast<float>(i / 2 % 64);
        if (i % 2 == 0)
            scene.add_in_window({along, 0}, {side - 1, side - along - 0.1f}, {side - 1, side - along});
        else
            scene.add_in_window({along, up + 9.5f}, {along + 2600, up + 30}, {along + 2600, up + 30.1f});
    }
    return scene;
}

} // namespace

TEST_CASE("the memory of the bins is bounded, whatever is drawn") { // by what raster/bins.h says
    Target stencil(Format::S8, side, side);
    const size_t long_bytes = detail::bin_bytes(count_fragments(long_triangles(), stencil, 1));
    INFO("a chunk of long triangles: " << long_bytes << " bytes");
    CHECK(long_bytes > largest_chunk * sizeof(SetupTriangle)); // they are all there
    CHECK(long_bytes <= size_t{7} << 20);

    Triangles scene = small_triangles();
    const std::vector<uvec3> chunk = scene.triangles;
    const auto repeat = [&](size_t triangles) {
        while (scene.triangles.size() < triangles)
            scene.triangles.insert(scene.triangles.end(), chunk.begin(), chunk.end());
    };
    repeat(batch);
    const size_t one_batch = detail::bin_bytes(count_fragments(scene, stencil, 1));
    repeat(2 * batch);
    const size_t two_batches = detail::bin_bytes(count_fragments(scene, stencil, 1));
    INFO("a batch of small ones: " << one_batch << " bytes, two: " << two_batches);
    CHECK(one_batch > batch * sizeof(SetupTriangle));
    CHECK(one_batch <= size_t{448} << 20);
    CHECK(two_batches == one_batch);
}

TEST_CASE("a chunk whose triangles are all cut into five pieces draws each of them") {
    // In units of half the target, a corner inside of it and a polygon that the guard band (8) and the far plane give
    // four more and one more corner.
    Triangles scene;
    for (size_t i = 0; i < largest_chunk; ++i) {
        const float y = static_cast<float>(i) / largest_chunk - 0.5f;
        const auto corner = [](float x, float up) { return vec3(x, up, (x + up) / 15.6f); };
        scene.add(corner(0.997f, y), corner(2, -16), corner(26, 32));
    }
    Target whole(Format::S8, side, side), parts(Format::S8, side, side);
    const PassCounters one = count_fragments(scene, whole, 1).passes.back(),
                       many = count_fragments(scene, parts, 16).passes.back();
    CHECK(one.clipped == static_cast<std::int64_t>(largest_chunk));
    CHECK(one.fragments_covered == many.fragments_covered);
    CHECK(std::memcmp(whole.texel(0, 0, 0), parts.texel(0, 0, 0), static_cast<size_t>(whole.bytes())) == 0);
}

TEST_CASE("large triangles reach every tile that they cover, once", "[bits]") {
    // A fan from within the target to points around it: its triangles cover every pixel, and no pixel twice.
    const vec2 centre = GENERATE(vec2(2049.3f, 2051.7f), vec2(700.2f, 3900.1f));
    Triangles scene;
    constexpr int rim = 172;
    const auto around = [](int i) {
        const float along = static_cast<float>(i % (rim / 4)) / (rim / 4) * (side + 2) - 1;
        const int edge = i % rim / (rim / 4);
        return edge == 0   ? vec2(along, -1)
               : edge == 1 ? vec2(side + 1, along)
               : edge == 2 ? vec2(side - along, side + 1)
                           : vec2(-1, side - along);
    };
    for (int i = 0; i < rim; ++i) scene.add_in_window(centre, around(i), around(i + 1));
    Target counts(Format::S8, side, side);
    count_fragments(scene, counts, 1);
    const auto* begin = reinterpret_cast<const std::uint8_t*>(counts.texel(0, 0, 0));
    CHECK(std::count(begin, begin + counts.bytes(), 1) == counts.bytes());
}
