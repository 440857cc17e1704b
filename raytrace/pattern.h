#pragma once
// Where on the unit square of a light the samples lie.

#include <cstdint>
#include <span>
#include <vector>

#include "core/math.h"

namespace gnomon {

enum class Pattern : std::uint8_t {
    Sobol,      // Owen-scrambled (0,2)-sequence, another scramble in every pixel; progressive
    Stratified, // jittered n×n cells, another jitter in every pixel
    Grid,       // n×n cell centres, the same for every pixel: the theses' average of n² lights
    Random,     // independent, another sequence in every pixel
};
inline constexpr const char* pattern_choices = "sobol|stratified|grid|random"; // in the order of the enumerators

// Fills `points` (all of the N samples) for one pixel. Grid and Stratified need N to be a square; where it is not they
// use the n×m grid with n·m = N and n, m as near as possible, and throw UsageError where N is a prime above 3.
void fill_pattern(Pattern pattern, std::uint32_t pixel, std::uint32_t seed, std::span<vec2> points);

// The same points for many pixels: what does not depend on the pixel is made once, and the points come as two arrays in
// an order of ours. Packed puts samples next to each other that lie close together on the light, so that a packet of
// rays stays together; the set of points is the same.
enum class SampleOrder : std::uint8_t { Sequence, Packed };

struct PreparedPattern {
    Pattern pattern = Pattern::Sobol;
    ivec2 cells{1};                   // Stratified and Grid: columns and rows
    std::vector<std::uint32_t> index; // per point: its place in the sequence
    std::vector<std::uint32_t> x, y;  // Sobol: the unscrambled coordinates, bits reversed
    size_t size() const { return index.size(); }
};
PreparedPattern prepare_pattern(Pattern pattern, int samples, SampleOrder order); // errors as fill_pattern
void fill_pattern(const PreparedPattern& prepared, std::uint32_t pixel, std::uint32_t seed, std::span<float> u,
                  std::span<float> v);

} // namespace gnomon
