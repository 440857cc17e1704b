#pragma once
// Separable filters over whole targets, as two full-screen passes.

#include <span>
#include <vector>

#include "raster/target.h"

namespace gnomon {

// destination = Σ weights[k] · source(x + k − n/2, y) along rows, or along columns; the edge texel repeats outside.
// Sums run from the lowest k up, in float. Both targets are of the same size and layers; every layer is filtered on its
// own.
void convolve_rows(Pass& pass, const Target& source, Target& destination, std::span<const float> weights);
void convolve_columns(Pass& pass, const Target& source, Target& destination, std::span<const float> weights);

// C(n−1, k) / 2^(n−1), computed in double: σ² = (n − 1)/4 texels². [Macedo 2018, 2.19]
std::vector<float> binomial_weights(int n);

// n equal weights: the box filter.
std::vector<float> box_weights(int n);

} // namespace gnomon
