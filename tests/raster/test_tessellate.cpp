#include <catch2/catch.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include "raster/tessellate.h"

using namespace gnomon;

namespace {

constexpr PatchShape triangle = PatchShape::Triangle, quad = PatchShape::Quad;

// Where a point lies in the plane of an equilateral triangle or a unit square: area 1 each.
dvec2 place(PatchShape shape, const dvec4& w) {
    if (shape == quad) return {w.y + w.z, w.z + w.w};
    const double side = 2.0 / std::sqrt(std::sqrt(3.0));
    return {side * (w.y + 0.5 * w.z), side * std::sqrt(0.75) * w.z};
}

double signed_area(PatchShape shape, const PatchPattern& p, const uvec3& t) {
    const dvec2 a = place(shape, p.weights[t.x]), b = place(shape, p.weights[t.y]), c = place(shape, p.weights[t.z]);
    return 0.5 * ((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y));
}

// Positive triangles that add up to the patch, every point used, inner edges shared by exactly two triangles in
// opposite directions, and outer edges by one.
void check_tiling(PatchShape shape, const PatchPattern& pattern, size_t outer_edges) {
    double area = 0, least = 1;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    std::set<std::uint32_t> used;
    for (const uvec3& t : pattern.triangles) {
        const double a = signed_area(shape, pattern, t);
        area += a;
        least = std::min(least, a);
        for (int e = 0; e < 3; ++e) {
            ++edges[{t[e], t[(e + 1) % 3]}];
            used.insert(t[e]);
        }
    }
    REQUIRE(std::abs(area - 1.0) < 1e-12);
    REQUIRE(least > 0);
    REQUIRE(used.size() == pattern.weights.size());
    size_t open = 0;
    for (const auto& [edge, times] : edges) {
        REQUIRE(times == 1);
        open += edges.count({edge.second, edge.first}) == 0;
    }
    REQUIRE(open == outer_edges);
    for (const dvec4& w : pattern.weights) {
        REQUIRE(std::abs(w.x + w.y + w.z + w.w - 1.0) < 1e-15);
        REQUIRE(std::min({w.x, w.y, w.z, w.w}) >= 0.0);
    }
}

} // namespace

TEST_CASE("uniform tessellation has the counts of concentric rings") {
    for (int n = 1; n <= 64; ++n) {
        const PatchPattern t = tessellate_patch(triangle, Spacing::Equal, PatchLevels::uniform(static_cast<float>(n)));
        const auto half = static_cast<size_t>((n + 1) / 2);
        CHECK(t.weights.size() == (n % 2 ? 3 * half * half : 1 + 3 * half * (half + 1)));
        CHECK(t.triangles.size() == static_cast<size_t>(n % 2 ? (3 * n * n - 1) / 2 : 3 * n * n / 2));
        check_tiling(triangle, t, static_cast<size_t>(3 * n));
        const PatchPattern q = tessellate_patch(quad, Spacing::Equal, PatchLevels::uniform(static_cast<float>(n)));
        CHECK(q.weights.size() == static_cast<size_t>((n + 1) * (n + 1)));
        CHECK(q.triangles.size() == static_cast<size_t>(2 * n * n));
        check_tiling(quad, q, static_cast<size_t>(4 * n));
    }
    const PatchPattern one = tessellate_patch(triangle, Spacing::Equal, {});
    CHECK(one.weights == std::vector<dvec4>{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}});
}

TEST_CASE("any factors tile the patch") {
    const Spacing spacing = GENERATE(Spacing::Equal, Spacing::FractionalOdd, Spacing::FractionalEven);
    const PatchShape shape = GENERATE(PatchShape::Triangle, PatchShape::Quad);
    std::mt19937 random(7);
    const auto pieces = [&](float f) { // of an edge with this factor
        if (spacing == Spacing::Equal) return static_cast<int>(std::ceil(f));
        if (spacing == Spacing::FractionalEven) return static_cast<int>(std::ceil(f / 2)) * 2;
        return static_cast<int>(std::ceil((f - 1) / 2)) * 2 + 1;
    };
    for (int i = 0; i < 400; ++i) {
        PatchLevels levels;
        for (float& f : levels.outer)
            f = random() % 4 ? static_cast<float>(random() % 1500) / 100.0f + 1.0f
                             : static_cast<float>(random() % 9 + 1);
        for (float& f : levels.inner) f = static_cast<float>(random() % 1200) / 100.0f;
        size_t outer = 0;
        for (size_t e = 0; e < (shape == triangle ? 3 : 4); ++e)
            outer += static_cast<size_t>(std::max(pieces(levels.outer[e]), spacing == Spacing::FractionalEven ? 2 : 1));
        check_tiling(shape, tessellate_patch(shape, spacing, levels), outer);
    }
    // A whole outline with a divided inside, and the other way round.
    PatchLevels inside;
    inside.inner = {5, 5};
    const size_t whole = (shape == triangle ? 3u : 4u) * (spacing == Spacing::FractionalEven ? 2 : 1);
    check_tiling(shape, tessellate_patch(shape, spacing, inside), whole);
    PatchLevels outside = PatchLevels::uniform(6);
    outside.inner = {1, 1};
    check_tiling(shape, tessellate_patch(shape, spacing, outside),
                 (shape == triangle ? 3u : 4u) * (spacing == Spacing::FractionalOdd ? 7 : 6));
}

TEST_CASE("fractional spacing grows its end pieces with the factor") {
    const auto bottom = [](float f) { // u of the points on v = 0
        PatchLevels levels = PatchLevels::uniform(f);
        const PatchPattern p = tessellate_patch(quad, Spacing::FractionalOdd, levels);
        std::vector<double> u;
        for (const dvec4& w : p.weights)
            if (w.z == 0 && w.w == 0) u.push_back(w.y);
        std::sort(u.begin(), u.end());
        return u;
    };
    CHECK(bottom(1.0f) == std::vector<double>{0, 1});
    CHECK(bottom(3.0f) == std::vector<double>{0, 1.0 / 3, 2.0 / 3, 1});
    CHECK(bottom(4.0f) == std::vector<double>{0, 0.125, 0.375, 0.625, 0.875, 1}); // three of ¼, two of ⅛
    CHECK(bottom(5.0f) == std::vector<double>{0, 0.2, 0.4, 0.6, 0.8, 1});
    CHECK(bottom(3.001f)[1] < 0.001);
    CHECK(bottom(63.0f).size() == 64);
    CHECK(bottom(1e9f).size() == 64);
}

TEST_CASE("patches with an edge factor that is not above zero are culled") {
    PatchLevels levels = PatchLevels::uniform(3);
    levels.outer[1] = 0;
    CHECK(tessellate_patch(triangle, Spacing::Equal, levels).triangles.empty());
    levels.outer[1] = std::nanf("");
    CHECK(tessellate_patch(quad, Spacing::FractionalOdd, levels).triangles.empty());
    levels = PatchLevels::uniform(3);
    levels.outer[3] = -1;
    CHECK(tessellate_patch(triangle, Spacing::Equal, levels).triangles.size() == 13); // triangles have three
    levels.inner = {std::nanf(""), std::nanf("")};
    CHECK(tessellate_patch(triangle, Spacing::Equal, levels).triangles.size() == 9); // a fan around the middle
    levels = PatchLevels::uniform(1);
    levels.inner[0] = -5;
    CHECK(tessellate_patch(triangle, Spacing::Equal, levels).triangles.size() == 1);
}

TEST_CASE("edge factors depend on the end points alone") {
    CHECK(edge_level({0, 0}, {1, 0}, 0.125f, 16) == 8.0f);
    CHECK(edge_level({0, 0}, {3, 4}, 0.5f, 64) == 10.0f);
    CHECK(edge_level({0, 0}, {9, 0}, 0.125f, 16) == 16.0f);
    CHECK(edge_level({0, 0}, {0, 0}, 0.125f, 16) == 1.0f);
    CHECK(edge_level({0, 0}, {std::nanf(""), 0}, 0.125f, 16) == 1.0f);
    std::mt19937 random(1);
    const auto any = [&] { return vec2(static_cast<float>(random()), static_cast<float>(random())) * 1e-9f; };
    for (int i = 0; i < 1000; ++i) {
        const vec2 a = any(), b = any();
        CHECK(edge_level(a, b, 0.01f, 64) == edge_level(b, a, 0.01f, 64));
    }
    CHECK(PatchLevels::from_edges(triangle, {2, 5, 3, 99}).inner[0] == 5.0f);
    CHECK(PatchLevels::from_edges(quad, {2, 5, 3, 4}).inner == std::array<float, 2>{5.0f, 3.0f});
}

namespace {

using Key = std::array<std::uint32_t, 3>;
Key bits(vec3 p) {
    return {std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y), std::bit_cast<std::uint32_t>(p.z)};
}

// A jittered mesh of n×n cells with awkward coordinates, its triangles' corners rotated and mirrored at random.
struct Mesh {
    std::vector<vec3> points;
    std::vector<uvec3> triangles;
};
Mesh awkward_mesh(int n) {
    std::mt19937 random(21);
    Mesh mesh;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
            mesh.points.push_back(vec3(i, j, 0) * 0.1f +
                                  vec3(random() % 1000, random() % 1000, random() % 1000) * 3.7e-5f);
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const auto at = [&](int di, int dj) { return static_cast<std::uint32_t>((j + dj) * (n + 1) + i + di); };
            for (uvec3 t : {uvec3(at(0, 0), at(1, 0), at(1, 1)), uvec3(at(0, 0), at(1, 1), at(0, 1))}) {
                for (auto turns = random() % 3; turns > 0; --turns) t = {t.y, t.z, t.x};
                mesh.triangles.push_back(random() % 2 ? t : uvec3(t.y, t.x, t.z));
            }
        }
    return mesh;
}

} // namespace

TEST_CASE("neighbouring patches share the bits of every point on their edge") {
    const Spacing spacing = GENERATE(Spacing::Equal, Spacing::FractionalOdd, Spacing::FractionalEven);
    const Mesh mesh = awkward_mesh(12);
    const auto corner = [&](std::uint32_t patch, int i) { return mesh.points[mesh.triangles[patch][i]]; };
    const auto level = [&](vec3 a, vec3 b) {
        return spacing == Spacing::Equal ? edge_level(vec2(a), vec2(b), 0.011f, 16)
                                         : std::max(1.0f, glm::length(vec2(a - b)) / 0.011f);
    };
    PassLog log;
    Pass pass(log, "tessellate");
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    const Stream<PatchPoint> stream = tessellate(pass, count, triangle, spacing, [&](std::uint32_t i) {
        const vec3 a = corner(i, 0), b = corner(i, 1), c = corner(i, 2);
        return PatchLevels::from_edges(triangle, {level(b, c), level(c, a), level(a, b), 0});
    });
    // The points that each patch has on each of its edges, by the edge's points in the mesh.
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::set<Key>>> edges;
    std::map<std::pair<std::uint32_t, int>, std::set<Key>> of_patch;
    for (const PatchPoint& p : stream.vertices())
        for (int e = 0; e < 3; ++e) // opposite to corner e
            if (p.weights[e] == 0.0f)
                of_patch[{p.patch, e}].insert(
                    bits(patch_value(p.weights, corner(p.patch, 0), corner(p.patch, 1), corner(p.patch, 2))));
    for (const auto& [key, points] : of_patch) {
        const uvec3 t = mesh.triangles[key.first];
        edges[std::minmax(t[(key.second + 1) % 3], t[(key.second + 2) % 3])].push_back(points);
    }
    int shared = 0, different = 0;
    size_t most = 0;
    for (const auto& [edge, sets] : edges) {
        if (sets.size() != 2) continue;
        ++shared;
        different += sets[0] != sets[1];
        most = std::max(most, sets[0].size());
        // The mesh's own points are among them, unchanged.
        different += !sets[0].count(bits(mesh.points[edge.first])) || !sets[1].count(bits(mesh.points[edge.second]));
    }
    CHECK(shared == 2 * 12 * 11 + 12 * 12);
    CHECK(different == 0);
    CHECK(most > 8);
    CHECK(log.passes[0].vertices == count);
}

TEST_CASE("quads share the bits of every point on their edge, however they are turned") {
    const vec3 a(0.1f, 0.7f, 0.3f), b(0.9f, 0.2f, 0.77f), c(1.3f, 1.1f, 0.4f), d(0.05f, 1.2f, 0.9f);
    const vec3 e(0.4f, -0.8f, 0.2f), f(1.2f, -0.9f, 0.6f);
    const float shared_level = 6.3f;
    // Quad (a, b, c, d) has the edge ab on v = 0; the other has it on each of its sides in turn, in either direction.
    const auto points_on = [&](std::array<vec3, 4> corners, vec3 p, vec3 q) {
        PatchLevels levels = PatchLevels::uniform(3);
        constexpr std::array<size_t, 4> outer_of_side = {1, 2, 3, 0};
        for (size_t s = 0; s < 4; ++s) {
            const vec3 from = corners[s], to = corners[(s + 1) % 4];
            if ((from == p && to == q) || (from == q && to == p)) levels.outer[outer_of_side[s]] = shared_level;
        }
        const PatchPattern pattern = tessellate_patch(quad, Spacing::FractionalOdd, levels);
        std::set<Key> points;
        for (const dvec4& w : pattern.weights) {
            const vec4 v(w);
            bool on = true;
            for (int k = 0; k < 4; ++k)
                on &= v[k] == 0.0f || corners[static_cast<size_t>(k)] == p || corners[static_cast<size_t>(k)] == q;
            if (on) points.insert(bits(patch_value(v, corners[0], corners[1], corners[2], corners[3])));
        }
        return points;
    };
    const std::set<Key> reference = points_on({a, b, c, d}, a, b);
    CHECK(reference.size() == 8);
    std::array<vec3, 4> other = {b, a, e, f};
    for (int turn = 0; turn < 4; ++turn) {
        CHECK(points_on(other, a, b) == reference);
        CHECK(points_on({other[3], other[2], other[1], other[0]}, a, b) == reference);
        std::rotate(other.begin(), other.begin() + 1, other.end());
    }
}

TEST_CASE("tessellation gives the same stream for any number of threads") {
    const auto run = [](int threads) {
        std::vector<float> result;
        with_threads(threads, [&] {
            PassLog log;
            Pass pass(log, "tessellate");
            const Stream<PatchPoint> stream = tessellate(pass, 1500, quad, Spacing::FractionalOdd, [](std::uint32_t i) {
                return PatchLevels::uniform(static_cast<float>(i % 37) * 0.17f);
            });
            for (const PatchPoint& p : stream.vertices())
                for (int k = 0; k < 4; ++k) result.push_back(p.weights[k] + static_cast<float>(p.patch));
            for (const uvec3& t : stream.triangles()) result.push_back(static_cast<float>(t.x + 3 * t.y + 7 * t.z));
        });
        return result;
    };
    const auto one = run(1);
    CHECK(one.size() > 10000);
    CHECK(run(2) == one);
    CHECK(run(7) == one);
}
