#include "raster/blend.h"

namespace gnomon {
namespace {

vec4 factor(BlendFactor f, vec4 s, vec4 d, vec4 constant) {
    switch (f) {
    case BlendFactor::Zero:
        return vec4(0.0f);
    case BlendFactor::One:
        return vec4(1.0f);
    case BlendFactor::SourceColor:
        return s;
    case BlendFactor::OneMinusSourceColor:
        return 1.0f - s;
    case BlendFactor::DestinationColor:
        return d;
    case BlendFactor::OneMinusDestinationColor:
        return 1.0f - d;
    case BlendFactor::SourceAlpha:
        return vec4(s.a);
    case BlendFactor::OneMinusSourceAlpha:
        return vec4(1.0f - s.a);
    case BlendFactor::DestinationAlpha:
        return vec4(d.a);
    case BlendFactor::OneMinusDestinationAlpha:
        return vec4(1.0f - d.a);
    case BlendFactor::ConstantColor:
        return constant;
    case BlendFactor::ConstantAlpha:
        return vec4(constant.a);
    }
    return vec4(1.0f);
}

// Min and Max ignore the factors, as the API does.
vec4 combine(BlendOp op, vec4 s, vec4 weighted_s, vec4 d, vec4 weighted_d) {
    switch (op) {
    case BlendOp::Add:
        return weighted_s + weighted_d;
    case BlendOp::Subtract:
        return weighted_s - weighted_d;
    case BlendOp::ReverseSubtract:
        return weighted_d - weighted_s;
    case BlendOp::Min:
        return glm::min(s, d);
    case BlendOp::Max:
        return glm::max(s, d);
    }
    return s;
}

} // namespace

vec4 blend(const BlendState& state, vec4 s, vec4 d) {
    const vec4 color = combine(state.color, s, s * factor(state.source_color, s, d, state.constant), d,
                               d * factor(state.destination_color, s, d, state.constant));
    const vec4 alpha = combine(state.alpha, s, s * factor(state.source_alpha, s, d, state.constant), d,
                               d * factor(state.destination_alpha, s, d, state.constant));
    return {color.r, color.g, color.b, alpha.a};
}

} // namespace gnomon
