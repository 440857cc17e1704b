// Structural similarity [Wang, Bovik, Sheikh, Simoncelli 2004]: 11 x 11 Gaussian window with sigma 1.5, K1 = 0.01, K2 =
// 0.03, population covariance, data range 1. The mean is over the windows that lie fully inside the image, as in
// scikit-image and the authors' program.

#include "eval/metric/ssim.h"

#include "core/vector_clones.h"
#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {
namespace {

constexpr int radius = ssim_window / 2, taps = ssim_window;
constexpr size_t strip_rows = 64; // output rows of one task, which filters 10 rows more
constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;

using Window = std::array<double, taps>;

Window gaussian_window() {
    Window window{};
    double sum = 0.0;
    for (int i = 0; i < taps; ++i)
        sum += window[static_cast<size_t>(i)] = std::exp(-0.5 * (i - radius) * (i - radius) / (1.5 * 1.5));
    for (double& weight : window) weight /= sum;
    return window;
}

// The moments of a row: means, squares, product, and the weight, which is needed only where some pixel has none.
enum Moment : size_t { X, Y, XX, YY, XY, Weight, moments };
using Rows = std::array<std::vector<double>, moments>;

GNOMON_VECTOR_CLONES
void filter(const double* in, const double* window, double* out, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        double sum = 0.0;
        for (size_t tap = 0; tap < taps; ++tap) sum += window[tap] * in[i + tap];
        out[i] = sum;
    }
}

GNOMON_VECTOR_CLONES
void combine(const double* const* rows, const double* window, double* out, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        double sum = 0.0;
        for (size_t tap = 0; tap < taps; ++tap) sum += window[tap] * rows[tap][i];
        out[i] = sum;
    }
}

GNOMON_VECTOR_CLONES
void multiply(const double* a, const double* b, double* product, size_t count) {
    for (size_t i = 0; i < count; ++i) product[i] = a[i] * b[i];
}

struct MomentPointers {
    const double *x, *y, *xx, *yy, *xy, *weight; // weight: null where all pixels take part
};

GNOMON_VECTOR_CLONES
void similarities(MomentPointers m, double* ssim, double* contrast_structure, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const double scale = m.weight ? 1.0 / m.weight[i] : 1.0;
        const double x = m.x[i] * scale, y = m.y[i] * scale;
        const double xx = m.xx[i] * scale - x * x, yy = m.yy[i] * scale - y * y, xy = m.xy[i] * scale - x * y;
        contrast_structure[i] = (2.0 * xy + c2) / (xx + yy + c2);
        ssim[i] = (2.0 * x * y + c1) / (x * x + y * y + c1) * contrast_structure[i];
    }
}

struct Sums {
    double ssim = 0.0, contrast_structure = 0.0;
    std::int64_t count = 0;
};

// One task: the last eleven rows of the images, filtered along x, and the windows whose centres lie in its rows.
class Strip {
public:
    Strip(const ImagePair& pair, bool weighted)
        : pair_(pair), width_(static_cast<size_t>(pair.test.width())), used_(weighted ? moments : Weight),
          window_(gaussian_window()) {
        for (std::vector<double>& values : plain_) values.assign(width_, 0.0);
        for (Rows& rows : ring_)
            for (std::vector<double>& values : rows) values.resize(windows());
        for (std::vector<double>& values : columns_) values.resize(windows());
        ssim_.resize(windows()), contrast_structure_.resize(windows());
    }

    Sums row(int first) { // of windows whose lowest image row is `first`; rows come in order
        for (next_ = std::max(next_, first); next_ < first + taps; ++next_) load(next_);
        for (size_t m = 0; m < used_; ++m) {
            std::array<const double*, taps> rows{};
            for (int tap = 0; tap < taps; ++tap) rows[static_cast<size_t>(tap)] = slot(first + tap)[m].data();
            combine(rows.data(), window_.data(), columns_[m].data(), windows());
        }
        similarities({columns_[X].data(), columns_[Y].data(), columns_[XX].data(), columns_[YY].data(),
                      columns_[XY].data(), used_ == moments ? columns_[Weight].data() : nullptr},
                     ssim_.data(), contrast_structure_.data(), windows());
        Sums sums;
        const size_t center = (static_cast<size_t>(first) + radius) * width_ + radius;
        for (size_t column = 0; column < windows(); ++column) {
            if (!takes_part(pair_, center + column)) continue;
            sums.ssim += ssim_[column];
            sums.contrast_structure += contrast_structure_[column];
            ++sums.count;
        }
        return sums;
    }

private:
    size_t windows() const { return width_ - (taps - 1); }
    Rows& slot(int row) { return ring_[static_cast<size_t>(row % taps)]; }

    void load(int row) {
        const size_t first_pixel = static_cast<size_t>(row) * width_;
        const std::span<const float> test = pair_.test.row(row), reference = pair_.reference.row(row);
        for (size_t column = 0; column < width_; ++column) {
            const bool in = takes_part(pair_, first_pixel + column);
            plain_[X][column] = in ? test[column] : 0.0;
            plain_[Y][column] = in ? reference[column] : 0.0;
            plain_[Weight][column] = in ? 1.0 : 0.0;
        }
        multiply(plain_[X].data(), plain_[X].data(), plain_[XX].data(), width_);
        multiply(plain_[Y].data(), plain_[Y].data(), plain_[YY].data(), width_);
        multiply(plain_[X].data(), plain_[Y].data(), plain_[XY].data(), width_);
        for (size_t m = 0; m < used_; ++m) filter(plain_[m].data(), window_.data(), slot(row)[m].data(), windows());
    }

    const ImagePair& pair_;
    size_t width_, used_;
    Window window_;
    Rows plain_, columns_;
    std::array<Rows, taps> ring_;
    std::vector<double> ssim_, contrast_structure_;
    int next_ = 0;
};

} // namespace

SimilarityMeans similarity_means(const ImagePair& pair) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const int rows = pair.test.height() - (taps - 1);
    if (pair.test.width() < taps || rows < 1) return {nan, nan};
    const bool weighted = count_masked(pair) < static_cast<std::int64_t>(pair.test.size());
    std::vector<Sums> row_sums(static_cast<size_t>(rows));
    parallel_for(row_sums.size(), strip_rows, [&](size_t begin, size_t end) {
        Strip strip(pair, weighted);
        for (size_t row = begin; row < end; ++row) row_sums[row] = strip.row(static_cast<int>(row));
    });
    Sums total;
    for (const Sums& sums : row_sums) {
        total.ssim += sums.ssim;
        total.contrast_structure += sums.contrast_structure;
        total.count += sums.count;
    }
    if (total.count == 0) return {nan, nan};
    return {total.ssim / static_cast<double>(total.count), total.contrast_structure / static_cast<double>(total.count)};
}

Measure ssim_measure() {
    Metric ssim;
    ssim.id = "ssim";
    ssim.title = "structural similarity";
    ssim.formula =
        "mean of (2 mx my + C1)(2 sxy + C2) / ((mx^2 + my^2 + C1)(sx^2 + sy^2 + C2)) over the 11x11 Gaussian windows "
        "(sigma 1.5) that lie inside the image and are centred on a pixel that takes part; C1 = 0.01^2, C2 = 0.03^2";
    ssim.range = "-1 to 1 (equal); absent for images under 11x11";
    ssim.source = "Wang, Bovik, Sheikh, Simoncelli, Image quality assessment, IEEE TIP 13(4), 2004";
    ssim.blind_to =
        "brightness in dark regions less than in bright ones; a five-pixel border; flat regions that agree dilute it";
    ssim.lower_is_better = false;
    Metric multi_scale = ssim;
    multi_scale.id = "ms_ssim";
    multi_scale.title = "multi-scale structural similarity";
    multi_scale.formula =
        "product over five scales, each the mean of 2x2 pixels of the one before, of (mean contrast-structure term of "
        "ssim)^w, w = 0.0448, 0.2856, 0.3001, 0.2363, 0.1333, at the coarsest scale with the luminance term; negative "
        "means count as 0";
    multi_scale.range = "0 to 1 (equal); absent where the shorter side is under 176 pixels";
    multi_scale.source =
        "Wang, Simoncelli, Bovik, Multi-scale structural similarity for image quality assessment, Asilomar 2003";
    multi_scale.blind_to = "brightness but at a sixteenth of the resolution; narrow artefacts more than ssim";
    return {{ssim, multi_scale},
            [](const ImagePair& pair) {
                const SimilarityMeans finest = similarity_means(pair);
                return std::vector{finest.ssim, multi_scale_similarity(pair, finest)};
            },
            nullptr};
}

} // namespace gnomon
