#include "raster/passes/jump_flooding.h"

#include <algorithm>

#include "core/vector_clones.h"
#include "raster/full_screen.h"
#include "raster/passes/rows.h"

namespace gnomon {
namespace {

// Squared distance, then x, then y, as one number to minimise; the largest for no site.
std::uint64_t key_of(Site site, std::int32_t x, std::int32_t y) {
    const std::int32_t dx = x - site.x, dy = y - site.y;
    const auto distance = static_cast<std::uint64_t>(static_cast<std::uint32_t>(dx * dx + dy * dy));
    const auto place = static_cast<std::uint32_t>(site.x) << 16 | static_cast<std::uint32_t>(site.y);
    return site.exists() ? distance << 32 | place : ~std::uint64_t{0};
}

// For pixels [begin, end) of row y, candidates are `sites` at a fixed offset from the pixel.
GNOMON_VECTOR_CLONES
void keep_nearer(std::uint64_t* best, const Site* sites, int begin, int end, int y) {
    for (int x = begin; x < end; ++x) best[x] = std::min(best[x], key_of(sites[x - begin], x, y));
}

void flood(Pass& pass, const Image<Site>& from, Image<Site>& to, int step) {
    const int width = from.width(), height = from.height();
    detail::for_each_row(pass, height, [&](int y, PassCounters& counters) {
        std::vector<std::uint64_t> best(static_cast<size_t>(width), ~std::uint64_t{0});
        std::int64_t fetches = 0;
        for (const int source_y : {y - step, y, y + step}) {
            if (source_y < 0 || source_y >= height) continue;
            for (const int offset : {-step, 0, step}) {
                const int begin = std::max(0, -offset), end = std::min(width, width - offset);
                if (begin >= end) continue;
                keep_nearer(best.data(), &from(begin + offset, source_y), begin, end, y);
                fetches += end - begin;
            }
        }
        for (int x = 0; x < width; ++x) {
            const std::uint64_t key = best[static_cast<size_t>(x)];
            to(x, y) = key == ~std::uint64_t{0} ? Site{}
                                                : Site{static_cast<std::int16_t>(key >> 16 & 0xffff),
                                                       static_cast<std::int16_t>(key & 0xffff)};
        }
        detail::count_fragments(counters, width, fetches, sizeof(Site), sizeof(Site));
    });
}

std::vector<int> steps_of(int side, const JumpFlooding& options) {
    std::vector<int> steps;
    if (options.one_before) steps.push_back(1);
    int first = 1;
    while (2 * first < side) first *= 2;
    for (int step = first; step >= 1; step /= 2) steps.push_back(step);
    for (int k = options.after - 1; k >= 0; --k) steps.push_back(1 << k);
    return steps;
}

} // namespace

Image<Site> jump_flooding(Pass& pass, const Image<std::uint8_t>& seeds, const JumpFlooding& options) {
    const int width = seeds.width(), height = seeds.height();
    Image<Site> sites(width, height), next(width, height);
    detail::for_each_row(pass, height, [&](int y, PassCounters& counters) {
        for (int x = 0; x < width; ++x)
            if (seeds(x, y)) sites(x, y) = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)};
        detail::count_fragments(counters, width, width, 1, sizeof(Site));
    });
    for (const int step : steps_of(std::max(width, height), options)) {
        flood(pass, sites, next, step);
        std::swap(sites, next);
    }
    return sites;
}

} // namespace gnomon
