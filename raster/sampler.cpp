#include "raster/sampler.h"
#include "raster/compare.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gnomon {
namespace {

constexpr int outside = -1;

// The texel that coordinate i of a row of n stands for, or `outside`.
int wrapped(Wrap wrap, int i, int n) {
    switch (wrap) {
    case Wrap::Clamp:
        return std::clamp(i, 0, n - 1);
    case Wrap::Border:
        return i >= 0 && i < n ? i : outside;
    case Wrap::Repeat:
        return (i % n + n) % n;
    case Wrap::Mirror: {
        const int m = (i % (2 * n) + 2 * n) % (2 * n);
        return m < n ? m : 2 * n - 1 - m;
    }
    }
    return i;
}

// A coordinate in texels as a whole part and a fraction in [0, 1], kept within int whatever the input; NaN becomes 0.
struct Coordinate {
    int whole;
    float fraction;
};
Coordinate split(float texels) {
    constexpr float limit = 1 << 24; // floats beyond are whole
    if (!(std::abs(texels) < limit)) return {texels > 0 ? 1 << 24 : texels < 0 ? -(1 << 24) : 0, 0.0f};
    int whole = static_cast<int>(texels); // towards zero: without a call to floor
    whole -= texels < static_cast<float>(whole);
    return {whole, texels - static_cast<float>(whole)};
}
int whole(float texels) { return split(texels).whole; }

// What a look-up makes of each texel before it filters.
struct Color {
    vec4 operator()(const vec4& texel) const { return texel; }
};
struct Comparison {
    float reference;
    Compare test;
    float operator()(const vec4& texel) const { return holds(test, reference, texel.x) ? 1.0f : 0.0f; }
};
Comparison comparison(const Target& depth, float reference, Compare test) {
    const bool clamped = info(depth.format()).kind == FormatInfo::Kind::Depth;
    return {clamped ? std::clamp(reference, 0.0f, 1.0f) : reference, test};
}
template <class Map> using Value = decltype(std::declval<Map>()(vec4()));

// The four texels around uv, (x, y) the lower left, and where between them it lies.
struct Footprint {
    int x, y;
    float fx, fy;
};

Footprint footprint(vec2 uv, int width, int height, bool subtexel8) {
    const Coordinate u = split(uv.x * static_cast<float>(width) - 0.5f);
    const Coordinate v = split(uv.y * static_cast<float>(height) - 0.5f);
    Footprint f = {u.whole, v.whole, u.fraction, v.fraction};
    if (subtexel8) {
        f.fx = std::floor(f.fx * 256.0f + 0.5f) / 256.0f;
        f.fy = std::floor(f.fy * 256.0f + 0.5f) / 256.0f;
    }
    return f;
}

template <class T> T lerp(T a, T b, float t) { return a + (b - a) * t; }

template <class T> T bilinear(T a, T b, T c, T d, const Footprint& f) {
    return lerp(lerp(a, b, f.fx), lerp(c, d, f.fx), f.fy);
}

// One layer and level of a target, with its wrap modes.
struct Plane2d {
    const Target& texture;
    const Sampler& sampler;
    int layer, level;
    PassCounters& counters;

    vec4 texel(int x, int y) const {
        const int i = wrapped(sampler.wrap, x, texture.width(level));
        const int j = wrapped(sampler.wrap_v.value_or(sampler.wrap), y, texture.height(level));
        if (i == outside || j == outside) return sampler.border;
        count_texels(texture, 1, counters);
        return texture.load(i, j, layer, level);
    }

    template <class Map> Value<Map> filtered(Filter filter, vec2 uv, const Map& map) const {
        const int width = texture.width(level), height = texture.height(level);
        if (filter == Filter::Nearest)
            return map(texel(whole(uv.x * static_cast<float>(width)), whole(uv.y * static_cast<float>(height))));
        const Footprint f = footprint(uv, width, height, sampler.subtexel8);
        if (f.x >= 0 && f.y >= 0 && f.x + 1 < width && f.y + 1 < height) { // the common case wraps nothing
            count_texels(texture, 4, counters);
            const auto next = static_cast<size_t>(texture.texel_bytes());
            const std::byte* lower = texture.texel(f.x, f.y, layer, level);
            const std::byte* upper = lower + next * static_cast<size_t>(width);
            return bilinear(map(texture.load(lower)), map(texture.load(lower + next)), map(texture.load(upper)),
                            map(texture.load(upper + next)), f);
        }
        const auto at = [&](int i, int j) { return map(texel(f.x + i, f.y + j)); };
        return bilinear(at(0, 0), at(1, 0), at(0, 1), at(1, 1), f);
    }
};

// One level of the six faces of a cube, without seams.
struct CubeLevel {
    const Target& texture;
    const Sampler& sampler;
    int first_layer, level;
    PassCounters& counters;

    template <class Map> Value<Map> filtered(Filter filter, const CubePoint& point, const Map& map) const {
        const int n = texture.width(level);
        const vec2 uv = point.uv();
        const auto load = [&](const CubeTexel& t) {
            count_texels(texture, 1, counters);
            return map(texture.load(t.x, t.y, first_layer + t.face, level));
        };
        if (filter == Filter::Nearest) {
            const auto nearest = [&](float c) { return std::clamp(whole(c * static_cast<float>(n)), 0, n - 1); };
            return load({point.face, nearest(uv.x), nearest(uv.y)});
        }
        const Footprint f = footprint(uv, n, n, sampler.subtexel8);
        std::array<Value<Map>, 4> values{};
        std::array<int, 4> faces{};
        int missing = -1;
        for (int k = 0; k < 4; ++k) {
            const int x = f.x + (k & 1), y = f.y + (k >> 1);
            const auto slot = static_cast<size_t>(k);
            if ((x < 0 || x >= n) && (y < 0 || y >= n)) {
                missing = k;
                continue;
            }
            const CubeTexel t = cube_texel(point.face, x, y, n);
            faces[slot] = t.face;
            values[slot] = load(t);
        }
        if (missing >= 0) values[static_cast<size_t>(missing)] = corner_mean(values, faces, missing);
        return bilinear(values[0], values[1], values[2], values[3], f);
    }

    // Of the texels of three different faces, added in the order of the faces, so that all three see the same value.
    template <class T>
    static T corner_mean(const std::array<T, 4>& values, const std::array<int, 4>& faces, int missing) {
        T sum{};
        for (int face = 0; face < 6; ++face)
            for (int k = 0; k < 4; ++k)
                if (k != missing && faces[static_cast<size_t>(k)] == face) sum += values[static_cast<size_t>(k)];
        return sum / 3.0f;
    }
};

// Chooses the levels for λ and blends them; in_level(level, filter) filters within one. [OpenGL 4.6, eq. 8.15 to 8.18]
template <class InLevel>
auto filter_levels(const Target& texture, const Sampler& sampler, float lod, const InLevel& in_level) {
    const float lambda = std::min(std::max(lod + sampler.lod_bias, sampler.min_lod), sampler.max_lod);
    if (!(lambda > 0.0f)) return in_level(0, sampler.magnify.value_or(sampler.filter));
    const float last = static_cast<float>(texture.levels() - 1);
    if (sampler.mip == MipFilter::None || last == 0.0f) return in_level(0, sampler.filter);
    if (sampler.mip == MipFilter::Nearest)
        return in_level(static_cast<int>(std::min(std::ceil(lambda + 0.5f) - 1.0f, last)), sampler.filter);
    const float finer = std::floor(std::min(lambda, last)), fraction = std::min(lambda, last) - finer;
    const auto low = in_level(static_cast<int>(finer), sampler.filter);
    if (fraction == 0.0f) return low;
    return lerp(low, in_level(static_cast<int>(finer) + 1, sampler.filter), fraction);
}

// log2 of a double ≥ 0 by its series, in operations that every machine rounds alike (a library's may use fused
// multiply-adds or not). Exact for powers of two; within 1e-15 elsewhere.
double portable_log2(double x) {
    if (!(x > 0.0)) return x == 0.0 ? -std::numeric_limits<double>::infinity() : x;
    if (x > std::numeric_limits<double>::max()) return x;
    int exponent;
    double m = std::frexp(x, &exponent); // [½, 1)
    if (m < 0.70710678118654752) m *= 2.0, --exponent;
    const double s = (m - 1.0) / (m + 1.0), s2 = s * s; // ln m = 2(s + s³/3 + s⁵/5 + …), |s| < 0.172
    double sum = 0.0;
    for (int k = 21; k >= 1; k -= 2) sum = sum * s2 + 1.0 / k;
    return exponent + 2.0 * s * sum * 1.4426950408889634;
}

// The footprint of a pixel from its gradients in texels: how many look-ups, at which λ, along which of the two.
struct Probes {
    int count;
    float lod;
    bool along_y;
};

Probes probes(vec2 ddx, vec2 ddy, int max_anisotropy) {
    const auto length2 = [](vec2 d) {
        return static_cast<double>(d.x) * static_cast<double>(d.x) +
               static_cast<double>(d.y) * static_cast<double>(d.y);
    };
    const double x2 = length2(ddx), y2 = length2(ddy);
    const double most = std::max(x2, y2), least = std::min(x2, y2);
    const double lod = 0.5 * portable_log2(most);
    if (max_anisotropy <= 1 || !(most > 0.0)) return {1, static_cast<float>(lod), false};
    const double ratio = least > 0.0 ? std::ceil(std::sqrt(most) / std::sqrt(least)) : max_anisotropy;
    const int n = ratio < max_anisotropy ? std::max(1, static_cast<int>(ratio)) : max_anisotropy;
    return {n, static_cast<float>(lod - portable_log2(n)), y2 >= x2};
}

// The mean of look(lod, offset) over the probes, offset in units of the longer gradient.
template <class Look> auto average(const Probes& p, const Look& look) {
    if (p.count == 1) return look(p.lod, 0.0f);
    auto sum = look(p.lod, 1.0f / static_cast<float>(p.count + 1) - 0.5f);
    for (int i = 2; i <= p.count; ++i)
        sum += look(p.lod, static_cast<float>(i) / static_cast<float>(p.count + 1) - 0.5f);
    return sum / static_cast<float>(p.count);
}

template <class Map>
Value<Map> look_lod(const Target& texture, const Sampler& sampler, vec2 uv, float lod, int layer,
                    PassCounters& counters, const Map& map) {
    return filter_levels(texture, sampler, lod, [&](int level, Filter filter) {
        return Plane2d{texture, sampler, layer, level, counters}.filtered(filter, uv, map);
    });
}

template <class Map>
Value<Map> look_grad(const Target& texture, const Sampler& sampler, vec2 uv, vec2 ddx, vec2 ddy, int layer,
                     PassCounters& counters, const Map& map) {
    const vec2 size(static_cast<float>(texture.width()), static_cast<float>(texture.height()));
    const Probes p = probes(ddx * size, ddy * size, sampler.max_anisotropy);
    const vec2 axis = p.along_y ? ddy : ddx;
    return average(p, [&](float lod, float offset) {
        return look_lod(texture, sampler, uv + axis * offset, lod, layer, counters, map);
    });
}

template <class Map>
Value<Map> look_cube(const Target& texture, const Sampler& sampler, vec3 direction, float lod, int cube,
                     PassCounters& counters, const Map& map) {
    assert(texture.width() == texture.height() && 6 * cube + 6 <= texture.layers());
    const CubePoint point = cube_point(direction);
    return filter_levels(texture, sampler, lod, [&](int level, Filter filter) {
        return CubeLevel{texture, sampler, 6 * cube, level, counters}.filtered(filter, point, map);
    });
}

// The gradient of uv on the face from that of the direction, by the quotient rule.
vec2 face_gradient(const CubePoint& p, vec3 d) {
    const vec3 c = cube_face_coordinates(p.face, d);
    const float scale = 0.5f / (p.major * p.major);
    return {(c.x * p.major - p.sc * c.z) * scale, (c.y * p.major - p.tc * c.z) * scale};
}

} // namespace

float level_of_detail(const Target& texture, vec2 ddx, vec2 ddy) {
    const vec2 size(static_cast<float>(texture.width()), static_cast<float>(texture.height()));
    return probes(ddx * size, ddy * size, 1).lod;
}

vec4 sample(const Target& texture, const Sampler& sampler, vec2 uv, PassCounters& counters, int layer) {
    return Plane2d{texture, sampler, layer, 0, counters}.filtered(sampler.filter, uv, Color{});
}

vec4 sample_lod(const Target& texture, const Sampler& sampler, vec2 uv, float lod, PassCounters& counters, int layer) {
    return look_lod(texture, sampler, uv, lod, layer, counters, Color{});
}

vec4 sample_grad(const Target& texture, const Sampler& sampler, vec2 uv, vec2 ddx, vec2 ddy, PassCounters& counters,
                 int layer) {
    return look_grad(texture, sampler, uv, ddx, ddy, layer, counters, Color{});
}

float sample_compare(const Target& depth, const Sampler& sampler, vec2 uv, float reference, Compare test,
                     PassCounters& counters, int layer) {
    return Plane2d{depth, sampler, layer, 0, counters}.filtered(sampler.filter, uv, comparison(depth, reference, test));
}

float sample_compare_lod(const Target& depth, const Sampler& sampler, vec2 uv, float reference, Compare test, float lod,
                         PassCounters& counters, int layer) {
    return look_lod(depth, sampler, uv, lod, layer, counters, comparison(depth, reference, test));
}

float sample_compare_grad(const Target& depth, const Sampler& sampler, vec2 uv, float reference, Compare test, vec2 ddx,
                          vec2 ddy, PassCounters& counters, int layer) {
    return look_grad(depth, sampler, uv, ddx, ddy, layer, counters, comparison(depth, reference, test));
}

vec4 sample_cube(const Target& texture, const Sampler& sampler, vec3 direction, PassCounters& counters, int cube) {
    assert(texture.width() == texture.height() && 6 * cube + 6 <= texture.layers());
    return CubeLevel{texture, sampler, 6 * cube, 0, counters}.filtered(sampler.filter, cube_point(direction), Color{});
}

vec4 sample_cube_lod(const Target& texture, const Sampler& sampler, vec3 direction, float lod, PassCounters& counters,
                     int cube) {
    return look_cube(texture, sampler, direction, lod, cube, counters, Color{});
}

vec4 sample_cube_grad(const Target& texture, const Sampler& sampler, vec3 direction, vec3 ddx, vec3 ddy,
                      PassCounters& counters, int cube) {
    const CubePoint point = cube_point(direction);
    const float n = static_cast<float>(texture.width());
    const Probes p = probes(face_gradient(point, ddx) * n, face_gradient(point, ddy) * n, sampler.max_anisotropy);
    const vec3 axis = p.along_y ? ddy : ddx;
    return average(p, [&](float lod, float offset) {
        return look_cube(texture, sampler, direction + axis * offset, lod, cube, counters, Color{});
    });
}

float sample_cube_compare(const Target& depth, const Sampler& sampler, vec3 direction, float reference, Compare test,
                          PassCounters& counters, int cube) {
    assert(depth.width() == depth.height() && 6 * cube + 6 <= depth.layers());
    return CubeLevel{depth, sampler, 6 * cube, 0, counters}.filtered(sampler.filter, cube_point(direction),
                                                                     comparison(depth, reference, test));
}

namespace {
template <class Map>
vec4 gathered(const Target& texture, const Sampler& sampler, vec2 uv, int layer, PassCounters& counters,
              const Map& map) {
    const Plane2d plane = {texture, sampler, layer, 0, counters};
    const Footprint f = footprint(uv, texture.width(), texture.height(), false);
    const auto at = [&](int i, int j) { return map(plane.texel(f.x + i, f.y + j)); };
    return {at(0, 1), at(1, 1), at(1, 0), at(0, 0)};
}
} // namespace

vec4 gather(const Target& texture, const Sampler& sampler, vec2 uv, int component, PassCounters& counters, int layer) {
    return gathered(texture, sampler, uv, layer, counters, [=](const vec4& texel) { return texel[component]; });
}

vec4 gather_compare(const Target& depth, const Sampler& sampler, vec2 uv, float reference, Compare test,
                    PassCounters& counters, int layer) {
    return gathered(depth, sampler, uv, layer, counters, comparison(depth, reference, test));
}

int array_layer(float coordinate, int layers) {
    if (!(coordinate > 0.0f)) return 0;
    return static_cast<int>(std::nearbyint(std::min(coordinate, static_cast<float>(layers - 1))));
}

namespace {
bool exists(const Target& texture, int x, int y, int layer, int level) {
    return level >= 0 && level < texture.levels() && layer >= 0 && layer < texture.layers() && x >= 0 && y >= 0 &&
           x < texture.width(level) && y < texture.height(level);
}
} // namespace

vec4 fetch(const Target& texture, int x, int y, int layer, int level, PassCounters& counters) {
    if (!exists(texture, x, y, layer, level)) return vec4(0.0f);
    count_texels(texture, 1, counters);
    return texture.load(x, y, layer, level);
}

glm::uvec4 fetch_uint(const Target& texture, int x, int y, int layer, int level, PassCounters& counters) {
    if (!exists(texture, x, y, layer, level)) return glm::uvec4(0u);
    count_texels(texture, 1, counters);
    return texture.load_uint(x, y, layer, level);
}

} // namespace gnomon
