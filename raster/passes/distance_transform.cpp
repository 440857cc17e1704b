#include "raster/passes/distance_transform.h"

#include "raster/passes/rows.h"

namespace gnomon {
namespace {

// `passes` of full-screen draws in which every pixel fetches a site and writes one.
void count_passes(Pass& pass, const Image<Site>& sites, int passes) {
    const auto fragments = passes * static_cast<std::int64_t>(sites.size());
    detail::count_fragments(pass.counters(), fragments, fragments, sizeof(Site), sizeof(Site));
    pass.counters().draws += passes;
}

} // namespace

Image<Site> nearest_seeds(Pass& pass, const Image<std::uint8_t>& seeds) {
    Image<Site> sites = nearest_seeds(seeds);
    count_passes(pass, sites, 5);
    return sites;
}

Image<std::int32_t> squared_distances(Pass& pass, const Image<Site>& sites) {
    count_passes(pass, sites, 1);
    return squared_distances(sites);
}

} // namespace gnomon
