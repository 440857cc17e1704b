#pragma once
// Texture units: nearest, bilinear, trilinear, anisotropic and depth-compare look-ups with clamp, border, repeat and
// mirror, from 2-D targets, arrays and cubes. Coordinates (0, 0) to (1, 1) span the texture, (0, 0) at the lower left;
// texel (i, j) has its centre at ((i + ½)/width, (j + ½)/height). Every look-up counts the texels it reads; the border
// is no texel, and where the level of detail is whole one level is read, not two.
//
// A program computes the level of detail λ from a gradient that it hands in (the 2×2-quad differences of a fragment, or
// an analytic one), or hands in λ itself; without either, a look-up reads level 0. [OpenGL 4.6, 8.14]

#include <optional>

#include "raster/counters.h"
#include "raster/cube.h"
#include "raster/state.h"
#include "raster/target.h"

namespace gnomon {

enum class Filter : std::uint8_t { Nearest, Linear };
enum class MipFilter : std::uint8_t { None, Nearest, Linear }; // None: level 0 alone
enum class Wrap : std::uint8_t { Clamp, Border, Repeat, Mirror };

struct Sampler {
    Filter filter = Filter::Nearest;
    Wrap wrap = Wrap::Clamp;
    vec4 border{0.0f}; // what lies outside with Wrap::Border; its first channel is the border's depth
    MipFilter mip = MipFilter::None;
    std::optional<Filter> magnify = {}; // instead of `filter` where λ ≤ 0
    std::optional<Wrap> wrap_v = {};    // instead of `wrap` for the second coordinate
    float lod_bias = 0.0f;              // added to every λ, given ones too, before the clamp
    float min_lod = -1000.0f, max_lod = 1000.0f;
    int max_anisotropy = 1; // probes at most; above 1 only look-ups with gradients use it
    bool subtexel8 = false; // linear weights in steps of 1/256, as in GPUs; default: float32
};

// λ = log2 ρ, ρ = max(|∂(u,v)/∂x|, |∂(u,v)/∂y|) with u and v in texels of level 0; the same bits on every machine.
// −infinity for zero gradients. [OpenGL 4.6, eq. 8.7]
float level_of_detail(const Target& texture, vec2 ddx, vec2 ddy);

// Colour or depth at uv of level 0; depth formats give depth in the first channel.
vec4 sample(const Target& texture, const Sampler& sampler, vec2 uv, PassCounters& counters, int layer = 0);

// textureLod: the given λ, plus bias, clamped. MipFilter::Nearest takes level ⌈λ + ½⌉ − 1, Linear blends ⌊λ⌋ and ⌊λ⌋
// + 1.
vec4 sample_lod(const Target& texture, const Sampler& sampler, vec2 uv, float lod, PassCounters& counters,
                int layer = 0);

// textureGrad: λ from the gradients of uv per pixel. With max_anisotropy > 1, N = min(⌈ρmax/ρmin⌉, max_anisotropy)
// look-ups at λ = log2(ρmax/N) are averaged, at uv + d·(i/(N + 1) − ½) for i = 1 … N, d the longer gradient.
// [GL_EXT_texture_filter_anisotropic]
vec4 sample_grad(const Target& texture, const Sampler& sampler, vec2 uv, vec2 ddx, vec2 ddy, PassCounters& counters,
                 int layer = 0);

// The fraction of texels for which `reference test stored` holds: 0 or 1 for Nearest, the bilinear weights of the four
// nearest results for Linear, blended between levels with MipFilter::Linear. The comparison is on floats; for depth
// formats the reference is clamped to [0, 1].
float sample_compare(const Target& depth, const Sampler& sampler, vec2 uv, float reference, Compare test,
                     PassCounters& counters, int layer = 0);
float sample_compare_lod(const Target& depth, const Sampler& sampler, vec2 uv, float reference, Compare test, float lod,
                         PassCounters& counters, int layer = 0);
float sample_compare_grad(const Target& depth, const Sampler& sampler, vec2 uv, float reference, Compare test, vec2 ddx,
                          vec2 ddy, PassCounters& counters, int layer = 0);

// Cubes: the six layers from 6·cube. Filtering is seamless: a bilinear footprint that crosses an edge reads the
// neighbouring face's texels, and the texel that is missing at a corner is the mean of the other three, added in the
// order of their faces. The wrap modes play no part. Gradients are those of the direction; anisotropic probes are
// spread along the direction's gradient and each hits its own face. [OpenGL 4.6, 8.13 and 8.13.1]
vec4 sample_cube(const Target& texture, const Sampler& sampler, vec3 direction, PassCounters& counters, int cube = 0);
vec4 sample_cube_lod(const Target& texture, const Sampler& sampler, vec3 direction, float lod, PassCounters& counters,
                     int cube = 0);
vec4 sample_cube_grad(const Target& texture, const Sampler& sampler, vec3 direction, vec3 ddx, vec3 ddy,
                      PassCounters& counters, int cube = 0);
float sample_cube_compare(const Target& depth, const Sampler& sampler, vec3 direction, float reference, Compare test,
                          PassCounters& counters, int cube = 0);

// textureGather: one component of the four texels of the bilinear footprint in level 0, counter-clockwise from the
// upper left: (i, j+1), (i+1, j+1), (i+1, j), (i, j); or the results of their comparisons.
vec4 gather(const Target& texture, const Sampler& sampler, vec2 uv, int component, PassCounters& counters,
            int layer = 0);
vec4 gather_compare(const Target& depth, const Sampler& sampler, vec2 uv, float reference, Compare test,
                    PassCounters& counters, int layer = 0);

// The layer that a program's floating-point array coordinate names: rounded to nearest, ties to even, then clamped.
int array_layer(float coordinate, int layers);

// texelFetch: one texel by its integer coordinates. Outside the level, the layers or the levels all channels are 0 and
// nothing is counted, as APIs with robust access have it.
vec4 fetch(const Target& texture, int x, int y, int layer, int level, PassCounters& counters);
glm::uvec4 fetch_uint(const Target& texture, int x, int y, int layer, int level, PassCounters& counters);

// For kernels that read rows of a target directly: counts n texels at once.
inline void count_texels(const Target& texture, std::int64_t n, PassCounters& counters) {
    counters.texels_fetched += n;
    counters.bytes_read += n * texture.texel_bytes();
}

// Depth of texel (x, y) of level 0 as a program fetches it; the texel must exist.
inline float fetch_depth(const Target& depth, int x, int y, int layer, PassCounters& counters) {
    count_texels(depth, 1, counters);
    return depth.depth(x, y, layer);
}

} // namespace gnomon
