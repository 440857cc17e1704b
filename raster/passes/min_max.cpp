#include "raster/passes/min_max.h"

#include <algorithm>

#include "raster/full_screen.h"
#include "raster/passes/rows.h"

namespace gnomon {
namespace {

constexpr int texel_bytes = 8;

MinMax merge(MinMax a, vec2 b) { return {b.x < a.minimum ? b.x : a.minimum, b.y > a.maximum ? b.y : a.maximum}; }

void fill_base(Pass& pass, const Target& source, Target& base) {
    const int channels = info(source.format()).channels, width = source.width();
    for (int layer = 0; layer < source.layers(); ++layer)
        detail::for_each_row(pass, source.height(), [&](int y, PassCounters& counters) {
            std::vector<float> row;
            detail::load_row(source, y, layer, 0, row);
            vec2* out = base.row<vec2>(y, layer);
            for (int x = 0; x < width; ++x) {
                const float value = row[static_cast<size_t>(x * channels)];
                out[x] = value == value ? vec2(value) : vec2(infinity, -infinity);
            }
            detail::count_fragments(counters, width, width, info(source.format()).bytes, texel_bytes);
        });
}

void fill_level(Pass& pass, const Target& below, Target& above) {
    const int width = above.width();
    for (int layer = 0; layer < below.layers(); ++layer)
        detail::for_each_row(pass, above.height(), [&](int y, PassCounters& counters) {
            // Where the border cuts a block, its last row or column stands in for the missing one.
            const vec2* rows[2] = {below.row<vec2>(2 * y, layer),
                                   below.row<vec2>(std::min(2 * y + 1, below.height() - 1), layer)};
            vec2* out = above.row<vec2>(y, layer);
            for (int x = 0; x < width; ++x) {
                const int right = std::min(2 * x + 1, below.width() - 1);
                MinMax block = {rows[0][2 * x].x, rows[0][2 * x].y};
                block = merge(merge(merge(block, rows[0][right]), rows[1][2 * x]), rows[1][right]);
                out[x] = {block.minimum, block.maximum};
            }
            const std::int64_t fetched_rows = std::min(2, below.height() - 2 * y);
            detail::count_fragments(counters, width, below.width() * fetched_rows, texel_bytes, texel_bytes);
        });
}

} // namespace

MinMaxPyramid min_max_pyramid(Pass& pass, const Target& source, const std::shared_ptr<MemoryMeter>& meter) {
    MinMaxPyramid pyramid;
    pyramid.levels.emplace_back(Format::RG32F, source.width(), source.height(), source.layers(), meter);
    fill_base(pass, source, pyramid.levels[0]);
    while (pyramid.levels.back().width() > 1 || pyramid.levels.back().height() > 1) {
        const Target& below = pyramid.levels.back();
        Target above(Format::RG32F, (below.width() + 1) / 2, (below.height() + 1) / 2, below.layers(), meter);
        fill_level(pass, below, above);
        pyramid.levels.push_back(std::move(above));
    }
    return pyramid;
}

int min_max_level(int width, int height) {
    int level = 0;
    while ((std::int64_t{1} << level) < std::max(width, height)) ++level;
    return level;
}

MinMax min_max_over(const MinMaxPyramid& pyramid, ivec2 first, ivec2 last, int level, PassCounters& counters,
                    int layer) {
    const Target& map = pyramid.levels[0];
    first = glm::max(first, ivec2(0));
    last = glm::min(last, ivec2(map.width() - 1, map.height() - 1));
    MinMax bounds;
    if (first.x > last.x || first.y > last.y) return bounds;

    level = std::clamp(level, 0, static_cast<int>(pyramid.levels.size()) - 1);
    const Target& target = pyramid.levels[static_cast<size_t>(level)];
    const ivec2 low(first.x >> level, first.y >> level), high(last.x >> level, last.y >> level);
    for (int y = low.y; y <= high.y; ++y)
        for (int x = low.x; x <= high.x; ++x) bounds = merge(bounds, target.row<vec2>(y, layer)[x]);
    const std::int64_t texels = std::int64_t{high.x - low.x + 1} * (high.y - low.y + 1);
    counters.texels_fetched += texels;
    counters.bytes_read += texels * texel_bytes;
    return bounds;
}

} // namespace gnomon
