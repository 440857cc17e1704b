#include <bitset>
#include <cmath>

#include "eval/metric/all.h"
#include "eval/metric/classes.h"
#include "eval/metric/reduce.h"

namespace gnomon {
namespace {

constexpr int finest_level = 65536; // visibilities nearer to each other than a 65536th are one level

bool in_penumbra(const ImagePair& pair, size_t pixel) {
    return takes_part(pair, pixel) && shadow_class(pair.reference.values()[pixel]) == ShadowClass::Penumbra;
}

std::vector<double> banding(const ImagePair& pair) {
    constexpr size_t rows_at_a_time = 64;
    const auto width = static_cast<size_t>(pair.test.width()), height = static_cast<size_t>(pair.test.height());
    using Levels = std::bitset<finest_level + 1>;
    Levels levels; // one task after another adds to it: a union has no order
    std::vector<double> steps(height, -1.0);
    std::vector<Levels> chunks(chunk_count(height, rows_at_a_time));
    parallel_for(height, rows_at_a_time, [&](size_t begin, size_t end) {
        const auto step = [&](size_t row, size_t pixel, size_t neighbor) {
            if (!in_penumbra(pair, neighbor)) return;
            const double drawn = std::abs(double{pair.test.values()[pixel]} - double{pair.test.values()[neighbor]}),
                         true_step = std::abs(double{pair.reference.values()[pixel]} -
                                              double{pair.reference.values()[neighbor]});
            steps[row] = std::max(steps[row], drawn - true_step);
        };
        for (size_t row = begin; row < end; ++row)
            for (size_t column = 0; column < width; ++column) {
                const size_t pixel = row * width + column;
                if (!in_penumbra(pair, pixel)) continue;
                const double level = std::clamp(double{pair.test.values()[pixel]}, 0.0, 1.0) * finest_level;
                chunks[begin / rows_at_a_time].set(static_cast<size_t>(std::lround(level)));
                if (column + 1 < width) step(row, pixel, pixel + 1);
                if (row + 1 < height) step(row, pixel, pixel + width);
            }
    });
    for (const Levels& chunk : chunks) levels |= chunk;
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const double largest = *std::max_element(steps.begin(), steps.end());
    return {levels.any() ? static_cast<double>(levels.count()) : nan, levels.any() ? std::max(largest, 0.0) : nan};
}

} // namespace

Measure banding_measure() {
    Metric levels;
    levels.id = "banding_levels";
    levels.title = "levels of the penumbra";
    levels.formula = "number of different visibilities, to 1/65536, that the test has in the reference's penumbra";
    levels.range = "1 (flat) upwards; absent where the reference has no penumbra";
    levels.source = "the measure BAND of the specification of Macedo 2018: few levels are seen as bands";
    levels.blind_to = "where the levels are: noise has many and no bands";
    levels.lower_is_better = false;
    levels.domain = Metric::Domain::Visibility;
    Metric step = levels;
    step.id = "banding_step";
    step.title = "largest false step of the penumbra";
    step.formula = "largest of |step of the test| - |step of the reference| between neighbouring pixels that both lie "
                   "in the reference's penumbra; 0 where that is negative";
    step.range = "0 (no step that the reference lacks) to 1; absent where the reference has no penumbra";
    step.blind_to = "extent: one pair of pixels decides; bands that are as steep as the penumbra itself";
    step.lower_is_better = true;
    step.pooling = Metric::Pooling::Largest;
    return {{levels, step}, banding, nullptr};
}

} // namespace gnomon
