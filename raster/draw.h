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

// One fragment's colours: [c] is that of target c.
class FragmentColors {
public:
    static constexpr size_t stride = 64; // vec4s from a target's to the next's, as they lie in a block
    explicit FragmentColors(vec4* first) : first_(first) {}
    vec4& operator[](size_t target) { return first_[stride * target]; }

private:
    vec4* first_;
};

struct FragmentOutput {
    FragmentColors color; // integer targets take the bits (glm::uintBitsToFloat)
    float depth = 0;      // read only with FragmentFlags::writes_depth
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

using BlockColors = std::array<std::array<vec4, FragmentColors::stride>, max_color_targets>;

// The fragments of one triangle in a block. Bit 8·j + i is pixel (x + i, y + j).
struct FragmentRun {
    const SetupTriangle* triangle;
    const AttributePlanes* planes; // null without varyings
    std::uint64_t mask;
};

// An 8×8 block of fragments on its way through the fragment program.
struct FragmentBlock {
    std::span<const FragmentRun> runs; // of disjoint masks
    int x, y;
    std::uint64_t kept; // out: fragments not discarded
    std::array<float, 64> depth;
    std::array<float, 64> inverse_w, second, third; // with varyings: 1/w, and the perspective barycentric coordinates
    std::array<std::array<float, 64>, max_varyings> varyings; // perspective-correct, float by float
    BlockColors* color;
    PassCounters* counters;
};

struct Draw {
    Geometry geometry;
    int varying_count = 0;        // floats per vertex
    bool linear_varyings = false; // some of them are interpolated linearly
    FragmentFlags flags;
    // Runs the vertex program for [begin, end).
    std::function<void(std::uint32_t begin, std::uint32_t end, vec4* positions, float* varyings)> vertices;
    // Runs the fragment program; empty: depth only. `varyings` are those of the draw, `triangles` its indices.
    std::function<void(FragmentBlock& block, const float* varyings)> fragments;
};

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

// The varyings of a triangle's corners in the order of submission, and of its provoking vertex.
struct CornerVaryings {
    const float *v0, *v1, *v2, *provoking;
};

// Perspective barycentric coordinates of the second and third corner, from planes in double.
struct Barycentric {
    float second, third;
};
inline float between(const CornerVaryings& corner, size_t i, const Barycentric& b) {
    const float v0 = corner.v0[i];
    return (v0 + b.second * (corner.v1[i] - v0)) + b.third * (corner.v2[i] - v0);
}
inline Barycentric perspective_at(const FragmentRun& run, int x, int y) {
    const SetupTriangle& t = *run.triangle;
    const double w = 1.0 / t.evaluate(run.planes->inverse_w, x, y);
    return {static_cast<float>(t.evaluate(run.planes->second, x, y) * w),
            static_cast<float>(t.evaluate(run.planes->third, x, y) * w)};
}

// A whole struct of varyings at a pixel: v0 + β1·(v1 − v0) + β2·(v2 − v0) in float; `perspective(i)` gives those that
// are perspective-correct.
template <class V, class Perspective>
V interpolate(const FragmentRun& run, const CornerVaryings& corner, const Perspective& perspective, int x, int y) {
    constexpr size_t count = sizeof(V) / sizeof(float);
    std::array<float, count> values;
    const auto linear = [&] {
        const SetupTriangle& t = *run.triangle;
        return Barycentric{static_cast<float>(t.evaluate(run.planes->second_linear, x, y)),
                           static_cast<float>(t.evaluate(run.planes->third_linear, x, y))};
    };
    const auto set = [&]<size_t i>(std::integral_constant<size_t, i>) {
        constexpr Interpolation how = interpolation_of<V, i>();
        if constexpr (how == Interpolation::Flat)
            values[i] = corner.provoking[i];
        else if constexpr (how == Interpolation::Linear)
            values[i] = between(corner, i, linear());
        else
            values[i] = perspective(i);
    };
    [&]<size_t... i>(std::index_sequence<i...>) { (set(std::integral_constant<size_t, i>{}), ...); }
    (std::make_index_sequence<count>{});
    return std::bit_cast<V>(values);
}

template <class V> V difference(const V& a, const V& b) {
    constexpr size_t count = sizeof(V) / sizeof(float);
    auto x = std::bit_cast<std::array<float, count>>(a), y = std::bit_cast<std::array<float, count>>(b);
    for (size_t i = 0; i < count; ++i) x[i] -= y[i];
    return std::bit_cast<V>(x);
}

template <class V, class Program>
void shade_run(FragmentBlock& block, const FragmentRun& run, const float* varyings, std::span<const uvec3> triangles,
               FragmentFlags flags, ProvokingVertex provoking, size_t color_count, const Program& program) {
    constexpr bool has_varyings = !std::is_empty_v<V>;
    constexpr size_t stride = has_varyings ? sizeof(V) / sizeof(float) : 0;
    const uvec3 index = triangles[run.triangle->primitive];
    const std::uint32_t first_or_last = provoking == ProvokingVertex::First ? index.x : index.z;
    [[maybe_unused]] const CornerVaryings corner = {varyings + index.x * stride, varyings + index.y * stride,
                                                    varyings + index.z * stride, varyings + first_or_last * stride};
    [[maybe_unused]] const auto helper = [&](int x, int y) {
        const Barycentric b = perspective_at(run, x, y);
        return interpolate<V>(
            run, corner, [&](size_t i) { return between(corner, i, b); }, x, y);
    };
    Fragment<V> fragment{};
    fragment.front = run.triangle->front;
    fragment.primitive = run.triangle->primitive;
    fragment.counters = block.counters;
    for (std::uint64_t rest = run.mask; rest; rest &= rest - 1) {
        const int bit = std::countr_zero(rest);
        const auto at = static_cast<size_t>(bit);
        const int x = block.x + (bit & 7), y = block.y + (bit >> 3);
        fragment.pixel = {x, y};
        fragment.depth = block.depth[at];
        if constexpr (has_varyings) {
            fragment.inverse_w = block.inverse_w[at];
            fragment.varyings = interpolate<V>(
                run, corner, [&](size_t i) { return block.varyings[i][at]; }, x, y);
            if (flags
                    .derivatives) { // quads sit on even coordinates; helpers beyond the triangle extrapolate its planes
                const int left = x & ~1, bottom = y & ~1;
                fragment.ddx = difference(helper(left + 1, y), helper(left, y));
                fragment.ddy = difference(helper(x, bottom + 1), helper(x, bottom));
            }
        }
        FragmentOutput output{FragmentColors(&block.color->front()[at]), fragment.depth};
        for (size_t c = 0; c < color_count; ++c) output.color[c] = vec4(0.0f); // what a program leaves alone is zero
        program(std::as_const(fragment), output);
        if (output.discarded) block.kept &= ~(std::uint64_t{1} << bit);
        block.depth[at] = output.depth;
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
    call.varying_count = has_varyings ? static_cast<int>(sizeof(V) / sizeof(float)) : 0;
    call.linear_varyings = detail::has_linear_varyings<V>();
    call.flags = fragment_program.flags;
    call.vertices = [&](std::uint32_t begin, std::uint32_t end, vec4* positions, [[maybe_unused]] float* varyings) {
        for (std::uint32_t i = begin; i < end; ++i) {
            if constexpr (std::is_same_v<Output, vec4>) {
                positions[i] = vertex_program(i);
            } else {
                const Output vertex = vertex_program(i);
                positions[i] = vertex.position;
                if constexpr (has_varyings)
                    std::memcpy(varyings + i * (sizeof(V) / sizeof(float)), &vertex.varyings, sizeof(V));
            }
        }
    };
    if constexpr (!depth_only_program)
        call.fragments = [&](detail::FragmentBlock& block, const float* varyings) {
            for (const detail::FragmentRun& run : block.runs)
                detail::shade_run<V>(block, run, varyings, geometry.triangles, fragment_program.flags,
                                     state.provoking_vertex, targets.color.size(), fragment_program.program);
        };
    detail::execute(pass, call, state, targets);
}

template <class VertexProgram, class Program>
void draw(Pass& pass, const Geometry& geometry, const PipelineState& state, const VertexProgram& vertex_program,
          const Program& fragment_program, const Targets& targets) {
    draw(pass, geometry, state, vertex_program, FragmentProgram<Program>{fragment_program, {}}, targets);
}

} // namespace gnomon
