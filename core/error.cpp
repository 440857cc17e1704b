#include "core/error.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace gnomon {
namespace {

size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), size_t{0});
    for (size_t i = 0; i < a.size(); ++i) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < b.size(); ++j) {
            const size_t substituted = diagonal + (a[i] != b[j]);
            diagonal = row[j + 1];
            row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
        }
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
