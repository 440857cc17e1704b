#include "techniques/moments/bounds.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

template <class T> T gaussian_tail(T mean, T square, T t, T least_variance, T height) {
    if (t <= mean) return T(1);
    const T variance = std::max(square - mean * mean, least_variance);
    return saturate(height * std::erfc((t - mean) / std::sqrt(T(2) * variance)));
}

template <class T> T exponential(T z, T t, T c) { return saturate(std::exp(c * (z - t))); }

template <class T> ThreePoints<T> three_points(const FourMoments<T>& b, T t) {
    // B = L D Lᵀ with B = (1 b1 b2; b1 b2 b3; b2 b3 b4).
    const T least = T(1e-12);
    const T l10 = b.x, l20 = b.y;
    const T d11 = std::max(b.y - l10 * l10, least);
    const T l21 = (b.z - l20 * l10) / d11;
    const T d22 = std::max(b.w - l20 * l20 - l21 * l21 * d11, least);
    // L y = (1, t, t²), then D, then Lᵀ c = y.
    const T y1 = t - l10, y2 = t * t - l20 - l21 * y1;
    const T c2 = y2 / d22, c1 = y1 / d11 - l21 * c2;
    const T c0 = T(1) - l10 * c1 - l20 * c2;
    const T p = c1 / c2, q = c0 / c2;
    const T r = std::sqrt(std::max(p * p / T(4) - q, T(0)));
    return {-p / T(2) - r, -p / T(2) + r};
}

template <class T> glm::vec<3, T> three_weights(const FourMoments<T>& b, const ThreePoints<T>& points, T t) {
    // E[(z − u)(z − v)] is the share of the third point times (third − u)(third − v).
    const auto share = [&](T third, T u, T v) { return (u * v - b.x * (u + v) + b.y) / ((third - u) * (third - v)); };
    return {share(points.z1, points.z2, t), share(points.z2, points.z1, t), share(t, points.z1, points.z2)};
}

template <class T> T hamburger(const FourMoments<T>& b, T t) {
    const ThreePoints<T> points = three_points(b, t);
    if (t <= points.z1) return T(1);
    const glm::vec<3, T> weights = three_weights(b, points, t);
    return t <= points.z2 ? T(1) - saturate(weights.x) : saturate(weights.z);
}

template <class T> T hausdorff(const FourMoments<T>& b, T t) {
    if (t <= T(0) || t > T(1)) return t <= T(0) ? T(1) : T(0);
    const ThreePoints<T> points = three_points(b, t);
    const T m0 = b.x - b.y, m1 = b.y - b.z, m2 = b.z - b.w; // E[z(1 − z)], E[z²(1 − z)], E[z³(1 − z)]
    const T pull = m1 - t * m0;
    if ((points.z1 >= T(0) && points.z2 <= T(1)) || pull == T(0)) return hamburger(b, t);
    // E[z(1 − z)(z − t)(z − free)] = 0.
    const T free = std::clamp((m2 - t * m1) / pull, T(0), T(1));
    const T sum = t + free, product = t * free;
    T shadow = T(0);
    if (product > T(0)) shadow = (product - (sum + product) * b.x + (T(1) + sum) * b.y - b.z) / product; // share of 0
    if (free < t) {
        const T span = free * (T(1) - free) * (free - t);
        // Where the free depth has met 0, only 0, t and 1 are left.
        shadow = span != T(0) ? shadow + pull / span : (t - (T(1) + t) * b.x + b.y) / t;
    }
    return T(1) - saturate(shadow);
}

double FourierSeries::amplitude(int k) const {
    const double share = static_cast<double>(k) / terms;
    return 2.0 * std::exp(-static_cast<double>(attenuation) * share * share) / frequency(k);
}

dvec2 FourierSeries::cos_sin(double angle) { return {std::cos(angle), std::sin(angle)}; }

template float gaussian_tail(float, float, float, float, float);
template double gaussian_tail(double, double, double, double, double);
template float exponential(float, float, float);
template double exponential(double, double, double);
template ThreePoints<float> three_points(const FourMoments<float>&, float);
template ThreePoints<double> three_points(const FourMoments<double>&, double);
template glm::vec<3, float> three_weights(const FourMoments<float>&, const ThreePoints<float>&, float);
template glm::vec<3, double> three_weights(const FourMoments<double>&, const ThreePoints<double>&, double);
template float hamburger(const FourMoments<float>&, float);
template double hamburger(const FourMoments<double>&, double);
template float hausdorff(const FourMoments<float>&, float);
template double hausdorff(const FourMoments<double>&, double);

} // namespace gnomon
