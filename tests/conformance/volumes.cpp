// Shadow volumes counted behind the visible surface (z-fail) in 8 bits of stencil: counts depend on interpolated depth,
// and where the two differ, planes in extended precision judge. Volumes to infinity are clipped as well, by each side
// in its own way, which moves their faces by a sub-pixel step; finite ones inside the viewport show depth alone.

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "techniques/volume/shadow_volume.h"
#include "tests/conformance/exact_depth.h"
#include "tests/conformance/explain.h"
#include "tests/conformance/scenes.h"
#include "tests/conformance/triangles.h"
#include "tests/raster/scalar.h"

namespace gnomon_conformance {
namespace {

// A fragment in double precision: of the snapped triangle where nothing is clipped, else of the triangle as submitted,
// since clipping and snapping what is clipped are each side's own: `shift` moves it by what a snap may.
struct ExactFragment {
    float z; // clamped to [0, 1], as D32F stores it
    bool front;
};

std::optional<ExactFragment> exact_fragment(const Batch& batch, std::uint32_t triangle, const Rectangle& viewport,
                                            ivec2 pixel, dvec2 shift) {
    const uvec3 index = batch.triangles[triangle];
    const dvec4 a(batch.positions[index.x]), b(batch.positions[index.y]), c(batch.positions[index.z]);
    const auto inside = [](const dvec4& v) { return v.w > 0 && std::abs(v.x) <= v.w && std::abs(v.y) <= v.w; };
    double z = 0;
    bool front = false;
    if (inside(a) && inside(b) && inside(c)) {
        const SnappedTriangle t = snap(batch, triangle, viewport);
        gnomon_tests::FixedTriangle fixed{};
        for (size_t i = 0; i < 3; ++i) fixed.v[i] = {std::llrint(t.x[i] * 256), std::llrint(t.y[i] * 256), 0.0f};
        if (!gnomon_tests::covers(fixed, pixel.x, pixel.y)) return std::nullopt;
        z = ExactPlane(t).at(pixel.x, pixel.y);
        front = gnomon_tests::front(fixed);
    } else {
        const auto ndc = homogeneous_depth(a, b, c, viewport, dvec2(pixel) + 0.5 + shift);
        if (!ndc) return std::nullopt;
        z = 0.5 * *ndc + 0.5;
        front = glm::dot(dvec3(a.x, a.y, a.w), glm::cross(dvec3(b.x, b.y, b.w), dvec3(c.x, c.y, c.w))) > 0;
    }
    return ExactFragment{static_cast<float>(std::clamp(z, 0.0, 1.0)), front};
}

// The count that exact planes give: front faces −1 and back faces +1 where not nearer than the surface.
std::uint32_t exact_count(Batch& batch, const ShadowVolume& volume, const Rectangle& viewport, ivec2 pixel,
                          dvec2 shift) {
    const auto visit = [&](const std::vector<uvec3>& triangles, const auto& use) {
        batch.triangles = triangles;
        for (std::uint32_t i = 0; i < triangles.size(); ++i)
            if (const auto fragment = exact_fragment(batch, i, viewport, pixel, shift)) use(*fragment);
    };
    float surface = 1;
    visit(volume.near_caps, [&](const ExactFragment& f) { surface = std::min(surface, f.z); });
    int count = 0;
    for (const auto* part : {&volume.sides, &volume.near_caps, &volume.far_caps})
        visit(*part, [&](const ExactFragment& f) { count += f.z < surface ? 0 : f.front ? -1 : 1; });
    return static_cast<std::uint32_t>(count) & 0xff;
}

// `reach` metres behind each caster, or to infinity.
Batch in_clip_space(const ShadowVolume& volume, const mat4& to_clip, std::optional<float> reach) {
    Batch batch;
    const auto finite = static_cast<std::uint32_t>(volume.finite.size());
    for (std::uint32_t i = 0; i < 2 * finite; ++i) {
        if (i >= finite && reach) {
            const vec3 p = volume.finite[i - finite];
            batch.positions.push_back(transform(to_clip, p + *reach * glm::normalize(p - vec3(volume.light))));
        } else {
            batch.positions.push_back(volume.vertex(i, to_clip));
        }
    }
    return batch;
}

// The same, where no snap of a clipped triangle changes it.
std::optional<std::uint32_t> certain_count(Batch& batch, const ShadowVolume& volume, const Rectangle& viewport,
                                           ivec2 pixel) {
    const std::uint32_t count = exact_count(batch, volume, viewport, pixel, dvec2(0.0));
    constexpr double reach = 1.0 / 256; // half a step by snapping, and as much again for float32 before it
    for (const dvec2 shift : {dvec2(-reach, -reach), dvec2(reach, -reach), dvec2(-reach, reach), dvec2(reach, reach)})
        if (exact_count(batch, volume, viewport, pixel, shift) != count) return std::nullopt;
    return count;
}

enum class Count { Behind, Everything };

struct Case {
    const ShadowVolume& volume;
    Batch vertices;
    Rectangle viewport;
};

void draw_both(Duel& duel, const Case& c, Count count) {
    const ShadowVolume& volume = c.volume;
    // The scene is drawn as the volumes' near caps, so that the two coincide in any arithmetic.
    Batch batch = c.vertices;
    PipelineState state;
    state.viewport = c.viewport;
    state.depth = {.test = Compare::Less, .write = true, .clamp = true};
    batch.triangles = volume.near_caps;
    duel.clear();
    duel.draw(batch, state);
    if (count == Count::Everything) state = counting_state(), state.depth.clamp = true, state.viewport = c.viewport;
    state.depth.write = false;
    state.stencil.enabled = true;
    if (count == Count::Behind) {
        state.stencil.front.depth_fail = StencilOp::DecrementWrap;
        state.stencil.back.depth_fail = StencilOp::IncrementWrap;
    }
    for (const auto* part : {&volume.sides, &volume.near_caps, &volume.far_caps}) {
        batch.triangles = *part;
        if (!part->empty()) duel.draw(batch, state);
    }
}

struct Tally {
    std::int64_t pixels = 0, coverage = 0, differ = 0, uncertain = 0, ours = 0, theirs = 0, neither = 0;
};

void compare(Duel& duel, const Case& c, Tally& tally) {
    draw_both(duel, c, Count::Everything);
    const Picture all_ours = duel.ours(), all_theirs = duel.witness();
    draw_both(duel, c, Count::Behind);
    const Picture a = duel.ours(), b = duel.witness();
    Batch batch = c.vertices;
    const auto width = static_cast<size_t>(duel.width());
    for (size_t k = 0; k < duel.pixels(); ++k) {
        ++tally.pixels;
        tally.coverage += all_ours.stencil[k] != all_theirs.stencil[k];
        if (a.stencil[k] == b.stencil[k]) continue;
        ++tally.differ;
        const auto exact =
            certain_count(batch, c.volume, c.viewport, ivec2(static_cast<int>(k % width), static_cast<int>(k / width)));
        if (!exact)
            ++tally.uncertain;
        else if (*exact == a.stencil[k])
            ++tally.ours;
        else
            ++(*exact == b.stencil[k] ? tally.theirs : tally.neither);
    }
}

// The n-th camera looks at the scene from outside, towards its middle.
Camera camera_of(const Scene& scene, int n, Random& random) {
    if (n == 0) return scene.cameras.front();
    const float radius = 0.5f * scene.bounds.diagonal();
    const vec3 direction(dvec3(random.real(-1, 1), random.real(0.2, 1), random.real(-1, 1)));
    Camera camera =
        look_at(scene.bounds.center() + glm::normalize(direction) * radius * 1.6f, scene.bounds.center(), 0.8f);
    fit_planes(camera, scene.bounds);
    return camera;
}

void judge(Verdict& verdict, const std::string& name, const Tally& tally) {
    verdict.figure(fmt::format("{}: of {} pixels {} differ in what covers them", name, tally.pixels, tally.coverage));
    verdict.require(
        fraction(tally.differ, tally.pixels) <= 1e-4 && tally.theirs + tally.neither == 0,
        fmt::format("{}: {} of {} pixels differ in count ({:.1e}); exact planes call ours right at {}, theirs "
                    "at {}, neither at {}; at {} a sub-pixel step of a clipped vertex decides",
                    name, tally.differ, tally.pixels, fraction(tally.differ, tally.pixels), tally.ours, tally.theirs,
                    tally.neither, tally.uncertain));
}

// Volumes that end within twice the scene's radius, all of it inside a viewport around the target: nothing is clipped.
Case unclipped_case(const ShadowVolume& volume, const Scene& scene, const Duel& duel, Random& random) {
    Scene around;
    const vec3 margin(0.58f * scene.bounds.diagonal()); // the half diagonal of a cube of this is 2 radii
    around.bounds.extend(scene.bounds.center() - margin);
    around.bounds.extend(scene.bounds.center() + margin);
    const mat4 to_clip = random_view(around, static_cast<double>(duel.width()) / duel.height(), 1.6f, random);
    return {volume, in_clip_space(volume, to_clip, 0.5f * scene.bounds.diagonal()),
            wide_viewport(duel.width(), duel.height())};
}

bool check(Verdict verdict, const Options& options, bool infinite) {
    Random random(options.seed + 5);
    for (const char* name : {"builtin:default", "builtin:tree", "armadillo"}) {
        const std::optional<Scene> scene = find_scene(name);
        if (!scene) {
            verdict.skip(fmt::format("{}: not among the shared scenes here", name));
            continue;
        }
        Duel duel({.width = 640, .height = 360, .depth = Format::D32F});
        Tally tally;
        for (int i = 0; i < options.repeat(2); ++i) {
            const Camera camera = camera_of(*scene, i, random);
            Frame frame(*scene, camera, duel.width(), duel.height());
            const ShadowVolume volume = build_shadow_volume(frame, scene->lights.front());
            if (volume.light.w == 0) continue; // a directional light has no place to extrude from
            const mat4 to_clip(infinite_projection_matrix(camera, frame.aspect()) * view_matrix(camera));
            compare(duel,
                    infinite ? Case{volume, in_clip_space(volume, to_clip, {}), {0, 0, duel.width(), duel.height()}}
                             : unclipped_case(volume, *scene, duel, random),
                    tally);
        }
        judge(verdict, name, tally);
    }
    return verdict.held();
}

} // namespace

bool check_volumes(const Options& options) { return check(Verdict("volumes"), options, false); }
bool check_infinite_volumes(const Options& options) { return check(Verdict("infinite-volumes"), options, true); }

} // namespace gnomon_conformance
