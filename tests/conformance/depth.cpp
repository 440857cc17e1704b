// How far depth is from the exact plane through the snapped vertices: ours must be nearer than theirs at the median, at
// the 99th percentile and at the maximum.

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "tests/conformance/exact_depth.h"
#include "tests/conformance/scenes.h"
#include "tests/conformance/triangles.h"

namespace gnomon_conformance {
namespace {

struct Errors {
    std::vector<float> ours, theirs;
};

std::array<double, 3> summary(std::vector<float>& errors) {
    std::sort(errors.begin(), errors.end());
    const auto at = [&](double quantile) {
        return static_cast<double>(errors[static_cast<size_t>(quantile * static_cast<double>(errors.size() - 1))]);
    };
    return {at(0.5), at(0.99), at(1.0)};
}

double depth_value(Format format, std::uint32_t key) { // without depth_from_key's rounding to float
    return format == Format::D24 ? key / 16777215.0 : static_cast<double>(depth_from_key(format, key));
}

// The last primitive to write a pixel left its depth there.
void measure(Duel& duel, const Batch& batch, Format format, Errors& all, Errors& steep) {
    PipelineState state;
    state.viewport = wide_viewport(duel.width(), duel.height());
    state.depth = {.test = Compare::Always, .write = true};
    duel.clear();
    duel.draw(batch, state);
    const Picture a = duel.ours(), b = duel.witness();
    for (size_t k = 0; k < duel.pixels(); ++k) {
        if (a.ids[k] == no_id || a.ids[k] != b.ids[k]) continue;
        const ExactPlane plane(snap(batch, a.ids[k], *state.viewport));
        const auto width = static_cast<size_t>(duel.width());
        const double exact = plane.at(static_cast<int>(k % width), static_cast<int>(k / width));
        const auto ours = static_cast<float>(std::abs(depth_value(format, a.depth[k]) - exact));
        const auto theirs = static_cast<float>(std::abs(depth_value(format, b.depth[k]) - exact));
        all.ours.push_back(ours), all.theirs.push_back(theirs);
        if (plane.slope() > 1e-3) steep.ours.push_back(ours), steep.theirs.push_back(theirs);
    }
}

void judge(Verdict& verdict, const std::string& what, Errors& errors) {
    if (errors.ours.size() < 1000) return;
    const std::array<double, 3> ours = summary(errors.ours), theirs = summary(errors.theirs);
    verdict.require(
        ours[0] <= theirs[0] && ours[1] <= theirs[1] && ours[2] <= theirs[2],
        fmt::format("{}: {} pixels; median, 99 %, max: ours {:.2e} {:.2e} {:.2e}, theirs {:.2e} {:.2e} {:.2e}", what,
                    errors.ours.size(), ours[0], ours[1], ours[2], theirs[0], theirs[1], theirs[2]));
}

} // namespace

bool check_depth(const Options& options) {
    Verdict verdict("depth");
    Random random(options.seed + 4);
    for (const Format format : {Format::D24, Format::D32F}) {
        Duel duel({.width = 512, .height = 512, .depth = format});
        const char* name = info(format).name;
        {
            Errors all, steep;
            for (int i = 0; i < options.repeat(8); ++i)
                measure(duel, random_batch(8192, {.width = 512, .height = 512}, random), format, all, steep);
            judge(verdict, fmt::format("{}, random triangles", name), all);
        }
        for (const char* mesh : {"builtin:default", "armadillo", "dragon"}) {
            const std::optional<Scene> scene = find_scene(mesh);
            if (!scene) {
                verdict.skip(fmt::format("{}: not among the shared scenes here", mesh));
                continue;
            }
            Errors all, steep;
            for (int i = 0; i < options.repeat(4); ++i) {
                const mat4 to_clip = random_view(*scene, 1.0, 1.6f, random);
                Batch batch{{}, scene->triangles};
                for (const vec3& p : scene->positions) batch.positions.push_back(transform(to_clip, p));
                measure(duel, batch, format, all, steep);
            }
            judge(verdict, fmt::format("{}, {}", name, mesh), all);
            judge(verdict, fmt::format("{}, {}, more than 1e-3 a pixel", name, mesh), steep);
        }
    }
    return verdict.held();
}

} // namespace gnomon_conformance
