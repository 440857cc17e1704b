#pragma once
// Where on the unit square of a light the samples lie.

#include <cstdint>
#include <span>
#include <vector>

#include "core/math.h"

namespace gnomon {

enum class Pattern : std::uint8_t {
    Sobol,      // Owen-scrambled (0,2)-sequence, another scramble in every pixel
    Stratified, // one point anywhere in each cell of a grid, another jitter in every pixel
    Grid,       // the cells' centres, the same for every pixel: the theses' average of n² lights
    Random,     // independent, another sequence in every pixel
    Halton,     // radical inverses in bases 2 and 3, digits permuted differently in every pixel
    Poisson,    // best-candidate points, shifted around the square differently in every pixel
};
inline constexpr const char* pattern_choices =
    "sobol|stratified|grid|random|halton|poisson"; // in the order of the enumerators

// Whether the points of fewer samples are the first of more, so that a run can be continued with more samples. The
// cells of Stratified and Grid are others for every number of samples.
constexpr bool is_sequence(Pattern pattern) { return pattern != Pattern::Stratified && pattern != Pattern::Grid; }

// Fills `points` (all of the N samples) for one pixel, each in [0,1)². Grid and Stratified divide the square into
// round(√N) rows of N/rows cells, or one more, all of the same area: n×n where N = n².
void fill_pattern(Pattern pattern, std::uint32_t pixel, std::uint32_t seed, std::span<vec2> points);

// The same points for many pixels: what does not depend on the pixel is made once, and the points come as two arrays in
// an order of ours. Packed puts samples next to each other that lie close together on the light, so that a packet of
// rays stays together; the set of points is the same.
enum class SampleOrder : std::uint8_t { Sequence, Packed };

struct PatternCell {
    float column = 0, columns = 1; // in its row
    float first = 0;               // how many cells the rows before it have
};

// Cell i of so many.
PatternCell grid_cell(std::uint32_t i, std::uint32_t samples);

struct PreparedPattern {
    Pattern pattern = Pattern::Sobol;
    std::uint32_t samples = 0;        // N, the points before `first` included
    std::vector<std::uint32_t> index; // per point: its place in the sequence
    std::vector<PatternCell> cells;   // Stratified and Grid: per point
    // Per point, Sobol: the unscrambled coordinates, bits reversed; Halton: x likewise; Poisson: the coordinates × 2³².
    std::vector<std::uint32_t> x, y;
    std::size_t size() const { return index.size(); }
};
// Points first … samples − 1 of a pattern of so many. Throws UsageError unless 0 ≤ first < samples.
PreparedPattern prepare_pattern(Pattern pattern, int samples, SampleOrder order, int first = 0);
void fill_pattern(const PreparedPattern& prepared, std::uint32_t pixel, std::uint32_t seed, std::span<float> u,
                  std::span<float> v);

} // namespace gnomon
