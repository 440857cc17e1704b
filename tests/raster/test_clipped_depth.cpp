#include <catch2/catch.hpp>

#include <cmath>

#include "raster/draw.h"

using namespace gnomon;

namespace {

constexpr int side = 64;

// Homogeneous window coordinates of the corners: (x·w, y·w, depth·w, w) in pixels.
vec4 from_window(dvec4 p) {
    const double half = 0.5 * side;
    return vec4(dvec4(p.x / half - p.w, p.y / half - p.w, 2 * p.z - p.w, p.w));
}

} // namespace

// A side of a shadow volume: two corners on the grid of snapped positions, the third at infinity. A pixel centre is
// a + t·(b − a) + u·c, which gives its depth.
TEST_CASE("the depth of a clipped triangle is the plane through its corners, those at infinity too", "[bits]") {
    const dvec4 a(8, 8, 0.25, 1), b(8, 56, 0.375, 1);
    const dvec4 c(GENERATE(vec4(15.7f, 0.3f, 0.23f, 0), vec4(15.7f, 1.3f, -0.031f, 0), vec4(1.1f, 0.03f, 0.017f, 0)));
    std::vector<vec4> positions = {from_window(a), from_window(b), from_window(c)};
    if (GENERATE(false, true)) std::swap(positions[0], positions[2]); // neither winding nor first corner matters
    const std::vector<uvec3> triangle = {{0, 1, 2}};
    PassLog log;
    Pass pass(log, "clipped");
    Target depth(Format::D32F, side, side);
    depth.clear_depth(pass, 1.0f);
    PipelineState state;
    state.depth = {.test = Compare::Always, .write = true, .clamp = true};
    draw(
        pass, {3, triangle}, state, [&](std::uint32_t i) { return positions[i]; }, depth_only,
        Targets{.depth = &depth});
    CHECK(pass.counters().clipped == 1);
    int covered = 0;
    double largest = 0;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const double u = (x + 0.5 - a.x) / c.x, t = (y + 0.5 - u * c.y - a.y) / (b.y - a.y);
            if (u <= 0 || t <= 0.01 || t >= 0.99) continue; // the edges are as exact as the cuts
            const double exact = std::clamp(a.z + t * (b.z - a.z) + u * c.z, 0.0, 1.0);
            largest = std::max(largest, std::abs(static_cast<double>(depth.depth(x, y, 0)) - exact));
            ++covered;
        }
    INFO("corner at infinity " << c.x << ", " << c.y << ", " << c.z);
    CHECK(covered > 2000);
    CHECK(largest <= 0x1p-25); // half a step of a float below 1
}
