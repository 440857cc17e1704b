#include "raster/sampler.h"

#include <algorithm>
#include <cmath>

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

// Whole part of a coordinate in texels, kept within int whatever the input; NaN becomes 0.
int whole(float texels) {
    constexpr float limit = 1 << 24;
    return static_cast<int>(std::floor(texels > -limit ? std::min(texels, limit) : (texels <= -limit ? -limit : 0.0f)));
}

vec4 texel(const Target& texture, const Sampler& sampler, int x, int y, int layer, PassCounters& counters) {
    const int i = wrapped(sampler.wrap, x, texture.width()), j = wrapped(sampler.wrap, y, texture.height());
    if (i == outside || j == outside) return sampler.border;
    ++counters.texels_fetched;
    counters.bytes_read += info(texture.format()).bytes;
    return texture.load(i, j, layer);
}

bool holds(Compare test, float reference, float stored) {
    switch (test) {
    case Compare::Never:
        return false;
    case Compare::Less:
        return reference < stored;
    case Compare::Equal:
        return reference == stored;
    case Compare::LessEqual:
        return reference <= stored;
    case Compare::Greater:
        return reference > stored;
    case Compare::NotEqual:
        return reference != stored;
    case Compare::GreaterEqual:
        return reference >= stored;
    case Compare::Always:
        return true;
    }
    return true;
}

// The four texels around uv and where between them it lies.
struct Footprint {
    int x, y;
    float fx, fy;
};

Footprint footprint(const Target& texture, vec2 uv) {
    const float u = uv.x * static_cast<float>(texture.width()) - 0.5f;
    const float v = uv.y * static_cast<float>(texture.height()) - 0.5f;
    return {whole(u), whole(v), u - std::floor(u), v - std::floor(v)};
}

template <class T> T bilinear(T a, T b, T c, T d, float fx, float fy) {
    const T bottom = a + (b - a) * fx, top = c + (d - c) * fx;
    return bottom + (top - bottom) * fy;
}

} // namespace

vec4 sample(const Target& texture, const Sampler& sampler, vec2 uv, PassCounters& counters, int layer) {
    if (sampler.filter == Filter::Nearest)
        return texel(texture, sampler, whole(uv.x * static_cast<float>(texture.width())),
                     whole(uv.y * static_cast<float>(texture.height())), layer, counters);
    const Footprint f = footprint(texture, uv);
    return bilinear(texel(texture, sampler, f.x, f.y, layer, counters),
                    texel(texture, sampler, f.x + 1, f.y, layer, counters),
                    texel(texture, sampler, f.x, f.y + 1, layer, counters),
                    texel(texture, sampler, f.x + 1, f.y + 1, layer, counters), f.fx, f.fy);
}

float sample_compare(const Target& depth, const Sampler& sampler, vec2 uv, float reference, Compare test,
                     PassCounters& counters, int layer) {
    reference = std::clamp(reference, 0.0f, 1.0f);
    const auto result = [&](int x, int y) {
        return holds(test, reference, texel(depth, sampler, x, y, layer, counters).x) ? 1.0f : 0.0f;
    };
    if (sampler.filter == Filter::Nearest)
        return result(whole(uv.x * static_cast<float>(depth.width())),
                      whole(uv.y * static_cast<float>(depth.height())));
    const Footprint f = footprint(depth, uv);
    return bilinear(result(f.x, f.y), result(f.x + 1, f.y), result(f.x, f.y + 1), result(f.x + 1, f.y + 1), f.fx, f.fy);
}

} // namespace gnomon
