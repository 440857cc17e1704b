#pragma once
// The vector vocabulary of the house: GLM's types under short names, and the few helpers GLM lacks.
// Right-handed world, y up, metres. Host matrices are multiplied in double and rounded once to float.

#include <glm/glm.hpp>
#include <limits>

namespace gnomon {

using glm::dmat4;
using glm::dvec2;
using glm::dvec3;
using glm::dvec4;
using glm::ivec2;
using glm::mat3;
using glm::mat4;
using glm::uvec3;
using glm::vec2;
using glm::vec3;
using glm::vec4;

inline constexpr float infinity = std::numeric_limits<float>::infinity();
inline constexpr double pi = 3.14159265358979323846;

// Axis-aligned box; empty while minimum > maximum.
struct Bounds {
    vec3 minimum{infinity};
    vec3 maximum{-infinity};

    void extend(vec3 p) {
        minimum = glm::min(minimum, p);
        maximum = glm::max(maximum, p);
    }
    bool empty() const { return minimum.x > maximum.x; }
    vec3 center() const { return minimum + (maximum - minimum) * 0.5f; }
    vec3 extent() const { return maximum - minimum; }
    float diagonal() const { return empty() ? 0.0f : glm::length(extent()); }
    vec3 corner(int i) const {
        return {i & 1 ? maximum.x : minimum.x, i & 2 ? maximum.y : minimum.y, i & 4 ? maximum.z : minimum.z};
    }
};

// matrix · (p, w) in the one documented order of float operations: ((m0·x + m1·y) + (m2·z + m3·w)) per row. Every
// program that must meet another program's vertices bit for bit goes through this.
inline vec4 transform(const mat4& m, vec3 p, float w = 1.0f) {
    const auto row = [&](int i) { return (m[0][i] * p.x + m[1][i] * p.y) + (m[2][i] * p.z + m[3][i] * w); };
    return {row(0), row(1), row(2), row(3)};
}

} // namespace gnomon
