#include "eval/metric/classes.h"

#include "eval/metric/all.h"
#include "eval/metric/reduce.h"

namespace gnomon {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<double> summaries(const ConfusionTable& table) {
    std::int64_t all = 0, right = 0;
    double overlaps = 0.0;
    int classes = 0;
    for (size_t c = 0; c < 3; ++c) {
        std::int64_t in_either = -table[c][c];
        for (size_t other = 0; other < 3; ++other) {
            all += table[c][other];
            in_either += table[c][other] + table[other][c];
        }
        right += table[c][c];
        if (in_either == 0) continue;
        overlaps += static_cast<double>(table[c][c]) / static_cast<double>(in_either);
        ++classes;
    }
    if (all == 0) return {nan, nan};
    return {static_cast<double>(all - right) / static_cast<double>(all), overlaps / classes};
}

} // namespace

ConfusionTable count_classes(const ImagePair& pair) {
    constexpr size_t grain = 1 << 14;
    std::vector<ConfusionTable> chunks(chunk_count(pair.test.size(), grain), ConfusionTable{});
    parallel_for(pair.test.size(), grain, [&](size_t begin, size_t end) {
        ConfusionTable table{};
        for (size_t pixel = begin; pixel < end; ++pixel)
            if (takes_part(pair, pixel))
                ++table[static_cast<size_t>(shadow_class(pair.reference.values()[pixel]))]
                       [static_cast<size_t>(shadow_class(pair.test.values()[pixel]))];
        chunks[begin / grain] = table;
    });
    ConfusionTable total{};
    for (const ConfusionTable& chunk : chunks)
        for (size_t r = 0; r < 3; ++r)
            for (size_t t = 0; t < 3; ++t) total[r][t] += chunk[r][t];
    return total;
}

Measure classes_measure() {
    Metric error;
    error.id = "class_error";
    error.title = "wrong class";
    error.formula = "share of the pixels whose class differs from the reference's: umbra (visibility <= 0.005), "
                    "penumbra, lit (>= 0.995); the whole 3x3 table is the key 'confusion' of the JSON";
    error.range = "0 (all classes right) to 1";
    error.source = "the off-diagonal part of the confusion matrix";
    error.blind_to = "errors inside the penumbra, and how far a class is off; a large lit surroundings dilutes it";
    error.domain = Metric::Domain::Visibility;
    Metric overlap = error;
    overlap.id = "class_iou";
    overlap.title = "overlap of the classes";
    overlap.formula = "mean over the classes that either image has of (pixels of the class in both) / (pixels of the "
                      "class in either)";
    overlap.range = "0 to 1 (all classes right)";
    overlap.source = "the Jaccard index of each class [Jaccard 1901], averaged";
    overlap.blind_to = "errors inside the penumbra; a class of few pixels weighs as much as one of many";
    overlap.lower_is_better = false;
    return {{error, overlap}, [](const ImagePair& pair) { return summaries(count_classes(pair)); }, nullptr};
}

} // namespace gnomon
