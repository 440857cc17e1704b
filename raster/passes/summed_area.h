#pragma once
// Summed-area tables: the mean of a map over any rectangle with at most sixteen fetches, which is how soft shadows of
// filterable maps get their blocker depths and filters. [Crow 1984; Hensley et al. 2005; Macedo 2018, 2.24]
//
// SAT(x, y) = Σ over x' ≤ x, y' ≤ y of the map, in one of four arithmetics:
// * std::int64_t: values rounded to fixed point, exact sums: the reference.
// * std::uint32_t: the same in 32 bits that wrap around, for values that are not negative: right for every box whose
//   own sum, border texels whole, is below 2³². [Peters et al. 2016]
// * double: rows from the left, then columns from the bottom.
// * float: what a GPU gets. Recursive doubling, out(x) = in(x) + in(x − 2^k) for k = 0, 1, …, along rows and then along
//   columns. At 2048² texels of mean ½ its ulp at the far corner is ¼; `offset` ½ helps.
//
// Cost: whatever the arithmetic, the recursive doubling of a GPU: ⌈log2 w⌉ + ⌈log2 h⌉ passes, in which a texel with a
// partner fetches two texels and any other one. The ping-pong copy counts as memory while the table is built.

#include <memory>
#include <vector>

#include "core/large_memory.h"
#include "raster/passes/metered.h"
#include "raster/target.h"

namespace gnomon {

struct SummedAreaOptions {
    float offset = 0.0f;    // subtracted from every value before it is summed, added again to means
    int fraction_bits = 20; // fixed point: values are multiples of 2^−fraction_bits, rounded to nearest even, 0 to 31
    int layer = 0;          // of the source
    std::shared_ptr<MemoryMeter> meter = nullptr;
};

template <class T> struct SummedArea {
    int width, height, channels;
    float offset;
    double unit;                            // of a stored 1: 2^−fraction_bits, or 1
    std::vector<T, LargeAllocator<T>> sums; // row by row from the bottom, channels interleaved
    MeteredBytes metered;

    T sum(int x, int y, int c) const { // zero left of the map and under it
        if (x < 0 || y < 0) return T(0);
        return sums[(static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) *
                        static_cast<size_t>(channels) +
                    static_cast<size_t>(c)];
    }
};

// Of all channels of one layer of `source`, of any format but integer and stencil ones. In fixed point a value beyond
// ±2^(32 − fraction_bits) is clamped to it, so that no map overflows 64 bits, and NaN is 0; 32 bits take [0, 2^(32 −
// fraction_bits)). T is one of the four.
template <class T> SummedArea<T> summed_area(Pass& pass, const Target& source, const SummedAreaOptions& options = {});

// The sum of stored values over texels first to last, both included and inside the map; first ≤ last. Integers: exact.
// Floats: (SAT(x1, y1) − SAT(x0−1, y1)) − SAT(x1, y0−1) + SAT(x0−1, y0−1). Missing channels are 0. Fetches: 4 or fewer.
template <class T> glm::vec<4, T> box_sum(const SummedArea<T>& table, ivec2 first, ivec2 last, PassCounters& counters);

// The mean over the rectangle from `low` to `high` in texels (texel i covers [i, i + 1)), in the units of the source:
// the integral of the piecewise constant map over its area, by interpolating the table between integer corners. [Macedo
// 2018, 2.29b] The rectangle is cut off at the map's border; where nothing is left of a side, the texel column or row
// nearest to it is meant. The float table is evaluated in float, from four bilinear taps; the others in double, from
// sums relative to the rectangle's lower corner texel. Fetches: 16 or fewer.
template <class T> dvec4 box_mean(const SummedArea<T>& table, dvec2 low, dvec2 high, PassCounters& counters);

} // namespace gnomon
