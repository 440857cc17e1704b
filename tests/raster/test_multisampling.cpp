#include <catch2/catch.hpp>

#include <random>

#include "raster/passes/resolve.h"
#include "tests/raster/scalar.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

constexpr int side = 64;

// The triangle moved so that the sample lies where the centre was.
FixedTriangle as_seen_by(FixedTriangle t, glm::ivec2 position) {
    for (FixedVertex& v : t.v) v.x -= position.x - 128, v.y -= position.y - 128;
    return t;
}

std::vector<FixedTriangle> random_triangles(unsigned seed, int count) {
    std::mt19937 random(seed);
    std::vector<FixedTriangle> triangles(static_cast<size_t>(count));
    for (FixedTriangle& t : triangles) {
        const int reach = random() % 2 ? 30000 : 1500;
        const int x = static_cast<int>(random() % (side * 256)), y = static_cast<int>(random() % (side * 256));
        for (FixedVertex& v : t.v) {
            v.x = x + static_cast<int>(random() % static_cast<unsigned>(2 * reach)) - reach;
            v.y = y + static_cast<int>(random() % static_cast<unsigned>(2 * reach)) - reach;
            v.z = static_cast<float>(262144 + random() % 524288) / 1048576.0f;
        }
    }
    return triangles;
}

struct Multisampled {
    PassLog log;
    Target depth, color;
    explicit Multisampled(int samples)
        : depth(Format::D32F, side, side, samples), color(Format::R32UI, side, side, samples) {}
};

template <class Program>
void draw_fixed(Multisampled& m, const std::vector<FixedTriangle>& triangles, int samples, const Program& program,
                FragmentFlags flags) {
    std::vector<vec4> positions;
    std::vector<uvec3> indices;
    for (const FixedTriangle& t : triangles) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        indices.push_back({first, first + 1, first + 2});
        for (const FixedVertex& v : t.v) positions.push_back(to_clip(v, side, side));
    }
    Pass pass(m.log, "draw");
    m.depth.clear_depth(pass, 1.0f);
    PipelineState state;
    state.depth = {.test = Compare::Less, .write = true};
    draw(
        pass, {static_cast<std::uint32_t>(positions.size()), indices}, state,
        [&](std::uint32_t i) { return positions[i]; }, FragmentProgram<Program>{program, flags},
        Targets{.depth = &m.depth, .color = {&m.color}, .samples = samples});
}

} // namespace

TEST_CASE("every sample is a pixel of its own, bit for bit", "[bits]") {
    const int samples = GENERATE(4, 8);
    const bool per_sample = GENERATE(false, true);
    const std::vector<FixedTriangle> triangles = random_triangles(static_cast<unsigned>(samples), 300);
    Multisampled m(samples);
    const auto program = [](const Fragment<NoVaryings>& in, FragmentOutput& out) {
        out.color[0].x = glm::uintBitsToFloat(in.primitive + 1);
    };
    draw_fixed(m, triangles, samples, program, {.per_sample = per_sample});
    std::int64_t wrong = 0, covered = 0, passed = 0;
    for (int s = 0; s < samples; ++s) {
        const glm::ivec2 position = sample_positions(samples)[static_cast<size_t>(s)];
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                float z = 1.0f;
                std::uint32_t id = 0;
                for (std::uint32_t i = 0; i < triangles.size(); ++i) {
                    const FixedTriangle t = as_seen_by(triangles[i], position);
                    if (!covers(t, x, y)) continue;
                    ++covered;
                    const auto fresh = static_cast<float>(depth(t, x, y));
                    if (fresh >= z) continue;
                    ++passed;
                    z = fresh, id = i + 1;
                }
                wrong += m.depth.depth(x, y, s) != z || m.color.load_key(x, y, s) != id;
            }
    }
    CHECK(wrong == 0);
    const PassCounters& counters = m.log.passes.back();
    CHECK(counters.fragments_covered == covered); // samples are what occlusion queries count
    CHECK(counters.fragments_passed == passed);
    if (per_sample)
        CHECK(counters.fragments_shaded == passed);
    else
        CHECK(counters.fragments_shaded < passed / 2);
}

TEST_CASE("a discarded fragment is discarded in all samples, and one with a depth of its own keeps it") {
    Multisampled m(4);
    const std::vector<FixedTriangle> wall = {{{{-1000, -1000, 0.5f}, {40000, -1000, 0.5f}, {-1000, 40000, 0.5f}}}};
    const auto program = [](const Fragment<NoVaryings>& in, FragmentOutput& out) {
        out.color[0].x = glm::uintBitsToFloat(7);
        out.depth = 0.25f;
        out.discarded = in.pixel.x % 2 == 0;
    };
    draw_fixed(m, wall, 4, program, {.discards = true, .writes_depth = true});
    for (int s = 0; s < 4; ++s) {
        CHECK(m.color.load_key(4, 4, s) == 0);
        CHECK(m.color.load_key(5, 4, s) == 7);
        CHECK(m.depth.depth(4, 4, s) == 1.0f);
        CHECK(m.depth.depth(5, 4, s) == 0.25f);
    }
}

TEST_CASE("resolving averages the samples, or takes one of them") {
    PassLog log;
    Pass pass(log, "resolve");
    Target multi(Format::R32F, 2, 1, 8), single(Format::R32F, 2, 1, 2);
    for (int layer = 0; layer < 8; ++layer) multi.store(0, 0, layer, vec4(static_cast<float>(layer)));
    resolve_samples(pass, multi, single, 4);
    CHECK(single.load(0, 0, 0).x == 1.5f);
    CHECK(single.load(0, 0, 1).x == 5.5f);
    resolve_samples(pass, multi, single, 4, ResolveMode::Maximum);
    CHECK(single.load(0, 0, 1).x == 7.0f);
    resolve_samples(pass, multi, single, 4, ResolveMode::Sample0);
    CHECK(single.load(0, 0, 1).x == 4.0f);
    Target depths(Format::D32F, 2, 1, 4), depth(Format::D32F, 2, 1);
    CHECK_THROWS_AS(resolve_samples(pass, depths, depth, 4), UsageError);
    CHECK_THROWS_AS(resolve_samples(pass, multi, single, 8), UsageError);
}
