#pragma once
// What the filtered moments of a map say about a receiver at depth t: how much of the light gets past the depths that
// they were taken of. Each answer is a fraction lit, 1 where nothing is nearer than t; Chebyshev's, Hamburger's and
// Hausdorff's are bounds that no distribution with those moments exceeds. [Macedo 2018, 2.4]
//
// T is float, as in a program on the GPU, or double, for references. Answers lie in [0, 1]; where an overflow has left
// NaN they are 0, as a GPU's clamp has it. Depths grow away from the light; for the moment problems and for the Fourier
// series they lie in [0, 1].

#include "core/math.h"

namespace gnomon {

template <class T> T saturate(T value) { return value > T(0) ? (value < T(1) ? value : T(1)) : T(0); }

// Upper bound from mean and mean square: t ≤ μ ? 1 : σ²/(σ² + (t − μ)²), σ² at least `least_variance`. Exact for two
// layers of which t is the farther. [Donnelly and Lauritzen 2006, eq. 5]
template <class T> T chebyshev(T mean, T square, T t, T least_variance) {
    if (t <= mean) return T(1);
    const T spread = square - mean * mean, variance = spread > least_variance ? spread : least_variance;
    return saturate(variance / (variance + (t - mean) * (t - mean)));
}

// As if depths were distributed normally: ½ erfc((t − μ)/(σ√2)), 1 for t ≤ μ: no bound. `height` is what it has just
// behind μ: ½ as the distribution function says, which leaves a step there, or 1, which meets the other branch.
// [Gumbau et al. 2013, 3.2]
template <class T> T gaussian_tail(T mean, T square, T t, T least_variance, T height);

// e^(c(z − t)) for the z whose e^(cz) is the filtered one: an upper bound for c > 0. [Annen et al. 2008, eq. 5]
template <class T> T exponential(T z, T t, T c);

// Fractions up to `amount` are dark, the rest is stretched. [Lauritzen 2007, GPU Gems 3, 8.4.3]
template <class T> T reduce_bleeding(T lit, T amount) { return saturate((lit - amount) / (T(1) - amount)); }

// E[z], E[z²], E[z³], E[z⁴].
template <class T> using FourMoments = glm::vec<4, T>;
template <class T> FourMoments<T> four_moments(T z) { return {z, z * z, z * z * z, (z * z) * (z * z)}; }

// Moments of distributions that others are blended with, so that rounding leaves them those of a distribution: a half
// at 0 and a half at 1 [Peters and Klein 2015, 3.3]; or 3/16 there and 5/8 at ½, which helps where all depths lie at
// the two ends as well [Peters et al. 2017, with (0, 0.375, 0, 0.375) for depths in −1 to 1].
template <class T> inline constexpr FourMoments<T> moments_of_ends{T(0.5), T(0.5), T(0.5), T(0.5)};
template <class T>
inline constexpr FourMoments<T> moments_of_ends_and_middle{T(0.5), T(0.34375), T(0.265625), T(0.2265625)};
template <class T>
FourMoments<T> biased(const FourMoments<T>& b, T amount, const FourMoments<T>& towards = moments_of_ends<T>) {
    return b * (T(1) - amount) + towards * amount;
}

// The depths z1 ≤ z2 which, together with t, carry a distribution of these moments on three points.
// They are the roots of c0 + c1 z + c2 z², where c solves the Hankel system B c = (1, t, t²). [Peters and Klein 2015,
// algorithm 2]
template <class T> struct ThreePoints { T z1, z2; };
template <class T> ThreePoints<T> three_points(const FourMoments<T>& b, T t);

// The share of z1, z2 and t in that distribution.
template <class T> glm::vec<3, T> three_weights(const FourMoments<T>& b, const ThreePoints<T>& points, T t);

// The sharp upper bound from four moments of depths anywhere: 1 less the share of the points in front of t. [Peters and
// Klein 2015, algorithm 2]
template <class T> T hamburger(const FourMoments<T>& b, T t);

// The sharp upper bound where depths are known to lie in [0, 1]: Hamburger's where its points do; else the distribution
// on 0, t, 1 and the one depth that the moments leave. Never above Hamburger's. [Peters and Klein 2015, algorithm 3]
template <class T> T hausdorff(const FourMoments<T>& b, T t);

// The shadow test as a series, f(z − t) ≈ z ≥ t: ½ + 2 Σ a_k/c_k sin(c_k(z − t)) over k = 1 … terms, c_k = π(2k − 1),
// attenuated by a_k = e^(−attenuation·(k/terms)²) against ringing. Period 2: depths must lie within less than 1 of one
// another. [Annen et al. 2007, eq. 8 and 13]
struct FourierSeries {
    int terms = 16;
    float attenuation = 0.0f;

    double frequency(int k) const { return pi * (2 * k - 1); }
    double amplitude(int k) const; // 2 a_k/c_k

    // With basis(k) -> E[cos(c_k z)], E[sin(c_k z)]; not clamped.
    template <class Basis> double value(double t, const Basis& basis) const {
        double sum = 0.5;
        for (int k = 1; k <= terms; ++k) {
            const dvec2 mean = basis(k), at = cos_sin(frequency(k) * t);
            sum += amplitude(k) * (at.x * mean.y - at.y * mean.x);
        }
        return sum;
    }
    static dvec2 cos_sin(double angle);
};

} // namespace gnomon
