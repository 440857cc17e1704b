#include "core/adjacency.h"

#include <algorithm>
#include <array>
#include <bit>

#include "core/parallel.h"
#include "core/random.h"

namespace gnomon {
namespace {

constexpr size_t grain = size_t{1} << 15;
constexpr std::uint32_t empty_slot = 0xffffffffu;

// Equal positions share bits once −0 is +0: adding +0 does that.
std::array<std::uint32_t, 3> position_bits(vec3 p) {
    return {std::bit_cast<std::uint32_t>(p.x + 0.0f), std::bit_cast<std::uint32_t>(p.y + 0.0f),
            std::bit_cast<std::uint32_t>(p.z + 0.0f)};
}

// Maps every vertex to the welded one at its position, numbered in order of first use by a vertex, through a hash table
// with open addressing.
std::vector<std::uint32_t> weld(const Scene& scene, std::vector<vec3>& welded) {
    const size_t count = scene.positions.size();
    std::vector<std::uint32_t> hashes(count);
    parallel_for(count, grain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const auto bits = position_bits(scene.positions[i]);
            hashes[i] = hash(bits[0], bits[1], bits[2]);
        }
    });
    const size_t capacity = std::bit_ceil(std::max<size_t>(16, 2 * count)), mask = capacity - 1;
    std::vector<std::uint32_t> table(capacity, empty_slot), welded_of(count);
    welded.reserve(count);
    for (size_t i = 0; i < count; ++i) {
        const vec3 p = scene.positions[i] + 0.0f;
        size_t slot = hashes[i] & mask;
        while (table[slot] != empty_slot && welded[table[slot]] != p) slot = (slot + 1) & mask;
        if (table[slot] == empty_slot) {
            table[slot] = static_cast<std::uint32_t>(welded.size());
            welded.push_back(p);
        }
        welded_of[i] = table[slot];
    }
    return welded_of;
}

// One side of a triangle: its edge's end (the larger index), the triangle, and whether it runs from the larger to the
// smaller.
struct Side {
    std::uint32_t end;
    std::uint32_t triangle;
    bool backwards;
};

// Sides bucketed by their edge's start (a counting sort), in order of triangle within a bucket; `first` has a bucket's
// begin.
std::vector<Side> bucket_sides(const Adjacency& adjacency, std::vector<std::uint32_t>& first) {
    first.assign(adjacency.positions.size() + 1, 0);
    const auto for_each_side = [&](const auto& visit) {
        for (std::uint32_t t = 0; t < adjacency.triangles.size(); ++t) {
            if (adjacency.degenerate[t]) continue;
            for (int i = 0; i < 3; ++i) visit(t, adjacency.triangles[t][i], adjacency.triangles[t][(i + 1) % 3]);
        }
    };
    for_each_side([&](std::uint32_t, std::uint32_t a, std::uint32_t b) { ++first[std::min(a, b) + 1]; });
    for (size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    std::vector<Side> sides(first.back());
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for_each_side([&](std::uint32_t t, std::uint32_t a, std::uint32_t b) {
        sides[next[std::min(a, b)]++] = {std::max(a, b), t, a > b};
    });
    return sides;
}

void count_kind(Adjacency& adjacency, std::span<const Side> sides) {
    if (sides.size() == 1)
        ++adjacency.boundary_edges;
    else if (sides.size() > 2)
        ++adjacency.nonmanifold_edges;
    else if (sides[0].backwards == sides[1].backwards)
        ++adjacency.misoriented_edges;
}

} // namespace

bool zero_area(vec3 a, vec3 b, vec3 c) {
    if (a == b || b == c || c == a) return true;
    const dvec3 n = glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
    return n.x == 0.0 && n.y == 0.0 && n.z == 0.0;
}

Adjacency build_adjacency(const Scene& scene) {
    Adjacency adjacency;
    const std::vector<std::uint32_t> welded_of = weld(scene, adjacency.positions);
    adjacency.triangles.resize(scene.triangles.size());
    adjacency.degenerate.resize(scene.triangles.size());
    parallel_for(scene.triangles.size(), grain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = scene.triangles[i];
            adjacency.triangles[i] = {welded_of[t.x], welded_of[t.y], welded_of[t.z]};
            adjacency.degenerate[i] = zero_area(scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]);
        }
    });

    std::vector<std::uint32_t> first;
    std::vector<Side> sides = bucket_sides(adjacency, first);
    const size_t vertices = adjacency.positions.size();
    parallel_for(vertices, grain, [&](size_t begin, size_t end) {
        for (size_t v = begin; v < end; ++v)
            std::sort(sides.begin() + first[v], sides.begin() + first[v + 1], [](const Side& a, const Side& b) {
                return a.end != b.end             ? a.end < b.end
                       : a.triangle != b.triangle ? a.triangle < b.triangle
                                                  : a.backwards < b.backwards;
            });
    });

    adjacency.edge_triangles.resize(sides.size());
    adjacency.edges.reserve(sides.size() / 2 + sides.size() / 16);
    for (std::uint32_t v = 0; v < vertices; ++v)
        for (std::uint32_t begin = first[v], end = begin; begin < first[v + 1]; begin = end) {
            for (; end < first[v + 1] && sides[end].end == sides[begin].end; ++end)
                adjacency.edge_triangles[end] = sides[end].triangle;
            adjacency.edges.push_back({v, sides[begin].end, begin, end - begin});
            count_kind(adjacency, std::span(sides).subspan(begin, end - begin));
        }
    return adjacency;
}

} // namespace gnomon
