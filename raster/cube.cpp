#include "raster/cube.h"

#include <cassert>
#include <cstdint>

namespace gnomon {
namespace {

// Which component, and with which sign, gives sc, tc and ma.
struct Axis {
    int component, sign;
};
struct Face {
    Axis sc, tc, ma;
};
constexpr std::array<Face, 6> faces = {{
    {{2, -1}, {1, -1}, {0, +1}}, // +X
    {{2, +1}, {1, -1}, {0, -1}}, // −X
    {{0, +1}, {2, +1}, {1, +1}}, // +Y
    {{0, +1}, {2, -1}, {1, -1}}, // −Y
    {{0, +1}, {1, -1}, {2, +1}}, // +Z
    {{0, -1}, {1, -1}, {2, -1}}, // −Z
}};

template <class V> int face_of(const V& v) {
    const auto x = v.x < 0 ? -v.x : v.x, y = v.y < 0 ? -v.y : v.y, z = v.z < 0 ? -v.z : v.z;
    if (x >= y && x >= z) return v.x > 0 ? 0 : 1;
    if (y >= z) return v.y > 0 ? 2 : 3;
    return v.z > 0 ? 4 : 5;
}

template <class V> auto along(const V& v, Axis axis) { return axis.sign > 0 ? v[axis.component] : -v[axis.component]; }

} // namespace

vec3 cube_face_coordinates(int face, vec3 v) {
    const Face& f = faces[static_cast<size_t>(face)];
    return {along(v, f.sc), along(v, f.tc), along(v, f.ma)};
}

CubePoint cube_point(vec3 direction) {
    const int face = face_of(direction);
    const vec3 c = cube_face_coordinates(face, direction);
    return {face, c.x, c.y, c.z};
}

vec3 cube_direction(int face, vec2 uv) {
    const Face& f = faces[static_cast<size_t>(face)];
    vec3 direction;
    direction[f.sc.component] = static_cast<float>(f.sc.sign) * (uv.x * 2.0f - 1.0f);
    direction[f.tc.component] = static_cast<float>(f.tc.sign) * (uv.y * 2.0f - 1.0f);
    direction[f.ma.component] = static_cast<float>(f.ma.sign);
    return direction;
}

CubeTexel cube_texel(int face, int x, int y, int n) {
    if (x >= 0 && x < n && y >= 0 && y < n) return {face, x, y};
    assert((x >= 0 && x < n) || (y >= 0 && y < n));
    // The centre of the texel as a direction, scaled by n: sc = 2x + 1 − n, tc = 2y + 1 − n, ma = n.
    const Face& f = faces[static_cast<size_t>(face)];
    glm::ivec3 direction;
    direction[f.sc.component] = f.sc.sign * (2 * x + 1 - n);
    direction[f.tc.component] = f.tc.sign * (2 * y + 1 - n);
    direction[f.ma.component] = f.ma.sign * n;
    const int other = face_of(direction);
    const Face& g = faces[static_cast<size_t>(other)];
    // The texel whose square its projection falls in: its ma is n + 1, and |sc|, |tc| ≤ n.
    const auto texel = [&](Axis axis) {
        const std::int64_t c = along(direction, axis), major = along(direction, g.ma);
        return static_cast<int>((c + major) * n / (2 * major));
    };
    return {other, texel(g.sc), texel(g.tc)};
}

} // namespace gnomon
