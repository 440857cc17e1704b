// Counters of small draws, derived by hand: a target of 4×4 pixels, of which every figure can be counted on a sheet of
// paper. Run for every instruction set with the other tests of bits.

#include <catch2/catch.hpp>

#include "core/parallel.h"
#include "raster/draw.h"

using namespace gnomon;

namespace {

constexpr int side = 4;

// Rectangles of whole pixels, two triangles each, over the lower left of the target.
struct Quads {
    std::vector<vec4> positions;
    std::vector<uvec3> triangles;

    void add(int x0, int y0, int x1, int y1, float z, bool clockwise = false) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        const auto ndc = [](int pixel) { return static_cast<float>(pixel) * (2.0f / side) - 1.0f; };
        for (const int y : {y0, y1})
            for (const int x : {x0, x1}) positions.emplace_back(ndc(x), ndc(y), z, 1.0f);
        triangles.push_back({first, first + 1, first + 2});
        triangles.push_back({first + 2, first + 1, first + 3});
        if (!clockwise) return;
        for (size_t i = triangles.size() - 2; i < triangles.size(); ++i) std::swap(triangles[i].y, triangles[i].z);
    }
    Geometry geometry() const { return {static_cast<std::uint32_t>(positions.size()), triangles}; }
};

struct Counted {
    PassLog log;
    Target depth{Format::D32F, side, side}, stencil{Format::S8, side, side}, color{Format::RGBA8, side, side};

    template <class Program>
    PassCounters draw(const Quads& quads, const PipelineState& state, const Targets& targets, const Program& program) {
        Pass pass(log, "draw");
        gnomon::draw(
            pass, quads.geometry(), state, [&](std::uint32_t i) { return quads.positions[i]; }, program, targets);
        return pass.counters();
    }
    void clear() {
        Pass pass(log, "clear");
        depth.clear_depth(pass, 1.0f);
        stencil.clear_uint(pass, 0);
        color.clear(pass, vec4(0.0f));
    }
};

const auto white = [](const Fragment<NoVaryings>&, FragmentOutput& out) { out.color[0] = vec4(1.0f); };

PipelineState depth_state() {
    PipelineState state;
    state.depth = {.test = Compare::Less, .write = true};
    return state;
}

} // namespace

TEST_CASE("counters of depth and colour are what one counts by hand", "[bits]") {
    for (const int threads : {1, 2, 7})
        with_threads(threads, [&] {
            Counted c;
            c.clear();
            CHECK(c.log.passes.back().bytes_written == 16 * (4 + 1 + 4));
            Quads near, far;
            near.add(0, 0, 2, 4, 0.0f);
            far.add(0, 0, 3, 4, 0.5f);
            const Targets targets{.depth = &c.depth, .color = {&c.color}};
            const PassCounters first = c.draw(near, depth_state(), targets, white);
            CHECK(first.draws == 1);
            CHECK(first.vertices == 4);
            CHECK(first.triangles == 2);
            CHECK(first.clipped == 0);
            CHECK(first.culled == 0);
            CHECK(first.fragments_covered == 8);
            CHECK(first.fragments_passed == 8);
            CHECK(first.fragments_shaded == 8);
            CHECK(first.texels_fetched == 0);
            CHECK(first.bytes_read == 8 * 4);          // depth
            CHECK(first.bytes_written == 8 * (4 + 4)); // depth and colour
            // Of the wider one behind it only the third column passes; tests come before the program.
            const PassCounters second = c.draw(far, depth_state(), targets, white);
            CHECK(second.fragments_covered == 12);
            CHECK(second.fragments_passed == 4);
            CHECK(second.fragments_shaded == 4);
            CHECK(second.bytes_read == 12 * 4);
            CHECK(second.bytes_written == 4 * (4 + 4));
        });
}

TEST_CASE("a load operation is counted as the clear that it is", "[bits]") {
    Counted c;
    Quads quads;
    quads.add(0, 0, 2, 4, 0.0f);
    const PassCounters counters = c.draw(quads, depth_state(), {.depth = &c.depth, .clear_depth = 1.0f}, depth_only);
    CHECK(counters.fragments_passed == 8);
    CHECK(counters.fragments_shaded == 0);
    CHECK(counters.bytes_written == 16 * 4 + 8 * 4);
}

TEST_CASE("counters of what is culled and clipped are what one counts by hand", "[bits]") {
    Counted c;
    c.clear();
    Quads quads;
    quads.add(0, 0, 2, 2, 0.0f);       // two triangles that stay
    quads.add(0, 0, 2, 2, 0.0f, true); // two that face away
    quads.add(5, 0, 6, 1, 0.0f);       // two beside the target
    quads.add(1, 1, 1, 3, 0.0f);       // two without area
    PipelineState state = depth_state();
    state.cull = Cull::Back;
    const PassCounters counters = c.draw(quads, state, {.depth = &c.depth}, depth_only);
    CHECK(counters.triangles == 8);
    CHECK(counters.culled == 6);
    CHECK(counters.clipped == 0);
    CHECK(counters.fragments_covered == 4);

    // A triangle over the whole target whose depth grows with x and meets the near plane in the middle.
    Quads cut;
    cut.positions = {{-1, -1, -2, 1}, {3, -1, 2, 1}, {-1, 3, -2, 1}};
    cut.triangles = {{0, 1, 2}};
    c.clear();
    const PassCounters clipped = c.draw(cut, depth_state(), {.depth = &c.depth}, depth_only);
    CHECK(clipped.triangles == 1);
    CHECK(clipped.clipped == 1);
    CHECK(clipped.culled == 0);
    CHECK(clipped.fragments_covered == 8); // the right half

    // One between the pixel centres.
    Quads between;
    between.positions = {{-0.95f, -0.95f, 0, 1}, {-0.85f, -0.95f, 0, 1}, {-0.95f, -0.85f, 0, 1}};
    between.triangles = {{0, 1, 2}};
    CHECK(c.draw(between, depth_state(), {.depth = &c.depth}, depth_only).culled == 1);
}

TEST_CASE("counters of stencil volumes are what one counts by hand", "[bits]") {
    for (const bool general : {false, true}) {
        Counted c;
        c.clear();
        Quads surface, volume;
        surface.add(0, 0, 4, 4, 0.0f);
        c.draw(surface, depth_state(), {.depth = &c.depth}, depth_only);
        volume.add(0, 0, 3, 4, -0.5f);      // 12 fragments that pass
        volume.add(0, 0, 2, 4, 0.5f, true); // 8 that fail
        PipelineState state;
        state.depth = {.test = Compare::Less, .write = false};
        state.stencil.enabled = true;
        state.stencil.front.depth_fail = StencilOp::DecrementWrap;
        state.stencil.back.depth_fail = general ? StencilOp::Increment : StencilOp::IncrementWrap;
        const PassCounters counters = c.draw(volume, state, {.depth = &c.depth, .stencil = &c.stencil}, depth_only);
        CHECK(counters.fragments_covered == 20);
        CHECK(counters.fragments_passed == 12);
        CHECK(counters.bytes_read == 20 * (4 + 1));
        CHECK(counters.bytes_written == 8); // the counts that change
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) CHECK(c.stencil.load_key(x, y) == (x < 2 ? 1u : 0u));
    }
}

TEST_CASE("counters of discard, blending and samples are what one counts by hand", "[bits]") {
    Quads quads;
    quads.add(0, 0, 2, 4, 0.0f);
    {
        Counted c; // a program that may discard runs before the tests
        c.clear();
        const auto even_rows = [](const Fragment<NoVaryings>& in, FragmentOutput& out) {
            out.color[0] = vec4(1.0f);
            out.discarded = in.pixel.y % 2 == 1;
        };
        const PassCounters counters = c.draw(quads, depth_state(), {.depth = &c.depth, .color = {&c.color}},
                                             FragmentProgram<decltype(even_rows)>{even_rows, {.discards = true}});
        CHECK(counters.fragments_covered == 8);
        CHECK(counters.fragments_shaded == 8);
        CHECK(counters.fragments_passed == 4);
        CHECK(counters.bytes_read == 4 * 4);
        CHECK(counters.bytes_written == 4 * (4 + 4));
    }
    {
        Counted c;
        c.clear();
        PipelineState state = depth_state();
        state.blend = BlendState::add();
        const PassCounters counters = c.draw(quads, state, {.depth = &c.depth, .color = {&c.color}}, white);
        CHECK(counters.bytes_read == 8 * (4 + 4)); // depth, and the colour under it
        CHECK(counters.bytes_written == 8 * (4 + 4));
    }
    {
        PassLog log;
        Target color(Format::RGBA8, side, side, 4);
        Pass pass(log, "samples");
        draw(
            pass, quads.geometry(), {}, [&](std::uint32_t i) { return quads.positions[i]; }, white,
            Targets{.color = {&color}, .samples = 4});
        CHECK(pass.counters().fragments_covered == 8 * 4); // samples
        CHECK(pass.counters().fragments_passed == 8 * 4);
        // Once a pixel and triangle: the diagonal parts the samples of four pixels.
        CHECK(pass.counters().fragments_shaded == 8 + 4);
        CHECK(pass.counters().bytes_written == 8 * 4 * 4);
    }
}
