// The width of a penumbra at a pixel is the distance to the nearest lit pixel plus that to the nearest pixel of umbra,
// minus one: the number of penumbra pixels on the way across, 0 at a hard edge.

#include <cmath>

#include "eval/metric/classes.h"
#include "eval/metric/reduce.h"
#include "eval/metric/silhouette.h"

namespace gnomon {
namespace {

constexpr double unknown = -1.0;

// One class of one image: its distance from any pixel.
class Far {
public:
    Far(const ImagePair& pair, const Image<float>& visibility, ShadowClass wanted)
        : pair_(pair), visibility_(visibility), wanted_(wanted) {
        Image<std::uint8_t> seeds(visibility.width(), visibility.height());
        parallel_for(seeds.size(), 1 << 14, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                seeds.values()[i] = takes_part(pair, i) && shadow_class(visibility.values()[i]) == wanted;
        });
        nearest_ = nearest_seeds(seeds);
    }

    // `unknown` where there is none, or where the straight way there leads over the opposite class or over pixels that
    // do not take part: then it belongs to another shadow.
    double distance(ivec2 from) const {
        const Site site = nearest_(from.x, from.y);
        if (!site.exists()) return unknown;
        const ivec2 way = ivec2(site.x, site.y) - from;
        const ShadowClass opposite = wanted_ == ShadowClass::Lit ? ShadowClass::Umbra : ShadowClass::Lit;
        const int steps = std::max(std::abs(way.x), std::abs(way.y));
        for (int step = 1; step < steps; ++step) {
            const double share = static_cast<double>(step) / steps;
            const ivec2 at = from + ivec2(static_cast<int>(std::lround(way.x * share)),
                                          static_cast<int>(std::lround(way.y * share)));
            const size_t pixel =
                static_cast<size_t>(at.y) * static_cast<size_t>(visibility_.width()) + static_cast<size_t>(at.x);
            if (!takes_part(pair_, pixel) || shadow_class(visibility_.values()[pixel]) == opposite) return unknown;
        }
        return std::sqrt(static_cast<double>(way.x) * way.x + static_cast<double>(way.y) * way.y);
    }

private:
    const ImagePair& pair_;
    const Image<float>& visibility_;
    ShadowClass wanted_;
    Image<Site> nearest_;
};

// Widths at the boundary pixels of an image, row by row as in Silhouette::pixels.
Image<float> widths(const ImagePair& pair, const Image<float>& visibility, const Silhouette& silhouette) {
    Image<float> at_boundary(visibility.width(), visibility.height(), static_cast<float>(unknown));
    std::vector<double> to_lit(silhouette.pixels.size());
    {
        const Far lit(pair, visibility, ShadowClass::Lit); // one at a time: each holds an image
        for (size_t i = 0; i < to_lit.size(); ++i) to_lit[i] = lit.distance(silhouette.pixels[i]);
    }
    const Far umbra(pair, visibility, ShadowClass::Umbra);
    for (size_t i = 0; i < to_lit.size(); ++i) {
        const ivec2 pixel = silhouette.pixels[i];
        const double to_umbra = umbra.distance(pixel);
        if (to_lit[i] != unknown && to_umbra != unknown)
            at_boundary(pixel.x, pixel.y) = static_cast<float>(to_lit[i] + to_umbra - 1.0);
    }
    return at_boundary;
}

} // namespace

double penumbra_width_error(const ImagePair& pair, const Silhouettes& silhouettes) {
    if (silhouettes.test.pixels.empty() || silhouettes.reference.pixels.empty())
        return std::numeric_limits<double>::quiet_NaN();
    const Image<float> test = widths(pair, pair.test, silhouettes.test),
                       reference = widths(pair, pair.reference, silhouettes.reference);
    PixelSum sum;
    for (const ivec2 pixel : silhouettes.reference.pixels) {
        const Site site = silhouettes.test.nearest(pixel.x, pixel.y);
        const float drawn = test(site.x, site.y), expected = reference(pixel.x, pixel.y);
        if (drawn >= 0.0f && expected >= 0.0f) sum.add(std::abs(double{drawn} - double{expected}));
    }
    return sum.mean();
}

} // namespace gnomon
