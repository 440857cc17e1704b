// Real meshes under random cameras, wholly in view, or on a target that shows the middle of the viewport. Vertices are
// multiplied with the matrix on each side (where the witness may fuse multiply and add), and once more handed over in
// clip space, where only the viewport is left to differ in.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "tests/conformance/exact_depth.h"
#include "tests/conformance/explain.h"
#include "tests/conformance/scenes.h"
#include "tests/conformance/triangles.h"

namespace gnomon_conformance {
namespace {

struct Tally {
    std::int64_t covered = 0, differ = 0, unexplained = 0;
};

// Counts pixels whose number of fragments or last primitive differs, and those of them that no rounding explains.
void compare(const Duel& duel, std::span<const ExactVertex> vertices, std::span<const uvec3> triangles,
             const Rectangle& viewport, Tally& tally) {
    const Picture a = duel.ours(), b = duel.witness();
    for (size_t k = 0; k < duel.pixels(); ++k) {
        tally.covered += a.stencil[k] > 0;
        if (a.stencil[k] == b.stencil[k] && a.ids[k] == b.ids[k]) continue;
        ++tally.differ;
        const auto width = static_cast<size_t>(duel.width());
        tally.unexplained += !hangs_on_rounding(vertices, triangles, viewport,
                                                ivec2(static_cast<int>(k % width), static_cast<int>(k / width)));
    }
}

// With the depth test on other primitives win where depths nearly tie, too: there the exact planes judge.
struct DepthTally {
    std::int64_t covered = 0, differ = 0, wrong = 0;
};

void compare_nearest(Duel& duel, const Batch& batch, const Rectangle& viewport, DepthTally& tally) {
    PipelineState state = counting_state();
    state.viewport = viewport;
    state.depth = {.test = Compare::Less, .write = true};
    duel.clear();
    duel.draw(batch, state);
    const Picture a = duel.ours(), b = duel.witness();
    for (size_t k = 0; k < duel.pixels(); ++k) {
        tally.covered += a.ids[k] != no_id;
        if (a.ids[k] == b.ids[k]) continue;
        ++tally.differ;
        if (a.stencil[k] != b.stencil[k]) continue; // a matter of coverage
        const auto width = static_cast<size_t>(duel.width());
        const auto depth_of = [&](std::uint32_t id) {
            return ExactPlane(snap(batch, id, viewport)).at(static_cast<int>(k % width), static_cast<int>(k / width));
        };
        constexpr double step = 0x1p-24; // of D32F in [1/2, 1)
        const bool farther = a.ids[k] == no_id || b.ids[k] == no_id || depth_of(a.ids[k]) > depth_of(b.ids[k]) + step;
        const ivec2 pixel(static_cast<int>(k % width), static_cast<int>(k / width));
        tally.wrong += farther && !hangs_on_rounding(exact_vertices(batch.positions), batch.triangles, viewport, pixel);
    }
}

} // namespace

bool check_meshes(const Options& options) {
    Verdict verdict("meshes");
    Random random(options.seed + 2);
    for (const char* name : {"builtin:default", "builtin:tree", "bunny_closed", "armadillo", "dragon"}) {
        const std::optional<Scene> scene = find_scene(name);
        if (!scene) {
            verdict.skip(fmt::format("{}: not among the shared scenes here", name));
            continue;
        }
        Tally transformed, given, power_of_two;
        DepthTally nearest;
        for (int i = 0; i < options.repeat(4); ++i) {
            const bool odd = i % 2 == 0;
            Duel duel({.width = odd ? 1000 : 1024, .height = odd ? 750 : 1024, .depth = Format::D32F});
            const double aspect = static_cast<double>(duel.width()) / duel.height();
            const Rectangle viewport =
                odd ? Rectangle{0, 0, duel.width(), duel.height()} : wide_viewport(duel.width(), duel.height());
            const mat4 to_clip = random_view(*scene, aspect, odd ? 0.6f : 1.6f, random);
            PipelineState state = counting_state();
            state.viewport = viewport;

            duel.clear();
            duel.draw_transformed(scene->positions, scene->triangles, to_clip, state);
            compare(duel, exact_vertices(scene->positions, to_clip), scene->triangles, viewport, transformed);

            Batch batch{{}, scene->triangles};
            for (const vec3& p : scene->positions) batch.positions.push_back(transform(to_clip, p));
            duel.clear();
            duel.draw(batch, state);
            compare(duel, exact_vertices(batch.positions), batch.triangles, viewport, given);
            if (!odd) compare(duel, exact_vertices(batch.positions), batch.triangles, viewport, power_of_two);
            compare_nearest(duel, batch, viewport, nearest);
        }
        verdict.require(fraction(transformed.differ, transformed.covered) <= 1e-5 && transformed.unexplained == 0,
                        fmt::format("{}, matrix in float32: {} of {} covered pixels differ ({:.1e}), {} unexplained",
                                    name, transformed.differ, transformed.covered,
                                    fraction(transformed.differ, transformed.covered), transformed.unexplained));
        verdict.require(fraction(given.differ, given.covered) <= 1e-5 && given.unexplained == 0,
                        fmt::format("{}, clip positions given: {} of {} differ ({:.1e}), {} unexplained", name,
                                    given.differ, given.covered, fraction(given.differ, given.covered),
                                    given.unexplained));
        if (power_of_two.covered)
            verdict.require(power_of_two.differ == 0,
                            fmt::format("{}, clip positions given, viewport a power of two: {} of {} differ", name,
                                        power_of_two.differ, power_of_two.covered));
        verdict.require(
            nearest.wrong == 0,
            fmt::format("{}, nearest primitive: {} of {} differ ({:.1e}); the exact planes call ours wrong at {}", name,
                        nearest.differ, nearest.covered, fraction(nearest.differ, nearest.covered), nearest.wrong));
    }
    return verdict.held();
}

} // namespace gnomon_conformance
