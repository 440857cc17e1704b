// How ragged a drawn silhouette is. [Macedo 2018] judges that by eye; the number here is the standard deviation of the
// error along the edge, integrated across it: for a straight hard edge drawn with stairs of height h, whose phase is
// uniform along the edge, it is h times the integral of sqrt(p (1 - p)) over p from 0 to 1, h pi / 8.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/parallel.h"
#include "eval/metric/reduce.h"
#include "eval/metric/silhouette.h"

namespace gnomon {
namespace {

constexpr int reach = 16;     // pixels to either side of the edge; beyond them an error is no stair
constexpr int tile_side = 64; // one stretch of an edge: what varies from edge to edge is not jaggedness
constexpr size_t bins = 2 * reach + 1;

struct Bin {
    double sum = 0.0, squares = 0.0;
    std::int64_t count = 0;

    double deviation() const {
        if (count == 0) return 0.0;
        const double mean = sum / static_cast<double>(count);
        return std::sqrt(std::max(0.0, squares / static_cast<double>(count) - mean * mean));
    }
};

struct Tile {
    std::array<Bin, bins> by_distance; // from the reference's boundary, in whole pixels, negative in its shadow
    std::int64_t edge_pixels = 0;

    double jaggedness() const { // bins are one pixel wide
        double sum = 0.0;
        for (const Bin& bin : by_distance) sum += bin.deviation();
        return sum;
    }
};

Tile measure_tile(const ImagePair& pair, const Image<Site>& nearest, int left, int bottom) {
    Tile tile;
    const int width = pair.test.width(), right = std::min(left + tile_side, width),
              top = std::min(bottom + tile_side, pair.test.height());
    for (int y = bottom; y < top; ++y)
        for (int x = left; x < right; ++x) {
            const Site site = nearest(x, y);
            const double dx = x - site.x, dy = y - site.y, squared = dx * dx + dy * dy;
            if (squared >= (reach + 0.5) * (reach + 0.5)) continue;
            if (!takes_part(pair, static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)))
                continue;
            const int distance = static_cast<int>(std::lround(std::sqrt(squared)));
            const bool light = pair.reference(x, y) >= boundary_level;
            Bin& bin = tile.by_distance[static_cast<size_t>(reach + (light ? distance : -distance))];
            const double error = double{pair.test(x, y)} - double{pair.reference(x, y)};
            bin.sum += error;
            bin.squares += error * error;
            ++bin.count;
            if (squared == 0.0) ++tile.edge_pixels;
        }
    return tile;
}

} // namespace

double jaggedness(const ImagePair& pair, const Silhouettes& silhouettes) {
    if (silhouettes.reference.pixels.empty()) return std::numeric_limits<double>::quiet_NaN();
    const int columns = (pair.test.width() + tile_side - 1) / tile_side,
              rows = (pair.test.height() + tile_side - 1) / tile_side;
    struct Share {
        double weighted = 0.0;
        std::int64_t edge_pixels = 0;
    };
    std::vector<Share> shares(static_cast<size_t>(columns) * static_cast<size_t>(rows));
    parallel_for(shares.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
            const Tile tile = measure_tile(pair, silhouettes.reference.nearest, column * tile_side, row * tile_side);
            if (tile.edge_pixels > 0)
                shares[i] = {static_cast<double>(tile.edge_pixels) * tile.jaggedness(), tile.edge_pixels};
        }
    });
    Share total;
    for (const Share& share : shares) {
        total.weighted += share.weighted;
        total.edge_pixels += share.edge_pixels;
    }
    return total.weighted / static_cast<double>(total.edge_pixels);
}

} // namespace gnomon
