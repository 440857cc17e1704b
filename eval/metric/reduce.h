#pragma once
// Sums and maxima over the pixels that take part in a comparison, the same for any number of threads: chunks of fixed
// size are summed in double in row order, and then the chunks in order.

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "eval/metrics.h"

namespace gnomon {

inline bool takes_part(const ImagePair& pair, size_t pixel) {
    return (pair.mask.empty() || pair.mask.values()[pixel] != 0) && std::isfinite(pair.test.values()[pixel]) &&
           std::isfinite(pair.reference.values()[pixel]);
}

struct PixelSum {
    double sum = 0.0, largest = 0.0;
    std::int64_t count = 0;

    void add(double value) {
        sum += value;
        largest = std::max(largest, value);
        ++count;
    }
    void add(const PixelSum& other) {
        sum += other.sum;
        largest = std::max(largest, other.largest);
        count += other.count;
    }
    double mean() const {
        return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
    }
};

// visit(pixel, sum) for every pixel index, where it may sum.add(a value ≥ 0).
template <class Visit> PixelSum reduce_pixels(size_t pixels, Visit visit) {
    constexpr size_t grain = 1 << 14;
    std::vector<PixelSum> chunks(chunk_count(pixels, grain));
    parallel_for(pixels, grain, [&](size_t begin, size_t end) {
        PixelSum sum;
        for (size_t pixel = begin; pixel < end; ++pixel) visit(pixel, sum);
        chunks[begin / grain] = sum;
    });
    PixelSum total;
    for (const PixelSum& chunk : chunks) total.add(chunk);
    return total;
}

// value(test, reference) over the pixels that take part.
template <class Value> PixelSum reduce_differences(const ImagePair& pair, Value value) {
    return reduce_pixels(pair.test.size(), [&](size_t pixel, PixelSum& sum) {
        if (takes_part(pair, pixel))
            sum.add(value(double{pair.test.values()[pixel]}, double{pair.reference.values()[pixel]}));
    });
}

} // namespace gnomon
