#pragma once
// The fixed-function state of a draw, in the vocabulary of OpenGL and Vulkan. A default-constructed state is the API's
// default.

#include <array>
#include <cstdint>
#include <optional>

#include "core/math.h"

namespace gnomon {

enum class Compare : std::uint8_t { Never, Less, Equal, LessEqual, Greater, NotEqual, GreaterEqual, Always };
enum class StencilOp : std::uint8_t { Keep, Zero, Replace, Increment, Decrement, Invert, IncrementWrap, DecrementWrap };
enum class Cull : std::uint8_t { None, Front, Back };
enum class FrontFace : std::uint8_t { CounterClockwise, Clockwise };
enum class ClipDepth : std::uint8_t { NegativeOneToOne, ZeroToOne }; // range of z/w: OpenGL's; Direct3D's and Vulkan's

struct DepthState {
    Compare test = Compare::Always;
    bool write = false;
    bool clamp = false; // no clipping by near and far; depth is clamped to [0, 1] instead
    struct Bounds {
        float minimum, maximum;
    };
    std::optional<Bounds> bounds = {}; // the depth bounds test: on the stored value
};

struct StencilFace {
    Compare test = Compare::Always;
    std::uint32_t reference = 0;
    std::uint32_t read_mask = 0xffffffffu;
    std::uint32_t write_mask = 0xffffffffu;
    StencilOp fail = StencilOp::Keep;       // stencil test fails
    StencilOp depth_fail = StencilOp::Keep; // stencil passes, depth fails
    StencilOp pass = StencilOp::Keep;       // both pass
};

struct StencilState {
    bool enabled = false;
    StencilFace front, back;
};

// o = factor·m + units·r, m = max(|∂z/∂x|, |∂z/∂y|) in window depth per pixel; a positive clamp bounds o from above, a
// negative one from below.
struct PolygonOffset {
    float factor = 0, units = 0, clamp = 0;
};

struct Rectangle {
    int x, y, width, height; // pixels
};

enum class BlendFactor : std::uint8_t {
    Zero,
    One,
    SourceColor,
    OneMinusSourceColor,
    DestinationColor,
    OneMinusDestinationColor,
    SourceAlpha,
    OneMinusSourceAlpha,
    DestinationAlpha,
    OneMinusDestinationAlpha,
    ConstantColor,
    ConstantAlpha,
};
enum class BlendOp : std::uint8_t { Add, Subtract, ReverseSubtract, Min, Max };

struct BlendState {
    bool enabled = false;
    BlendFactor source_color = BlendFactor::One, destination_color = BlendFactor::Zero;
    BlendFactor source_alpha = BlendFactor::One, destination_alpha = BlendFactor::Zero;
    BlendOp color = BlendOp::Add, alpha = BlendOp::Add;
    vec4 constant{0.0f};

    static BlendState add() {
        return {.enabled = true, .destination_color = BlendFactor::One, .destination_alpha = BlendFactor::One};
    }
};

// What integer targets do with a fragment's bits instead of blending.
enum class LogicOp : std::uint8_t { Copy, Clear, Set, And, Or, Xor, Invert };

// Which vertex of a triangle flat varyings come from; OpenGL's default is the last.
enum class ProvokingVertex : std::uint8_t { Last, First };

inline constexpr int max_color_targets = 8;
inline constexpr int max_samples = 8;

struct PipelineState {
    DepthState depth;
    StencilState stencil;
    Cull cull = Cull::None;
    FrontFace front_face = FrontFace::CounterClockwise;
    PolygonOffset polygon_offset;
    std::optional<Rectangle> viewport = {}; // default: the whole target
    std::optional<Rectangle> scissor = {};
    ClipDepth clip_depth = ClipDepth::NegativeOneToOne;
    BlendState blend;
    LogicOp logic_op = LogicOp::Copy;
    ProvokingVertex provoking_vertex = ProvokingVertex::Last;
    // Every pixel that the triangle's inside touches counts as covered: edges move out by half a pixel, within the box
    // of the triangle. Triangles without area stay culled. [NV_conservative_raster; D3D11.3 15.17, tier 1]
    bool conservative = false;
    std::array<std::uint8_t, max_color_targets> color_mask = {15, 15, 15, 15, 15, 15, 15, 15}; // bits R, G, B, A
};

} // namespace gnomon
