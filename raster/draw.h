#pragma once
// A pass is geometry × pipeline state × programs × targets. Programs are callables:
//
//   vertex program     (std::uint32_t vertex) -> Vertex<Varyings>       or -> vec4, where there are no varyings
//   fragment program   (const Fragment<Varyings>&, FragmentOutput&)     or depth_only
//
// Varyings is a struct of floats, perspective-correct unless it says otherwise, float by float:
//   struct V {
//       float u, id;
//       static constexpr std::array interpolation = {Interpolation::Linear, Interpolation::Flat};
//   };
// The machinery (set-up, bins, tiles, tests, blending) is compiled once in draw.cpp;
// programs meet it one 8×8 block at a time. Per pixel, primitives take effect in the order they are submitted.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/math.h"
#include "core/parallel.h"
#include "raster/counters.h"
#include "raster/setup.h"
#include "raster/state.h"
#include "raster/target.h"

namespace gnomon {

struct NoVaryings {};

enum class Interpolation : std::uint8_t { Perspective, Linear, Flat }; // GLSL's smooth, noperspective and flat

template <class V = NoVaryings> struct Vertex {
    vec4 position; // clip space
    V varyings;
};

// Indexed triangles over vertices [0, vertex_count); each vertex runs through the program once.
struct Geometry {
    std::uint32_t vertex_count = 0;
    std::span<const uvec3> triangles;
};

template <class V> struct Fragment {
    ivec2 pixel;
    float depth;     // window depth, polygon offset included
    float inverse_w; // 1/w of clip space
    bool front;
    std::uint32_t primitive;
    V varyings;
    V ddx, ddy; // 2×2-quad differences: along the fragment's row and column; only with FragmentFlags::derivatives
    PassCounters* counters; // samplers count their texels here
};

struct FragmentOutput {
    // [c] is that of target c; what a program leaves alone is zero. Integer targets take the bits
    // (glm::uintBitsToFloat).
    std::array<vec4, max_color_targets> color{};
    float depth = 0; // read only with FragmentFlags::writes_depth
    bool discarded = false;
};

// What a fragment program does besides writing colours; each costs something, so each is asked for.
struct FragmentFlags {
    bool discards = false;     // tests wait until it has run
    bool writes_depth = false; // likewise
    bool derivatives = false;  // varyings are evaluated for whole 2×2 quads
    bool per_sample = false;   // with several samples: runs for each of them, at its position
    // Needs to run for visible fragments only: its one effect is the colours that it gives, so that fragments which
    // others hide later may be left out, as a tile-based GPU does. It is counted as if it ran for all that pass.
    bool visible_only = false;
};

template <class Program> struct FragmentProgram {
    Program program;
    FragmentFlags flags;
};
template <class Program> FragmentProgram(Program, FragmentFlags) -> FragmentProgram<Program>;

struct DepthOnly {};
inline constexpr DepthOnly depth_only{};

namespace detail {

inline constexpr size_t max_varyings = 32; // floats per vertex

// The colours of a block, target by target and channel by channel.
using BlockColors = std::array<std::array<std::array<float, 64>, 4>, max_color_targets>;

// Where the values of a triangle's corners lie, in the order of submission.
using CornerVaryings = std::array<const float*, 3>;

// The fragments of one triangle in a block. Bit 8·j + i is pixel (x + i, y + j).
struct FragmentRun {
    const SetupTriangle* triangle;
    const AttributePlanes* planes; // null without varyings
    CornerVaryings corners;        // likewise
    std::uint64_t mask;
};

// An 8×8 block of fragments on its way through the fragment program.
struct FragmentBlock {
    const FragmentRun* runs;          // of disjoint masks
    std::array<std::uint8_t, 64> run; // which of them a pixel belongs to
    std::uint64_t mask;               // all of them together
    int x, y;
    std::uint64_t kept; // out: fragments not discarded
    std::array<float, 64> depth;
    std::array<float, 64> inverse_w, second, third; // with varyings: 1/w, and the perspective barycentric coordinates
    std::array<std::array<float, 64>, max_varyings> varyings; // perspective-correct, float by float
    BlockColors color;                                        // out
    PassCounters* counters;

    const FragmentRun& run_of(size_t at) const { return runs[run[at]]; }
    ivec2 pixel(size_t at) const { return {x + static_cast<int>(at & 7), y + static_cast<int>(at >> 3)}; }
};

struct Draw {
    Geometry geometry;
    int varying_count = 0;        // floats per vertex
    bool linear_varyings = false; // some of them are interpolated linearly
    FragmentFlags flags;
    // Runs the vertex program for [begin, end).
    std::function<void(std::uint32_t begin, std::uint32_t end, vec4* positions, float* varyings)> vertices;
    std::function<void(FragmentBlock& block)> fragments; // runs the fragment program; empty: depth only
};

// The i-th float of a struct of floats. One by one they stay in registers: a copy of the whole would wait for its parts
// to be stored.
inline float get_float(const void* floats, size_t i) {
    float value;
    std::memcpy(&value, static_cast<const std::byte*>(floats) + i * sizeof(float), sizeof(float));
    return value;
}
inline void set_float(void* floats, size_t i, float value) {
    std::memcpy(static_cast<std::byte*>(floats) + i * sizeof(float), &value, sizeof(float));
}
template <class V> [[gnu::always_inline]] inline void copy_floats(void* to, const V& from) {
    [&]<size_t... i>(std::index_sequence<i...>) { (set_float(to, i, get_float(&from, i)), ...); }
    (std::make_index_sequence<sizeof(V) / sizeof(float)>{});
}

void execute(Pass& pass, const Draw& draw, const PipelineState& state, const Targets& targets);

template <class V, size_t i> constexpr Interpolation interpolation_of() {
    if constexpr (requires { V::interpolation; })
        return V::interpolation[i];
    else
        return Interpolation::Perspective;
}

template <class V> constexpr bool has_linear_varyings() {
    if constexpr (requires { V::interpolation; })
        for (const Interpolation how : V::interpolation)
            if (how == Interpolation::Linear) return true;
    return false;
}

// Perspective barycentric coordinates of the second and third corner, from planes in double.
struct Barycentric {
    float second, third;
};
inline float between(const CornerVaryings& corners, size_t i, const Barycentric& b) {
    const float v0 = corners[0][i];
    return (v0 + b.second * (corners[1][i] - v0)) + b.third * (corners[2][i] - v0);
}
inline Barycentric perspective_at(const FragmentRun& run, int x, int y) {
    const SetupTriangle& t = *run.triangle;
    const double w = 1.0 / t.evaluate(run.planes->inverse_w(), x, y);
    return {static_cast<float>(t.evaluate(run.planes->second(), x, y) * w),
            static_cast<float>(t.evaluate(run.planes->third(), x, y) * w)};
}

// A whole struct of varyings at a pixel: v0 + β1·(v1 − v0) + β2·(v2 − v0) in float; `perspective(i)` gives those that
// are perspective-correct. `run()` is the pixel's, asked for only where it is needed.
template <class V, class Run, class Perspective>
[[gnu::always_inline]] inline V interpolate(const Run& run, ProvokingVertex provoking, const Perspective& perspective,
                                            int x, int y) {
    V varyings;
    const auto value = [&]<size_t i>(std::integral_constant<size_t, i>) {
        constexpr Interpolation how = interpolation_of<V, i>();
        if constexpr (how == Interpolation::Flat) {
            return run().corners[provoking == ProvokingVertex::First ? 0 : 2][i];
        } else if constexpr (how == Interpolation::Linear) {
            const FragmentRun& r = run();
            const SetupTriangle& t = *r.triangle;
            return between(r.corners, i,
                           {static_cast<float>(t.evaluate(r.planes->second_linear, x, y)),
                            static_cast<float>(t.evaluate(r.planes->third_linear, x, y))});
        } else {
            return perspective(i);
        }
    };
    [&]<size_t... i>(std::index_sequence<i...>) {
        (set_float(&varyings, i, value(std::integral_constant<size_t, i>{})), ...);
    }
    (std::make_index_sequence<sizeof(V) / sizeof(float)>{});
    return varyings;
}

template <class V> V difference(const V& a, const V& b) {
    constexpr size_t count = sizeof(V) / sizeof(float);
    auto x = std::bit_cast<std::array<float, count>>(a), y = std::bit_cast<std::array<float, count>>(b);
    for (size_t i = 0; i < count; ++i) x[i] -= y[i];
    return std::bit_cast<V>(x);
}

template <class V>
[[gnu::always_inline]] inline Fragment<V> fragment_at(const FragmentBlock& block, size_t at,
                                                      ProvokingVertex provoking) {
    const auto run = [&]() -> const FragmentRun& { return block.run_of(at); };
    Fragment<V> fragment{};
    fragment.pixel = block.pixel(at);
    fragment.depth = block.depth[at];
    fragment.front = run().triangle->front;
    fragment.primitive = run().triangle->primitive;
    fragment.counters = block.counters;
    if constexpr (!std::is_empty_v<V>) {
        fragment.inverse_w = block.inverse_w[at];
        fragment.varyings = interpolate<V>(
            run, provoking, [&](size_t i) { return block.varyings[i][at]; }, fragment.pixel.x, fragment.pixel.y);
    }
    return fragment;
}

// Differences within the 2×2 quad: quads sit on even coordinates; helpers beyond the triangle extrapolate its planes.
template <class V> void differentiate(const FragmentRun& run, ProvokingVertex provoking, Fragment<V>& fragment) {
    const auto helper = [&](int x, int y) {
        const Barycentric b = perspective_at(run, x, y);
        return interpolate<V>([&]() -> const FragmentRun& { return run; }, provoking,
                              [&](size_t i) { return between(run.corners, i, b); }, x, y);
    };
    const ivec2 at = fragment.pixel, quad = {at.x & ~1, at.y & ~1};
    fragment.ddx = difference(helper(quad.x + 1, at.y), helper(quad.x, at.y));
    fragment.ddy = difference(helper(at.x, quad.y + 1), helper(at.x, quad.y));
}

template <size_t count>
[[gnu::always_inline]] inline void set_colors(FragmentBlock& block, size_t at, const FragmentOutput& output) {
    const auto set = [&](auto& channels, const vec4& color) {
        channels[0][at] = color.x, channels[1][at] = color.y, channels[2][at] = color.z, channels[3][at] = color.w;
    };
    [&]<size_t... c>(std::index_sequence<c...>) { (set(block.color[c], output.color[c]), ...); }
    (std::make_index_sequence<count>{});
}

// Runs the program for the fragments of a block; gives it `count` colour targets.
template <class V, size_t count, class Program>
void shade(FragmentBlock& block, FragmentFlags flags, ProvokingVertex provoking, const Program& program) {
    const bool simple = !flags.derivatives && !flags.discards && !flags.writes_depth;
    if (simple && block.mask == ~std::uint64_t{0}) { // a loop over arrays, for compilers to make vectors of
        for (size_t at = 0; at < 64; ++at) {
            const Fragment<V> fragment = fragment_at<V>(block, at, provoking);
            FragmentOutput output;
            output.depth = fragment.depth;
            program(fragment, output);
            set_colors<count>(block, at, output);
        }
        return;
    }
    for (std::uint64_t rest = block.mask; rest; rest &= rest - 1) {
        const auto at = static_cast<size_t>(std::countr_zero(rest));
        Fragment<V> fragment = fragment_at<V>(block, at, provoking);
        if constexpr (!std::is_empty_v<V>)
            if (flags.derivatives) differentiate(block.run_of(at), provoking, fragment);
        FragmentOutput output;
        output.depth = fragment.depth;
        program(std::as_const(fragment), output);
        set_colors<count>(block, at, output);
        if (output.discarded) block.kept &= ~(std::uint64_t{1} << at);
        block.depth[at] = output.depth;
    }
}

// Runs a program that gives positions alone. They go into arrays of this function's own first, which nothing that the
// program reads can overlap, so that compilers make vectors of several vertices.
template <class VertexProgram>
void run_in_blocks(const VertexProgram& program, std::uint32_t begin, std::uint32_t end, vec4* positions) {
    constexpr std::uint32_t block = 64;
    float x[block], y[block], z[block], w[block];
    for (std::uint32_t first = begin; first < end; first += block) {
        const std::uint32_t last = std::min(end, first + block); // at most 2²⁹
        for (std::uint32_t i = first; i < last; ++i) {
            const vec4 position = program(i);
            x[i - first] = position.x, y[i - first] = position.y, z[i - first] = position.z, w[i - first] = position.w;
        }
        for (std::uint32_t i = first; i < last; ++i) {
            const std::uint32_t k = i - first;
            copy_floats(positions + i, vec4(x[k], y[k], z[k], w[k]));
        }
    }
}

template <class Output> struct VaryingsOf { using type = NoVaryings; };
template <class V> struct VaryingsOf<Vertex<V>> { using type = V; };

} // namespace detail

// Draws into the layer of `targets` that they name. Throws UsageError where targets differ in size.
template <class VertexProgram, class Program>
void draw(Pass& pass, const Geometry& geometry, const PipelineState& state, const VertexProgram& vertex_program,
          const FragmentProgram<Program>& fragment_program, const Targets& targets) {
    using Output = std::invoke_result_t<VertexProgram, std::uint32_t>;
    using V = typename detail::VaryingsOf<Output>::type;
    static_assert(std::is_empty_v<V> || (sizeof(V) % sizeof(float) == 0 && sizeof(V) <= 4 * detail::max_varyings),
                  "varyings are floats, and not too many");
    constexpr bool has_varyings = !std::is_empty_v<V>;
    constexpr bool depth_only_program = std::is_same_v<Program, DepthOnly>;
    detail::Draw call;
    call.geometry = geometry;
    call.varying_count = has_varyings ? static_cast<int>(sizeof(V)) / static_cast<int>(sizeof(float)) : 0;
    call.linear_varyings = detail::has_linear_varyings<V>();
    call.flags = fragment_program.flags;
    call.vertices = [&](std::uint32_t begin, std::uint32_t end, vec4* positions, [[maybe_unused]] float* varyings) {
        if constexpr (std::is_same_v<Output, vec4>) {
            detail::run_in_blocks(vertex_program, begin, end, positions);
        } else {
            for (std::uint32_t i = begin; i < end; ++i) {
                const Output vertex = vertex_program(i);
                detail::copy_floats(positions + i, vertex.position);
                if constexpr (has_varyings)
                    detail::copy_floats(varyings + i * (sizeof(V) / sizeof(float)), vertex.varyings);
            }
        }
    };
    if constexpr (!depth_only_program)
        call.fragments = [&](detail::FragmentBlock& block) {
            const auto shade = [&]<size_t count>(std::integral_constant<size_t, count>) {
                detail::shade<V, count>(block, fragment_program.flags, state.provoking_vertex,
                                        fragment_program.program);
            };
            const size_t count = targets.color.size(); // more than the targets do no harm
            if (count <= 2)
                shade(std::integral_constant<size_t, 2>{});
            else
                shade(std::integral_constant<size_t, max_color_targets>{});
        };
    detail::execute(pass, call, state, targets);
}

template <class VertexProgram, class Program>
void draw(Pass& pass, const Geometry& geometry, const PipelineState& state, const VertexProgram& vertex_program,
          const Program& fragment_program, const Targets& targets) {
    draw(pass, geometry, state, vertex_program, FragmentProgram<Program>{fragment_program, {}}, targets);
}

} // namespace gnomon
