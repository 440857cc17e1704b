// Structural similarity [Wang, Bovik, Sheikh, Simoncelli 2004]: 11 x 11 Gaussian window with sigma 1.5, K1 = 0.01, K2 =
// 0.03, population covariance, data range 1. The mean is over the windows that lie fully inside the image, as in
// scikit-image and the authors' program. Pixels that do not take part have no weight in any window, and no window is
// centred on them.

#include <array>

#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {
namespace {

constexpr int radius = 5, taps = 2 * radius + 1;
constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;

std::array<double, taps> gaussian_window() {
    std::array<double, taps> window{};
    double sum = 0.0;
    for (int i = 0; i < taps; ++i)
        sum += window[static_cast<size_t>(i)] = std::exp(-0.5 * (i - radius) * (i - radius) / (1.5 * 1.5));
    for (double& weight : window) weight /= sum;
    return window;
}

// The moments that SSIM needs, one row of each: weight, means, squares and product.
struct MomentRows {
    std::vector<double> weight, x, y, xx, yy, xy;

    explicit MomentRows(size_t width) : weight(width), x(width), y(width), xx(width), yy(width), xy(width) {}
    std::array<std::vector<double>*, 6> all() { return {&weight, &x, &y, &xx, &yy, &xy}; }
};

// The column sums under the window whose bottom row is `first_row`.
void filter_columns(const ImagePair& pair, const std::array<double, taps>& window, int first_row, MomentRows& rows) {
    const auto width = static_cast<size_t>(pair.test.width());
    for (std::vector<double>* row : rows.all()) std::fill(row->begin(), row->end(), 0.0);
    for (int i = 0; i < taps; ++i) {
        const double weight = window[static_cast<size_t>(i)];
        const std::span<const float> test = pair.test.row(first_row + i), reference = pair.reference.row(first_row + i);
        const size_t first_pixel = static_cast<size_t>(first_row + i) * width;
        for (size_t column = 0; column < width; ++column) {
            const bool in = takes_part(pair, first_pixel + column);
            const double w = in ? weight : 0.0, x = in ? test[column] : 0.0, y = in ? reference[column] : 0.0;
            rows.weight[column] += w;
            rows.x[column] += w * x;
            rows.y[column] += w * y;
            rows.xx[column] += w * x * x;
            rows.yy[column] += w * y * y;
            rows.xy[column] += w * x * y;
        }
    }
}

void filter_row(const std::vector<double>& in, const std::array<double, taps>& window, std::vector<double>& out) {
    const size_t windows = in.size() - (taps - 1);
    std::fill(out.begin(), out.end(), 0.0);
    for (size_t i = 0; i < taps; ++i)
        for (size_t column = 0; column < windows; ++column) out[column] += window[i] * in[column + i];
}

double similarity(const MomentRows& rows, size_t i) {
    const double scale = 1.0 / rows.weight[i]; // 1 but for rounding where all pixels take part
    const double x = rows.x[i] * scale, y = rows.y[i] * scale;
    const double xx = rows.xx[i] * scale - x * x, yy = rows.yy[i] * scale - y * y, xy = rows.xy[i] * scale - x * y;
    return (2.0 * x * y + c1) * (2.0 * xy + c2) / ((x * x + y * y + c1) * (xx + yy + c2));
}

double mean_similarity(const ImagePair& pair) {
    const int width = pair.test.width(), window_rows = pair.test.height() - (taps - 1);
    if (width < taps || window_rows < 1) return std::numeric_limits<double>::quiet_NaN();
    const std::array<double, taps> window = gaussian_window();
    constexpr size_t grain = 8;
    std::vector<double> sums(static_cast<size_t>(window_rows), 0.0);
    std::vector<std::int64_t> counts(static_cast<size_t>(window_rows), 0);
    parallel_for(static_cast<size_t>(window_rows), grain, [&](size_t begin, size_t end) {
        MomentRows columns(static_cast<size_t>(width)), rows(static_cast<size_t>(width));
        for (size_t row = begin; row < end; ++row) {
            filter_columns(pair, window, static_cast<int>(row), columns);
            for (size_t i = 0; i < 6; ++i) filter_row(*columns.all()[i], window, *rows.all()[i]);
            const size_t center = (row + radius) * static_cast<size_t>(width) + radius;
            for (size_t column = 0; column < static_cast<size_t>(width) - (taps - 1); ++column) {
                if (!takes_part(pair, center + column)) continue;
                sums[row] += similarity(rows, column);
                ++counts[row];
            }
        }
    });
    PixelSum total;
    for (size_t row = 0; row < sums.size(); ++row) total.sum += sums[row], total.count += counts[row];
    return total.mean();
}

} // namespace

Metric ssim_metric() {
    Metric metric;
    metric.id = "ssim";
    metric.title = "structural similarity";
    metric.formula =
        "mean of (2 mx my + C1)(2 sxy + C2) / ((mx^2 + my^2 + C1)(sx^2 + sy^2 + C2)) over the 11x11 Gaussian windows "
        "(sigma 1.5) that lie inside the image and are centred on a pixel that takes part; C1 = 0.01^2, C2 = 0.03^2";
    metric.range = "-1 to 1 (equal); absent for images under 11x11";
    metric.source = "Wang, Bovik, Sheikh, Simoncelli, Image quality assessment, IEEE TIP 13(4), 2004";
    metric.blind_to =
        "brightness in dark regions less than in bright ones; a five-pixel border; flat regions that agree dilute it";
    metric.lower_is_better = false;
    metric.evaluate = mean_similarity;
    return metric;
}

} // namespace gnomon
