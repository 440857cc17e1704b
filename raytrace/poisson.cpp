#include "raytrace/poisson.h"

#include <algorithm>

#include "core/random.h"

namespace gnomon {
namespace {

constexpr std::uint32_t candidates_per_point = 32;

// Squared distance on the torus; differences wrap as unsigned integers do.
double distance2(TorusPoint a, TorusPoint b) {
    const auto dx = static_cast<double>(static_cast<std::int32_t>(a.x - b.x));
    const auto dy = static_cast<double>(static_cast<std::int32_t>(a.y - b.y));
    return dx * dx + dy * dy;
}

// Points in 2^bits × 2^bits cells; made anew whenever there are twice as many points, so that a cell holds about one.
class CellGrid {
public:
    CellGrid(std::uint32_t bits, const std::vector<TorusPoint>& points) : bits_(bits), cells_(size_t{1} << 2 * bits) {
        for (const TorusPoint point : points) add(point);
    }

    void add(TorusPoint point) { cell(column(point.x), column(point.y)).push_back(point); }

    // Squared distance to the nearest point: rings of cells around the one that holds `from`, until no farther ring can
    // hold a nearer point. The grid is not empty.
    double nearest2(TorusPoint from) const {
        const std::uint32_t side = 1u << bits_;
        double nearest = 1e30;
        for (std::uint32_t ring = 0; ring <= side / 2; ++ring) {
            const double beyond = ring == 0 ? 0 : static_cast<double>(ring - 1) * cell_side();
            if (beyond * beyond > nearest) break;
            for (std::uint32_t j = 0; j <= 2 * ring; ++j)
                for (std::uint32_t i = 0; i <= 2 * ring; i += on_ring(j, ring) ? 1 : 2 * ring)
                    for (const TorusPoint point : cell(column(from.x) + i - ring, column(from.y) + j - ring))
                        nearest = std::min(nearest, distance2(from, point));
        }
        return nearest;
    }

private:
    static bool on_ring(std::uint32_t j, std::uint32_t ring) { return j == 0 || j == 2 * ring; }
    double cell_side() const { return 4294967296.0 / static_cast<double>(1u << bits_); }
    std::uint32_t column(std::uint32_t x) const { return bits_ == 0 ? 0 : x >> (32 - bits_); }
    size_t at(std::uint32_t i, std::uint32_t j) const {
        const std::uint32_t mask = (1u << bits_) - 1;
        return (static_cast<size_t>(j & mask) << bits_) + (i & mask);
    }
    std::vector<TorusPoint>& cell(std::uint32_t i, std::uint32_t j) { return cells_[at(i, j)]; }
    const std::vector<TorusPoint>& cell(std::uint32_t i, std::uint32_t j) const { return cells_[at(i, j)]; }

    std::uint32_t bits_;
    std::vector<std::vector<TorusPoint>> cells_;
};

} // namespace

std::vector<TorusPoint> best_candidates(size_t count) {
    std::vector<TorusPoint> points;
    points.reserve(count);
    if (count > 0) points.push_back({});
    std::uint32_t bits = 0;
    CellGrid grid(bits, points);
    while (points.size() < count) {
        if (points.size() >= size_t{4} << 2 * bits) grid = CellGrid(++bits, points);
        TorusPoint best;
        double farthest = -1;
        for (std::uint32_t c = 0; c < candidates_per_point; ++c) {
            const auto n = static_cast<std::uint32_t>(points.size());
            const TorusPoint candidate{hash(n, c, 1), hash(n, c, 2)};
            const double distance = grid.nearest2(candidate);
            if (distance > farthest) farthest = distance, best = candidate;
        }
        points.push_back(best);
        grid.add(best);
    }
    return points;
}

} // namespace gnomon
