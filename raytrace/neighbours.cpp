#include "raytrace/neighbours.h"

#include <algorithm>
#include <cstring>

#include "core/random.h"

namespace gnomon {
namespace {

using CornerBits = std::array<std::uint32_t, 3>;

// 0 and −0 are one place.
CornerBits corner_bits(const TriangleCluster& cluster, std::uint32_t corner, std::uint32_t place) {
    CornerBits bits;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float value = cluster.corner[corner][axis][place] + 0.0f;
        std::memcpy(&bits[axis], &value, sizeof value);
    }
    return bits;
}

// Numbers for positions, the same for the same: an open-addressing table of at least twice as many places as there
// are corners.
class Places {
public:
    explicit Places(std::size_t corners) {
        std::size_t size = 16;
        while (size < 2 * corners) size *= 2;
        table_.assign(size, none);
        positions_.reserve(corners / 4);
    }

    std::uint32_t number_of(const CornerBits& bits) {
        std::size_t at = hash(hash(bits[0], bits[1]), bits[2]) & (table_.size() - 1);
        for (; table_[at] != none; at = (at + 1) & (table_.size() - 1))
            if (positions_[table_[at]] == bits) return table_[at];
        table_[at] = static_cast<std::uint32_t>(positions_.size());
        positions_.push_back(bits);
        return table_[at];
    }

private:
    static constexpr std::uint32_t none = 0xffffffffu;
    std::vector<std::uint32_t> table_;
    std::vector<CornerBits> positions_;
};

// From corner `edge` of a triangle to the next one.
struct Edge {
    std::uint32_t low, high; // numbers of its ends
    std::uint32_t triangle;  // cluster · cluster_size + place
    std::uint8_t edge;
    bool reversed; // it goes from `high` to `low`
};

std::vector<Edge> edges_of(const std::vector<TriangleCluster>& clusters) {
    std::size_t count = 0;
    for (const TriangleCluster& cluster : clusters) count += cluster.count;
    Places places(3 * count);
    std::vector<Edge> edges;
    edges.reserve(3 * count);
    for (std::size_t c = 0; c < clusters.size(); ++c)
        for (std::uint32_t i = 0; i < clusters[c].count; ++i) {
            std::array<std::uint32_t, 3> corner;
            for (std::uint32_t k = 0; k < 3; ++k) corner[k] = places.number_of(corner_bits(clusters[c], k, i));
            for (std::uint8_t k = 0; k < 3; ++k) {
                const std::uint32_t from = corner[k], to = corner[(k + 1u) % 3];
                edges.push_back({std::min(from, to), std::max(from, to),
                                 static_cast<std::uint32_t>(c * cluster_size) + i, k, from > to});
            }
        }
    return edges;
}

void list_beside(std::uint32_t cluster, std::uint32_t triangles, ClusterNeighbours& to) {
    for (const auto& over : to.over)
        for (std::uint32_t i = 0; i < triangles; ++i) {
            if (over[i] == no_neighbour) to.open |= 1u << i;
            const auto other = static_cast<std::uint32_t>(over[i] / cluster_size);
            if (over[i] == no_neighbour || other == cluster || to.count > ClusterNeighbours::most) continue;
            const auto end = to.beside.begin() + to.count;
            if (std::find(to.beside.begin(), end, other) != end) continue;
            if (to.count < ClusterNeighbours::most) to.beside[to.count] = other;
            ++to.count;
        }
}

} // namespace

std::vector<ClusterNeighbours> find_neighbours(const std::vector<TriangleCluster>& clusters) {
    std::vector<Edge> edges = edges_of(clusters);
    const auto before = [](const Edge& a, const Edge& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; };
    std::sort(edges.begin(), edges.end(), before);
    ClusterNeighbours none;
    for (auto& over : none.over) over.fill(no_neighbour);
    std::vector<ClusterNeighbours> neighbours(clusters.size(), none);
    for (auto first = edges.begin(); first != edges.end();) {
        const auto end = std::find_if(first, edges.end(), [&](const Edge& edge) { return before(*first, edge); });
        if (end - first == 2 && first[0].reversed != first[1].reversed && first->low != first->high)
            for (int i = 0; i < 2; ++i) {
                const Edge &here = first[i], &there = first[1 - i];
                neighbours[here.triangle / cluster_size].over[here.edge][here.triangle % cluster_size] = there.triangle;
            }
        first = end;
    }
    for (std::size_t c = 0; c < clusters.size(); ++c)
        list_beside(static_cast<std::uint32_t>(c), clusters[c].count, neighbours[c]);
    return neighbours;
}

} // namespace gnomon
