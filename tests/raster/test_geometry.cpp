#include <catch2/catch.hpp>

#include <cmath>
#include <set>
#include <tuple>

#include "raster/geometry.h"

using namespace gnomon;

namespace {

using Indices = std::vector<std::uint32_t>;
using Triangles = std::vector<uvec3>;

// Pixels of a 16×16 target that a draw covers, in clip-space vertices.
std::vector<int> covered(const std::vector<vec4>& positions, std::span<const uvec3> triangles,
                         PipelineState state = {}) {
    PassLog log;
    Pass pass(log, "cover");
    Target count(Format::S8, 16, 16);
    state.stencil.enabled = true;
    state.stencil.front.pass = state.stencil.back.pass = StencilOp::Increment;
    draw(
        pass, {static_cast<std::uint32_t>(positions.size()), triangles}, state,
        [&](std::uint32_t i) { return positions[i]; }, depth_only, Targets{.stencil = &count});
    std::vector<int> result;
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) result.push_back(static_cast<int>(count.load_key(x, y)));
    return result;
}

vec4 at_pixel(float x, float y, float w = 1.0f) { return vec4((x / 8 - 1) * w, (y / 8 - 1) * w, 0.0f, w); }

const Triangles quad_triangles = triangles_of_quads(sequence(4));

} // namespace

TEST_CASE("strips alternate so that every triangle winds alike and ends in its provoking vertex") {
    CHECK(triangles_of_strip(sequence(5)) == Triangles{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}});
    CHECK(triangles_of_strip(sequence(2)).empty());
    CHECK(triangles_of_fan(sequence(5)) == Triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
    CHECK(triangles_of_quads(sequence(9)) == Triangles{{0, 1, 3}, {1, 2, 3}, {4, 5, 7}, {5, 6, 7}});
    CHECK(triangles_of_quad_strip(sequence(7)) == Triangles{{2, 0, 3}, {0, 1, 3}, {4, 2, 5}, {2, 3, 5}});
}

TEST_CASE("the restart index begins a new primitive") {
    const std::uint32_t r = restart_index;
    CHECK(triangles_of_strip(Indices{7, 8, 9, 3, r, r, 1, 2, r, 4, 5, 6, r}) ==
          Triangles{{7, 8, 9}, {9, 8, 3}, {4, 5, 6}});
    CHECK(triangles_of_fan(Indices{7, 8, 9, r, 1, 2, 3, 4}) == Triangles{{7, 8, 9}, {1, 2, 3}, {1, 3, 4}});
    CHECK(triangles_of_quads(Indices{0, 1, r, 4, 5, 6, 7}) == Triangles{{4, 5, 7}, {5, 6, 7}});
    CHECK(triangles_of_strip(Indices{}).empty());
}

TEST_CASE("assembled primitives cover their area once, all facing front") {
    // Counter-clockwise primitives over the whole target; back faces would be culled.
    PipelineState front_only;
    front_only.cull = Cull::Back;
    const std::vector<int> once(256, 1);
    std::vector<vec4> zigzag; // columns of a band, and of a quad strip: lower vertex, upper vertex
    for (int i = 0; i <= 4; ++i) {
        zigzag.push_back(at_pixel(static_cast<float>(16 - 4 * i), 0));
        zigzag.push_back(at_pixel(static_cast<float>(16 - 4 * i), 16));
    }
    CHECK(covered(zigzag, triangles_of_strip(sequence(10)), front_only) == once);
    CHECK(covered(zigzag, triangles_of_quad_strip(sequence(10)), front_only) == once);
    const std::vector<vec4> corners = {at_pixel(0, 0), at_pixel(16, 0), at_pixel(16, 16), at_pixel(0, 16)};
    CHECK(covered(corners, triangles_of_fan(sequence(4)), front_only) == once);
    CHECK(covered(corners, quad_triangles, front_only) == once);
}

TEST_CASE("wide lines cover whole pixels across their minor axis") {
    const auto line = [](vec4 a, vec4 b, float width) {
        const auto wide = wide_line(a, b, width, {16, 16});
        REQUIRE(wide);
        PipelineState front_only;
        front_only.cull = Cull::Back; // a line has no back: its quad always faces front
        return covered({wide->corners.begin(), wide->corners.end()}, quad_triangles, front_only);
    };
    const auto total = [](const std::vector<int>& pixels) {
        int sum = 0;
        for (const int p : pixels) sum += p;
        return sum;
    };
    const float w = 3.0f; // of clip space; nothing may depend on it
    for (const float width : {1.0f, 2.0f, 3.0f}) {
        const int expected = static_cast<int>(width) * 12;
        CHECK(total(line(at_pixel(2, 5.3f), at_pixel(14, 9.1f), width)) == expected);
        CHECK(total(line(at_pixel(14, 5.3f, w), at_pixel(2, 9.1f), width)) == expected);
        CHECK(total(line(at_pixel(5.3f, 2), at_pixel(9.1f, 14, w), width)) == expected);
        CHECK(total(line(at_pixel(9.1f, 14), at_pixel(5.3f, 2), width)) == expected);
    }
    CHECK(total(line(at_pixel(2, 5.3f), at_pixel(14, 5.3f), 0.2f)) == 12); // never less than one pixel
    CHECK(total(line(at_pixel(2, 5.3f), at_pixel(14, 5.3f), 2.5f)) == 36); // rounded
    const std::vector<int> flat = line(at_pixel(2, 5.5f), at_pixel(14, 5.5f), 1.0f);
    for (size_t x = 0; x < 16; ++x) CHECK(flat[5 * 16 + x] == (x >= 2 && x < 14));
}

TEST_CASE("wide lines are cut at the near plane") {
    // From z = −2w, outside, to z = 0: cut half way, where z = −w.
    const vec4 a(0, 0, -2, 1), b(0.5f, 0, 0, 1);
    const auto line = wide_line(a, b, 1, {16, 16});
    REQUIRE(line);
    CHECK(line->along[0] == 0.5f);
    CHECK(line->along[1] == 1.0f);
    CHECK(line->corners[0].x == 0.25f);
    CHECK(line->corners[0].z == -1.0f);
    const auto back = wide_line(b, a, 1, {16, 16});
    REQUIRE(back);
    CHECK(back->along[1] == 0.5f);
    CHECK(back->corners[1].x == 0.25f);
    CHECK_FALSE(wide_line(a, a, 1, {16, 16}));
}

namespace {

struct Record {
    std::uint32_t primitive, number;
    bool operator==(const Record&) const = default;
};

// Primitive i emits a strip of (7·i) mod 5 + 2 vertices, and the first again as a triangle of its own.
Stream<Record> amplified(PassLog& log, std::uint32_t primitives) {
    Pass pass(log, "amplify");
    return amplify<Record>(pass, primitives, 6, [](std::uint32_t i, Emitter<Record>& out) {
        std::vector<Record> strip;
        for (std::uint32_t k = 0; k < 7 * i % 5 + 2; ++k) strip.push_back({i, k});
        out.strip(strip);
        if (i % 3 == 0) out.triangle(1, 0, 1);
        out.counters.texels_fetched += i;
    });
}

} // namespace

TEST_CASE("amplification emits in the order of the primitives, for any number of threads") {
    constexpr std::uint32_t primitives = 5000;
    PassLog log;
    const Stream<Record> one = amplified(log, primitives);
    std::vector<Record> vertices;
    Triangles triangles;
    for (std::uint32_t i = 0; i < primitives; ++i) {
        const auto first = static_cast<std::uint32_t>(vertices.size()), count = 7 * i % 5 + 2;
        for (std::uint32_t k = 0; k < count; ++k) vertices.push_back({i, k});
        const Triangles strip = triangles_of_strip(sequence(count));
        for (const uvec3& t : strip) triangles.push_back(t + uvec3(first));
        if (i % 3 == 0) triangles.push_back({first + 1, first, first + 1});
    }
    CHECK(std::equal(vertices.begin(), vertices.end(), one.vertices().begin(), one.vertices().end()));
    CHECK(std::equal(triangles.begin(), triangles.end(), one.triangles().begin(), one.triangles().end()));
    const PassCounters& counters = log.passes[0];
    CHECK(counters.draws == 1);
    CHECK(counters.vertices == primitives);
    CHECK(counters.texels_fetched == std::int64_t{primitives} * (primitives - 1) / 2);
    CHECK(counters.bytes_written == static_cast<std::int64_t>(vertices.size() * 8 + triangles.size() * 12));
    for (const int threads : {1, 2, 7})
        with_threads(threads, [&] {
            PassLog other_log;
            const Stream<Record> other = amplified(other_log, primitives);
            CHECK(std::equal(vertices.begin(), vertices.end(), other.vertices().begin(), other.vertices().end()));
            CHECK(std::equal(triangles.begin(), triangles.end(), other.triangles().begin(), other.triangles().end()));
            CHECK(other_log.passes[0].bytes_written == counters.bytes_written);
        });
}

TEST_CASE("a program that emits more than it declares is refused, one that emits nothing is not") {
    PassLog log;
    Pass pass(log, "amplify");
    CHECK_THROWS_AS(amplify<Record>(pass, 3, 2,
                                    [](std::uint32_t, Emitter<Record>& out) {
                                        for (std::uint32_t k = 0; k < 3; ++k) out.vertex({0, k});
                                    }),
                    UsageError);
    const Stream<Record> nothing = amplify<Record>(pass, 300, 4, [](std::uint32_t, Emitter<Record>&) {});
    CHECK(nothing.vertices().empty());
    CHECK(nothing.geometry().triangles.empty());
    const Stream<Record> none = amplify<Record>(pass, 0, 4, [](std::uint32_t, Emitter<Record>&) {});
    CHECK(none.vertices().empty());
}

TEST_CASE("what amplification leaves can be drawn") {
    // Each of 16 points becomes a quad over one column of the target.
    PassLog log;
    Pass pass(log, "columns");
    const Stream<vec4> columns = amplify<vec4>(pass, 16, 4, [](std::uint32_t i, Emitter<vec4>& out) {
        const auto x = static_cast<float>(i);
        out.strip({at_pixel(x, 0), at_pixel(x + 1, 0), at_pixel(x, 16), at_pixel(x + 1, 16)});
    });
    CHECK(columns.vertices().size() == 64);
    CHECK(covered({columns.vertices().begin(), columns.vertices().end()}, columns.geometry().triangles) ==
          std::vector<int>(256, 1));
}
