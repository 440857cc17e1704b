#pragma once
// Texture units: nearest, bilinear and depth-compare look-ups with clamp, border, repeat and mirror. Coordinates (0, 0)
// to (1, 1) span the texture, (0, 0) at the lower left; texel (i, j) has its centre at ((i + ½)/width, (j + ½)/height).
// Every look-up counts the texels it reads.

#include "raster/counters.h"
#include "raster/state.h"
#include "raster/target.h"

namespace gnomon {

enum class Filter : std::uint8_t { Nearest, Linear };
enum class Wrap : std::uint8_t { Clamp, Border, Repeat, Mirror };

struct Sampler {
    Filter filter = Filter::Nearest;
    Wrap wrap = Wrap::Clamp;
    vec4 border{0.0f}; // what lies outside with Wrap::Border; its first channel is the border's depth
};

// Colour or depth at uv; depth formats give depth in the first channel.
vec4 sample(const Target& texture, const Sampler& sampler, vec2 uv, PassCounters& counters, int layer = 0);

// The fraction of texels for which `reference test stored` holds: 0 or 1 for Nearest, the bilinear weights of the four
// nearest results for Linear. The comparison is on floats, the reference clamped to [0, 1].
float sample_compare(const Target& depth, const Sampler& sampler, vec2 uv, float reference, Compare test,
                     PassCounters& counters, int layer = 0);

// Depth of texel (x, y) as a program fetches it; the texel must exist.
inline float fetch_depth(const Target& depth, int x, int y, int layer, PassCounters& counters) {
    ++counters.texels_fetched;
    counters.bytes_read += info(depth.format()).bytes;
    return depth.depth(x, y, layer);
}

} // namespace gnomon
