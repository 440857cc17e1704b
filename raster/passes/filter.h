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

// The same in log space, for exponential shadow maps whose warp would overflow: destination = x₀ + ln(Σ weights[k] ·
// e^(c·(x[k] − x₀)))/c, x₀ the largest x[k], so that no power exceeds 1. What comes out is of the source's kind again:
// e^(c·destination) is the filtered e^(c·x), and rows may follow columns. Finite values, positive weights, c > 0 per
// unit of the source. Same cost as above. [Macedo 2018, 2.20]
void convolve_rows_log(Pass& pass, const Target& source, Target& destination, std::span<const float> weights, float c);
void convolve_columns_log(Pass& pass, const Target& source, Target& destination, std::span<const float> weights,
                          float c);

// C(n−1, k) / 2^(n−1), computed in double: σ² = (n − 1)/4 texels². [Macedo 2018, 2.19]
std::vector<float> binomial_weights(int n);

// e^(−(k − (n−1)/2)²/(2σ²)), σ in texels, normalised in double and then rounded.
std::vector<float> gaussian_weights(int n, double sigma);

// n equal weights: the box filter.
std::vector<float> box_weights(int n);

} // namespace gnomon
