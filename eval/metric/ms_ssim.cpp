#include "eval/metric/reduce.h"
#include "eval/metric/ssim.h"

namespace gnomon {
namespace {

constexpr double exponents[] = {0.0448, 0.2856, 0.3001, 0.2363, 0.1333}; // [Wang, Simoncelli, Bovik 2003, 4]

struct Scale {
    Image<float> test, reference; // NaN where no pixel of the finer scale takes part
};

// The mean of 2 x 2 pixels, of those that take part. The last row or column of an odd size is dropped.
Scale half_as_large(const ImagePair& pair) {
    const int width = pair.test.width() / 2, height = pair.test.height() / 2;
    Scale half{Image<float>(width, height), Image<float>(width, height)};
    parallel_for(static_cast<size_t>(height), 16, [&](size_t begin, size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < width; ++x) {
                double test = 0.0, reference = 0.0;
                int count = 0;
                for (const ivec2 corner : {ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(1, 1)}) {
                    const size_t pixel =
                        static_cast<size_t>(2 * y + corner.y) * static_cast<size_t>(pair.test.width()) +
                        static_cast<size_t>(2 * x + corner.x);
                    if (!takes_part(pair, pixel)) continue;
                    test += pair.test.values()[pixel];
                    reference += pair.reference.values()[pixel];
                    ++count;
                }
                half.test(x, y) = static_cast<float>(test / count); // 0 / 0 where none takes part
                half.reference(x, y) = static_cast<float>(reference / count);
            }
    });
    return half;
}

} // namespace

double multi_scale_similarity(const ImagePair& pair, const SimilarityMeans& finest) {
    constexpr size_t scales = std::size(exponents);
    if (std::min(pair.test.width(), pair.test.height()) >> (scales - 1) < ssim_window)
        return std::numeric_limits<double>::quiet_NaN();
    static const Image<std::uint8_t> no_mask;
    double product = std::pow(std::max(finest.contrast_structure, 0.0), exponents[0]);
    if (std::isnan(finest.ssim)) return finest.ssim;
    Scale scale = half_as_large(pair);
    for (size_t i = 1; i < scales; ++i) {
        if (i > 1) scale = half_as_large({scale.test, scale.reference, no_mask});
        const SimilarityMeans means = similarity_means({scale.test, scale.reference, no_mask});
        const double term = i + 1 == scales ? means.ssim : means.contrast_structure;
        product *= std::pow(std::max(term, 0.0), exponents[i]); // NaN where a coarse scale has no window
        if (std::isnan(term)) return term;
    }
    return product;
}

} // namespace gnomon
