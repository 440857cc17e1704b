// Triangles that near, far and the guard band cut. Both sides cut in their own arithmetic, and the witness cuts at the
// viewport's sides too, where Gnomon does not; new vertices are then snapped, so edges move by up to a sub-pixel step.

#include <array>

#include <fmt/format.h>

#include "core/camera.h"
#include "tests/conformance/explain.h"
#include "tests/conformance/triangles.h"

namespace gnomon_conformance {
namespace {

// A triangle in eye space around and behind the eye, under a perspective with near = 0.1, far = 20.
void add_near(Batch& batch, const mat4& projection, Random& random) {
    const dvec3 at(random.real(-3, 3), random.real(-3, 3), random.real(-6, 0.5));
    const double reach = random.chance(3) ? 4.0 : 0.7;
    std::array<vec4, 3> v;
    for (vec4& p : v)
        p = transform(projection, vec3(at + dvec3(random.real(-reach, reach), random.real(-reach, reach),
                                                  random.real(-reach, reach))));
    batch.add(v[0], v[1], v[2]);
}

// Up to a hundred times the viewport away.
void add_far_off(Batch& batch, Random& random) {
    std::array<vec4, 3> v;
    for (vec4& p : v) {
        const double reach = random.chance(3) ? 100 : 2;
        p = vec4(dvec4(random.real(-reach, reach), random.real(-reach, reach), random.real(-0.9, 0.9), 1));
    }
    batch.add(v[0], v[1], v[2]);
}

struct Tally {
    std::int64_t covered = 0, differ = 0, ours = 0, theirs = 0;
};

// Who is right at a pixel where the two differ: the exact number of triangles around the pixel's centre.
void judge(const Batch& batch, const Rectangle& viewport, ivec2 pixel, std::uint32_t ours, std::uint32_t theirs,
           Tally& tally) {
    std::uint32_t exact = 0;
    for (const uvec3& t : batch.triangles) {
        const auto z = homogeneous_depth(dvec4(batch.positions[t.x]), dvec4(batch.positions[t.y]),
                                         dvec4(batch.positions[t.z]), viewport, dvec2(pixel) + 0.5);
        exact += z && *z >= -1 && *z <= 1;
    }
    tally.ours += (exact & 0xff) == ours;
    tally.theirs += (exact & 0xff) == theirs;
}

} // namespace

bool check_clipping(const Options& options) {
    Verdict verdict("clipping");
    Random random(options.seed + 3);
    constexpr int side = 512;
    const Rectangle viewport = {0, 0, side, side};
    const mat4 projection(perspective_matrix(1.2, 1.0, 0.1, 20.0));
    for (const bool near : {true, false}) {
        Duel duel({.width = side, .height = side});
        Tally tally;
        for (int i = 0; i < options.repeat(20); ++i) {
            Batch batch;
            for (int t = 0; t < (near ? 400 : 60); ++t)
                near ? add_near(batch, projection, random) : add_far_off(batch, random);
            duel.clear();
            duel.draw(batch, counting_state());
            tally.covered += duel.counters().fragments_covered;
            const Picture a = duel.ours(), b = duel.witness();
            for (size_t k = 0; k < duel.pixels(); ++k) {
                if (a.stencil[k] == b.stencil[k] && a.ids[k] == b.ids[k]) continue;
                ++tally.differ;
                judge(batch, viewport, ivec2(static_cast<int>(k % side), static_cast<int>(k / side)), a.stencil[k],
                      b.stencil[k], tally);
            }
        }
        verdict.require(
            fraction(tally.differ, tally.covered) <= 1e-5,
            fmt::format("{}: {} of {} covered fragments differ ({:.1e}); exact count there equals ours at {}, "
                        "theirs at {}",
                        near ? "across the near plane" : "far off screen", tally.differ, tally.covered,
                        fraction(tally.differ, tally.covered), tally.ours, tally.theirs));
    }
    return verdict.held();
}

} // namespace gnomon_conformance
