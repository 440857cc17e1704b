#include "eval/metric/silhouette.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "eval/metric/reduce.h"

namespace gnomon {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr size_t rows_at_a_time = 16;

Silhouette find_silhouette(const ImagePair& pair, const Image<float>& visibility) {
    const int width = visibility.width(), height = visibility.height();
    const auto takes = [&](int x, int y) {
        return takes_part(pair, static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x));
    };
    const auto light = [&](int x, int y) {
        return x >= 0 && x < width && y >= 0 && y < height && visibility(x, y) >= boundary_level && takes(x, y);
    };
    Image<std::uint8_t> seeds(width, height, 0);
    parallel_for(static_cast<size_t>(height), rows_at_a_time, [&](size_t begin, size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < width; ++x)
                if (visibility(x, y) < boundary_level && takes(x, y))
                    seeds(x, y) = light(x - 1, y) || light(x + 1, y) || light(x, y - 1) || light(x, y + 1);
    });
    Silhouette silhouette;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (seeds(x, y)) silhouette.pixels.emplace_back(x, y);
    if (!silhouette.pixels.empty()) silhouette.nearest = nearest_seeds(seeds);
    return silhouette;
}

} // namespace

Silhouettes find_silhouettes(const ImagePair& pair) {
    return {find_silhouette(pair, pair.test), find_silhouette(pair, pair.reference)};
}

SilhouetteDistances silhouette_distances(const Silhouettes& silhouettes) {
    const Silhouette &test = silhouettes.test, &reference = silhouettes.reference;
    if (test.pixels.empty() && reference.pixels.empty()) return {nan, nan, nan};
    constexpr double infinite = std::numeric_limits<double>::infinity();
    if (test.pixels.empty() || reference.pixels.empty()) return {infinite, infinite, infinite};
    std::vector<double> distances;
    distances.reserve(test.pixels.size() + reference.pixels.size());
    const auto measure = [&](const Silhouette& from, const Silhouette& to) {
        for (const ivec2 pixel : from.pixels) {
            const Site site = to.nearest(pixel.x, pixel.y);
            const std::int64_t dx = pixel.x - site.x, dy = pixel.y - site.y;
            distances.push_back(std::sqrt(static_cast<double>(dx * dx + dy * dy)));
        }
    };
    measure(test, reference);
    measure(reference, test);
    double sum = 0.0;
    for (const double distance : distances) sum += distance;
    // The smallest distance that at least 95 % do not exceed.
    const auto rank = distances.begin() + static_cast<std::ptrdiff_t>((distances.size() * 95 + 99) / 100 - 1);
    std::nth_element(distances.begin(), rank, distances.end());
    return {sum / static_cast<double>(distances.size()), *rank, *std::max_element(rank, distances.end())};
}

} // namespace gnomon
