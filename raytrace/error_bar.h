#pragma once
// How far an estimate of visibility may be from the truth, from the samples alone.

#include <cstdint>
#include <span>

#include "raytrace/pattern.h"
#include "raytrace/sample_bits.h"

namespace gnomon {

// The error of the visible fraction of the first n samples, where `prepared` are those n in packed order. Never 0: n
// samples that agree leave room for what fell between them.
// - Random: the standard deviation of the fraction given the samples, (s+1)(n−s+1)/((n+2)²(n+3)) under the root, which
//   is that of a Beta(s+1, n−s+1) [Bayes; Laplace's rule of succession].
// - Stratified, Sobol, Halton, Poisson: the standard error of one sample a stratum, from d, how many pairs of
//   neighbouring strata disagree: √(d+1)/n. Collapsing strata in pairs overestimates by what the strata differ
//   [Cochran 1977, "Sampling Techniques", 5A.12].
// - Grid: a bound that is strict where one straight edge crosses the light: a cell that the edge cuts is wrong by at
//   most half its area and has a neighbour of the other answer, unless it lies at the light's border:
//   (cells with such a neighbour + the longer side of the grid) / 2n.
float error_bar(const PreparedPattern& prepared, const SampleBits& bits);

} // namespace gnomon
