#include "core/error.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace gnomon {
namespace {

// Insertions, deletions, substitutions and swaps of neighbours count one each (optimal string alignment).
size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<size_t> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
    std::iota(row.begin(), row.end(), size_t{0});
    for (size_t i = 0; i < a.size(); ++i) {
        next[0] = i + 1;
        for (size_t j = 0; j < b.size(); ++j) {
            next[j + 1] = std::min({row[j] + (a[i] != b[j]), row[j + 1] + 1, next[j] + 1});
            if (i > 0 && j > 0 && a[i] == b[j - 1] && a[i - 1] == b[j])
                next[j + 1] = std::min(next[j + 1], before[j - 1] + 1);
        }
        std::swap(before, row);
        std::swap(row, next);
    }
    return row.back();
}

} // namespace

std::string did_you_mean(std::string_view word, std::span<const std::string> candidates) {
    const std::string* nearest = nullptr;
    size_t nearest_distance = std::max<size_t>(1, word.size() / 2) + 1;
    for (const std::string& candidate : candidates) {
        const size_t distance = edit_distance(word, candidate);
        if (distance < nearest_distance) nearest = &candidate, nearest_distance = distance;
    }
    return nearest ? "; did you mean '" + *nearest + "'?" : "";
}

} // namespace gnomon
