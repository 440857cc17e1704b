#include "raster/tessellate.h"

#include <algorithm>
#include <cmath>

namespace gnomon {
namespace {

constexpr float most_pieces = 64.0f;

// How an edge is cut: n pieces, the inner ones of length 1/f.
struct Subdivision {
    int n;
    double f;

    double t(int k) const { return k <= 0 ? 0.0 : k >= n ? 1.0 : (f - n + 2 * k) / (2.0 * f); }
};

Subdivision subdivision(Spacing spacing, float factor) {
    switch (spacing) {
    case Spacing::FractionalOdd: {
        const float f = std::clamp(factor, 1.0f, most_pieces - 1.0f);
        return {static_cast<int>(std::ceil((f - 1.0f) / 2.0f)) * 2 + 1, static_cast<double>(f)};
    }
    case Spacing::FractionalEven: {
        const float f = std::clamp(factor, 2.0f, most_pieces);
        return {static_cast<int>(std::ceil(f / 2.0f)) * 2, static_cast<double>(f)};
    }
    default: {
        const float n = std::ceil(std::clamp(factor, 1.0f, most_pieces));
        return {static_cast<int>(n), static_cast<double>(n)};
    }
    }
}

// Inner factors: 1 only where the whole patch stays whole.
Subdivision inner_subdivision(Spacing spacing, float factor) {
    constexpr float little_above_one = 1.0f + 0x1p-10f;
    const Subdivision s = subdivision(spacing, factor);
    return s.n > 1 ? s : subdivision(spacing, little_above_one);
}

// The strip between an outer row of points and the inner row above it, both from left to right.
void stitch(const std::vector<std::uint32_t>& outer, const std::vector<std::uint32_t>& inner,
            std::vector<uvec3>& triangles) {
    const size_t p = outer.size() - 1, q = inner.size() - 1;
    for (size_t i = 0, j = 0; i < p || j < q;) {
        // The middle of outer piece i lies at (i + ½)/p, that of inner piece j at (j + 1½)/(q + 2) of the outer length.
        const bool step_outer = j == q || (i < p && (2 * i + 1) * (q + 2) <= (2 * j + 3) * p);
        if (step_outer) {
            triangles.push_back({outer[i], outer[i + 1], inner[j]});
            ++i;
        } else {
            triangles.push_back({outer[i], inner[j + 1], inner[j]});
            ++j;
        }
    }
}

// The points of a closed ring, one side after the other; sides share their corners.
struct Ring {
    std::uint32_t first;
    std::vector<int> pieces; // of each side

    std::vector<std::uint32_t> side(size_t s) const {
        int before = 0, total = 0;
        for (size_t i = 0; i < pieces.size(); ++i) {
            if (i < s) before += pieces[i];
            total += pieces[i];
        }
        std::vector<std::uint32_t> points;
        for (int k = 0; k <= pieces[s]; ++k)
            points.push_back(first + static_cast<std::uint32_t>(total == 0 ? 0 : (before + k) % total));
        return points;
    }
};

// The outline of a patch: side s runs from corner s to the next.
Ring outline(const std::vector<Subdivision>& sides, PatchPattern& pattern) {
    Ring ring{static_cast<std::uint32_t>(pattern.weights.size()), {}};
    const int corners = static_cast<int>(sides.size());
    for (int s = 0; s < corners; ++s) {
        const Subdivision& cut = sides[static_cast<size_t>(s)];
        for (int k = 0; k < cut.n; ++k) {
            dvec4 w(0.0);
            w[s] = cut.t(cut.n - k);
            w[(s + 1) % corners] = cut.t(k);
            pattern.weights.push_back(w);
        }
        ring.pieces.push_back(cut.n);
    }
    return ring;
}

// Ring r inside a triangle. Its corners are where the perpendiculars to the edges at t(r) meet: (1 − 4t/3, 2t/3, 2t/3);
// its points keep the spacing of the edge.
Ring inner_ring(const Subdivision& inner, int r, PatchPattern& pattern) {
    Ring ring{static_cast<std::uint32_t>(pattern.weights.size()), {}};
    const int pieces = inner.n - 2 * r;
    const double inset = inner.t(r) / 3.0;
    if (pieces == 0) pattern.weights.push_back(dvec4(1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0));
    for (int s = 0; s < 3; ++s) {
        for (int k = 0; k < pieces; ++k) {
            dvec4 w(0.0);
            w[s] = inner.t(inner.n - r - k) - inset;
            w[(s + 1) % 3] = inner.t(r + k) - inset;
            w[(s + 2) % 3] = 2.0 * inset;
            pattern.weights.push_back(w);
        }
        ring.pieces.push_back(pieces);
    }
    return ring;
}

PatchPattern tessellate_triangle(Spacing spacing, const PatchLevels& levels) {
    PatchPattern pattern;
    std::vector<Subdivision> sides; // AB, BC, CA
    for (const size_t edge : {2u, 0u, 1u}) sides.push_back(subdivision(spacing, levels.outer[edge]));
    Ring ring = outline(sides, pattern);
    const bool outline_whole = pattern.weights.size() == 3;
    if (outline_whole && subdivision(spacing, levels.inner[0]).n == 1) {
        pattern.triangles.push_back({0, 1, 2});
        return pattern;
    }
    const Subdivision inner = inner_subdivision(spacing, levels.inner[0]);
    for (int r = 1; 2 * r <= inner.n; ++r) {
        Ring next = inner_ring(inner, r, pattern);
        for (size_t s = 0; s < 3; ++s) stitch(ring.side(s), next.side(s), pattern.triangles);
        ring = std::move(next);
    }
    if (inner.n % 2 == 1) pattern.triangles.push_back({ring.first, ring.first + 1, ring.first + 2});
    return pattern;
}

PatchPattern tessellate_quad(Spacing spacing, const PatchLevels& levels) {
    PatchPattern pattern;
    std::vector<Subdivision> sides; // v = 0, u = 1, v = 1, u = 0
    for (const size_t edge : {1u, 2u, 3u, 0u}) sides.push_back(subdivision(spacing, levels.outer[edge]));
    const Ring ring = outline(sides, pattern);
    const bool outline_whole = pattern.weights.size() == 4;
    if (outline_whole && subdivision(spacing, levels.inner[0]).n == 1 && subdivision(spacing, levels.inner[1]).n == 1) {
        pattern.triangles = {{0, 1, 3}, {1, 2, 3}};
        return pattern;
    }
    // The grid of inner points, (i, j) for 0 < i < n and 0 < j < m.
    const Subdivision u = inner_subdivision(spacing, levels.inner[0]), v = inner_subdivision(spacing, levels.inner[1]);
    const auto first = static_cast<std::uint32_t>(pattern.weights.size());
    const auto at = [&](int i, int j) { return first + static_cast<std::uint32_t>((j - 1) * (u.n - 1) + i - 1); };
    for (int j = 1; j < v.n; ++j)
        for (int i = 1; i < u.n; ++i) {
            const double right = u.t(i), left = u.t(u.n - i), top = v.t(j), bottom = v.t(v.n - j);
            pattern.weights.push_back({left * bottom, right * bottom, right * top, left * top});
        }
    for (int j = 1; j + 1 < v.n; ++j)
        for (int i = 1; i + 1 < u.n; ++i) {
            pattern.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
            pattern.triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    std::array<std::vector<std::uint32_t>, 4> rows;
    for (int i = 1; i < u.n; ++i) rows[0].push_back(at(i, 1)), rows[2].push_back(at(u.n - i, v.n - 1));
    for (int j = 1; j < v.n; ++j) rows[1].push_back(at(u.n - 1, j)), rows[3].push_back(at(1, v.n - j));
    for (size_t s = 0; s < 4; ++s) stitch(ring.side(s), rows[s], pattern.triangles);
    return pattern;
}

} // namespace

PatchLevels PatchLevels::from_edges(PatchShape shape, std::array<float, 4> outer) {
    if (shape == PatchShape::Triangle) {
        const float most = std::max({outer[0], outer[1], outer[2]});
        return {outer, {most, most}};
    }
    return {outer, {std::max(outer[1], outer[3]), std::max(outer[0], outer[2])}};
}

float edge_level(vec2 a, vec2 b, float piece, int most) {
    const vec2 d = a - b; // its negation squares alike
    const float pieces = std::ceil(std::sqrt(d.x * d.x + d.y * d.y) / piece);
    return pieces > 1.0f ? std::min(pieces, static_cast<float>(most)) : 1.0f;
}

PatchPattern tessellate_patch(PatchShape shape, Spacing spacing, const PatchLevels& levels) {
    const size_t edges = shape == PatchShape::Triangle ? 3 : 4;
    for (size_t i = 0; i < edges; ++i)
        if (!(levels.outer[i] > 0.0f)) return {};
    PatchLevels valid = levels;
    for (float& inner : valid.inner) inner = inner > 1.0f ? inner : 1.0f; // NaN too
    return shape == PatchShape::Triangle ? tessellate_triangle(spacing, valid) : tessellate_quad(spacing, valid);
}

detail::PatternKey detail::pattern_key(Spacing spacing, const PatchLevels& levels) {
    PatternKey key = {levels.outer[0], levels.outer[1], levels.outer[2],
                      levels.outer[3], levels.inner[0], levels.inner[1]};
    for (float& level : key) {
        if (!(level > 0.0f)) level = 0.0f; // NaN would break the order of keys
        level = spacing == Spacing::Equal ? std::ceil(std::min(level, most_pieces)) : std::min(level, most_pieces);
    }
    return key;
}

} // namespace gnomon
