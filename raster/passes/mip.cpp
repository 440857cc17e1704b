#include "raster/passes/mip.h"

#include <algorithm>
#include <cassert>

#include "core/vector_clones.h"
#include "raster/full_screen.h"
#include "raster/passes/rows.h"

namespace gnomon {
namespace {

// What texel i of a level covers along one axis of the level below.
struct Taps {
    int first, count;
    float weights[3];
};

Taps taps_of(int i, int source_side) {
    if (source_side == 1) return {0, 1, {1.0f}};
    if (source_side % 2 == 0) return {2 * i, 2, {0.5f, 0.5f}};
    const int half = source_side / 2;
    const auto share = [&](int part) { return static_cast<float>(part) / static_cast<float>(source_side); };
    return {2 * i, 3, {share(half - i), share(half), share(i + 1)}};
}

GNOMON_VECTOR_CLONES
void add_weighted(float* sum, const float* values, float weight, size_t count) {
    for (size_t i = 0; i < count; ++i) sum[i] += weight * values[i];
}

} // namespace

int mip_levels(int width, int height) {
    int levels = 1;
    for (int side = std::max(width, height); side > 1; side /= 2) ++levels;
    return levels;
}

void fill_mip(Pass& pass, const Target& source, Target& destination) {
    const int channels = info(source.format()).channels, width = destination.width();
    assert(width == mip_side(source.width(), 1) && destination.height() == mip_side(source.height(), 1));
    assert(destination.layers() == source.layers() && info(destination.format()).channels == channels);
    std::vector<Taps> columns;
    for (int x = 0; x < width; ++x) columns.push_back(taps_of(x, source.width()));
    const std::int64_t bytes = info(source.format()).bytes;

    for (int layer = 0; layer < source.layers(); ++layer)
        detail::for_each_row(pass, destination.height(), [&](int y, PassCounters& counters) {
            // The source rows that this row covers, averaged.
            const Taps rows = taps_of(y, source.height());
            std::vector<float> row, averaged(static_cast<size_t>(source.width() * channels), 0.0f);
            for (int k = 0; k < rows.count; ++k) {
                detail::load_row(source, rows.first + k, layer, 0, row);
                add_weighted(averaged.data(), row.data(), rows.weights[k], averaged.size());
            }
            // The same along the row.
            std::vector<float> means(static_cast<size_t>(width * channels), 0.0f);
            for (int x = 0; x < width; ++x) {
                const Taps& taps = columns[static_cast<size_t>(x)];
                for (int k = 0; k < taps.count; ++k)
                    for (int c = 0; c < channels; ++c)
                        means[static_cast<size_t>(x * channels + c)] +=
                            taps.weights[k] * averaged[static_cast<size_t>((taps.first + k) * channels + c)];
            }
            detail::store_row(destination, y, layer, means.data());
            const std::int64_t fetches = std::int64_t{width} * columns[0].count * rows.count;
            detail::count_fragments(counters, width, fetches, bytes, info(destination.format()).bytes);
        });
}

std::vector<Target> mip_chain(Pass& pass, Target base, const std::shared_ptr<MemoryMeter>& meter) {
    const int levels = mip_levels(base.width(), base.height());
    std::vector<Target> chain;
    chain.reserve(static_cast<size_t>(levels));
    chain.push_back(std::move(base));
    for (int level = 1; level < levels; ++level) {
        const Target& below = chain.back();
        Target above(below.format(), mip_side(below.width(), 1), mip_side(below.height(), 1), below.layers(), meter);
        fill_mip(pass, below, above);
        chain.push_back(std::move(above));
    }
    return chain;
}

} // namespace gnomon
