#include "raytrace/error_bar.h"

#include <algorithm>
#include <cmath>

namespace gnomon {
namespace {

double independent(double n, double s) { return std::sqrt((s + 1) * (n - s + 1) / ((n + 2) * (n + 2) * (n + 3))); }

double paired_strata(const PreparedPattern& prepared, const SampleBits& bits, double n) {
    std::uint32_t different = 0;
    if (!bits.all_alike())
        for (size_t k = 1; k < prepared.size(); k += 2)
            different += bits[prepared.index[k - 1]] != bits[prepared.index[k]];
    return std::sqrt(different + 1.0) / n;
}

// Rows of the grid may differ in length by one: a cell's neighbour above is the one over its middle.
double straight_edge(const PreparedPattern& prepared, const SampleBits& bits, double n) {
    float longest = 1;
    for (const PatternCell& cell : prepared.cells) longest = std::max(longest, cell.columns);
    longest = std::max(longest, std::ceil(static_cast<float>(n) / longest));
    std::uint32_t beside_others = 0;
    if (!bits.all_alike()) {
        std::vector<bool> marked(prepared.size());
        const auto compare = [&](std::uint32_t a, std::uint32_t b) {
            if (bits[a] != bits[b]) marked[a] = marked[b] = true;
        };
        for (size_t k = 0; k < prepared.size(); ++k) {
            const PatternCell& cell = prepared.cells[k];
            const std::uint32_t i = prepared.index[k];
            if (cell.column + 1 < cell.columns) compare(i, i + 1);
            const auto next_row = static_cast<std::uint32_t>(cell.first + cell.columns);
            if (next_row >= prepared.samples) continue;
            const PatternCell above = grid_cell(next_row, prepared.samples);
            compare(i, next_row + static_cast<std::uint32_t>((cell.column + 0.5f) / cell.columns * above.columns));
        }
        beside_others = static_cast<std::uint32_t>(std::count(marked.begin(), marked.end(), true));
    }
    return (beside_others + static_cast<double>(longest)) / (2 * n);
}

} // namespace

float error_bar(const PreparedPattern& prepared, const SampleBits& bits) {
    const auto n = static_cast<double>(prepared.samples);
    switch (prepared.pattern) {
    case Pattern::Random:
        return static_cast<float>(independent(n, bits.seen_of(prepared.samples)));
    case Pattern::Grid:
        return static_cast<float>(std::min(1.0, straight_edge(prepared, bits, n)));
    default:
        return static_cast<float>(paired_strata(prepared, bits, n));
    }
}

} // namespace gnomon
