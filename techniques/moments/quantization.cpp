#include "techniques/moments/quantization.h"

namespace gnomon {
namespace {

// GLM's constructor takes columns: these are the rows of Θ, so it is the transpose.
const dmat4 theta_rows(-2.07224649, 32.23703778, -68.571074599, 39.3703274134,      //
                       13.7948857237, -59.4683975703, 82.0359750338, -35.364903257, //
                       0.105877704, -1.9077466311, 9.3496555107, -6.6543490743,     //
                       9.7924062118, -33.7652110555, 47.9456096605, -23.9728048165);
const mat4 theta(glm::transpose(theta_rows));
const mat4 inverse_theta(glm::transpose(glm::inverse(theta_rows)));
constexpr float first_offset = 0.0359558848f;

} // namespace

vec4 quantize_moments(vec4 b) { return transform(theta, vec3(b), b.w) + vec4(first_offset, 0.0f, 0.0f, 0.0f); }

vec4 dequantize_moments(vec4 quantized) {
    const vec4 linear = quantized - vec4(first_offset, 0.0f, 0.0f, 0.0f);
    return transform(inverse_theta, vec3(linear), linear.w);
}

} // namespace gnomon
