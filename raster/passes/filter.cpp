#include "raster/passes/filter.h"

#include <algorithm>

#include "raster/full_screen.h"

namespace gnomon {
namespace {

void convolve(Pass& pass, const Target& source, Target& destination, std::span<const float> weights, ivec2 step) {
    const int reach = static_cast<int>(weights.size()) / 2;
    const ivec2 last(source.width() - 1, source.height() - 1);
    const std::int64_t texel_bytes = info(source.format()).bytes;
    for (int layer = 0; layer < source.layers(); ++layer)
        full_screen(pass, Targets{.color = {&destination}, .layer = layer}, [&](Pixel& pixel) {
            vec4 sum(0.0f);
            for (int k = 0; k < static_cast<int>(weights.size()); ++k) {
                const ivec2 at = glm::clamp(ivec2(pixel.x, pixel.y) + step * (k - reach), ivec2(0), last);
                sum += source.load(at.x, at.y, layer) * weights[static_cast<size_t>(k)];
            }
            pixel.counters.texels_fetched += static_cast<std::int64_t>(weights.size());
            pixel.counters.bytes_read += static_cast<std::int64_t>(weights.size()) * texel_bytes;
            pixel.color[0] = sum;
        });
}

} // namespace

void convolve_rows(Pass& pass, const Target& source, Target& destination, std::span<const float> weights) {
    convolve(pass, source, destination, weights, {1, 0});
}

void convolve_columns(Pass& pass, const Target& source, Target& destination, std::span<const float> weights) {
    convolve(pass, source, destination, weights, {0, 1});
}

std::vector<float> binomial_weights(int n) {
    std::vector<float> weights;
    double weight = 1.0;
    for (int k = 1; k < n; ++k) weight *= 0.5; // 2^−(n−1), exact
    for (int k = 0; k < n; ++k) {
        weights.push_back(static_cast<float>(weight));
        weight = weight * (n - 1 - k) / (k + 1);
    }
    return weights;
}

std::vector<float> box_weights(int n) {
    return std::vector<float>(static_cast<size_t>(n), 1.0f / static_cast<float>(n));
}

} // namespace gnomon
