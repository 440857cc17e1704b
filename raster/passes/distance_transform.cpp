#include "raster/passes/distance_transform.h"

#include <algorithm>

#include "core/large_memory.h"
#include "core/vector_clones.h"
#include "raster/full_screen.h"
#include "raster/passes/rows.h"

namespace gnomon {
namespace {

constexpr size_t stripe_columns = 64; // columns of one task: narrow enough to stay in cache over all rows
constexpr std::int64_t site_bytes = sizeof(Site);
constexpr std::int16_t no_row = -1;

// found[x] becomes y where the row has a seed; the nearest seed at or below every pixel of the stripe so far.
GNOMON_VECTOR_CLONES
void sweep_up(const std::uint8_t* seeds, const std::int16_t* below, std::int16_t* found, std::int16_t y, size_t count) {
    for (size_t x = 0; x < count; ++x) found[x] = seeds[x] ? y : below[x];
}

// The nearer of the seed below and the one above, the lower one on a tie. `above` is carried down from row to row.
GNOMON_VECTOR_CLONES
void sweep_down(std::int16_t* found, std::int32_t* above, std::int32_t y, std::int32_t none_above, size_t count) {
    for (size_t x = 0; x < count; ++x) {
        const std::int32_t below = found[x];
        if (below == y) above[x] = y;
        const std::int32_t distance_below = below < 0 ? none_above : y - below;
        const std::int32_t distance_above = above[x] - y;
        const bool take_above = above[x] < none_above && distance_above < distance_below;
        found[x] = static_cast<std::int16_t>(take_above ? above[x] : below);
    }
}

using Rows = std::vector<std::int16_t, LargeAllocator<std::int16_t>>;

// Phase 1: the nearest seed of each pixel within its own column, or no_row; row by row.
Rows nearest_rows(const Image<std::uint8_t>& seeds) {
    const int height = seeds.height();
    const auto width = static_cast<size_t>(seeds.width());
    Rows rows(seeds.size());
    parallel_for(width, stripe_columns, [&](size_t begin, size_t end) {
        const int x = static_cast<int>(begin);
        const size_t count = end - begin;
        const auto row = [&](int y) { return rows.data() + static_cast<size_t>(y) * width + begin; };
        const std::vector<std::int16_t> nothing(count, no_row);
        for (int y = 0; y < height; ++y)
            sweep_up(&seeds(x, y), y > 0 ? row(y - 1) : nothing.data(), row(y), static_cast<std::int16_t>(y), count);
        const std::int32_t none_above = 2 * max_image_side;
        std::vector<std::int32_t> above(count, none_above);
        for (int y = height - 1; y >= 0; --y) sweep_down(row(y), above.data(), y, none_above, count);
    });
    return rows;
}

// Phases 2 and 3 on one row: the lower envelope of the parabolas (i − x)² + height[x] over the columns that have a
// seed, as a stack of columns and of the pixels from which on each is the lowest; then that stack read from the right.
// All in 32 bits: a difference of squares and one of heights are at most 32767² each.
struct Envelope {
    std::vector<std::int32_t> column, start, height;

    explicit Envelope(int width)
        : column(static_cast<size_t>(width)), start(static_cast<size_t>(width)), height(static_cast<size_t>(width)) {}

    void trace(std::span<const std::int16_t> rows, int y, std::span<Site> sites) {
        const int width = static_cast<int>(rows.size());
        const auto value = [&](std::int32_t i, std::int32_t x) { return (i - x) * (i - x) + height[at(x)]; };
        size_t top = 0;
        for (std::int32_t x = 0; x < width; ++x) {
            const std::int32_t row = rows[at(x)];
            if (row < 0) continue;
            height[at(x)] = (y - row) * (y - row);
            while (top > 0 && value(start[top - 1], column[top - 1]) > value(start[top - 1], x)) --top;
            // The first pixel where x is strictly lower than the column before it: ties stay with the smaller column.
            const std::int32_t from = top == 0 ? 0 : 1 + last_not_above(column[top - 1], x);
            if (from >= width) continue;
            column[top] = x;
            start[top++] = from;
        }
        if (top == 0) return;
        for (std::int32_t x = width - 1; x >= 0; --x) {
            const std::int32_t nearest = column[top - 1];
            sites[at(x)] = {static_cast<std::int16_t>(nearest), rows[at(nearest)]};
            if (x == start[top - 1]) --top;
        }
    }

    // The largest i with value(i, a) ≤ value(i, b), a < b: floor((b² − a² + height[b] − height[a]) / (2·(b − a))).
    std::int32_t last_not_above(std::int32_t a, std::int32_t b) const {
        const std::int32_t numerator = (b - a) * (b + a) + (height[at(b)] - height[at(a)]);
        const std::int32_t denominator = 2 * (b - a), quotient = numerator / denominator;
        return quotient - (numerator % denominator < 0 ? 1 : 0);
    }

    static size_t at(std::int32_t i) { return static_cast<size_t>(i); }
};

} // namespace

Image<Site> nearest_seeds(Pass& pass, const Image<std::uint8_t>& seeds) {
    const int width = seeds.width();
    const Rows rows = nearest_rows(seeds);
    Image<Site> sites(width, seeds.height());
    detail::for_each_row(pass, seeds.height(), [&](int y, PassCounters& counters) {
        Envelope envelope(width);
        const auto columns = static_cast<size_t>(width);
        envelope.trace({rows.data() + static_cast<size_t>(y) * columns, columns}, y, sites.row(y));
        detail::count_fragments(counters, 5 * width, 5 * width, site_bytes, site_bytes);
    });
    pass.counters().draws += 4; // five passes in all
    return sites;
}

Image<std::int32_t> squared_distances(Pass& pass, const Image<Site>& sites) {
    const int width = sites.width();
    Image<std::int32_t> distances(width, sites.height());
    detail::for_each_row(pass, sites.height(), [&](int y, PassCounters& counters) {
        for (int x = 0; x < width; ++x) {
            const Site site = sites(x, y);
            const std::int32_t dx = x - site.x, dy = y - site.y;
            distances(x, y) = site.exists() ? dx * dx + dy * dy : no_seed_distance;
        }
        detail::count_fragments(counters, width, width, site_bytes, site_bytes);
    });
    return distances;
}

} // namespace gnomon
