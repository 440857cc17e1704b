// Shadow volumes counted behind the visible surface (z-fail) in 8 bits of stencil: counts depend on interpolated depth,
// and where the two differ, planes in extended precision judge. Volumes to infinity are cut as well, by each side in
// its own way, or here, alike for both; finite ones inside the viewport show depth alone.

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include <glm/gtc/matrix_transform.hpp>

#include "raster/clip.h"
#include "techniques/volume/shadow_volume.h"
#include "tests/conformance/exact_depth.h"
#include "tests/conformance/explain.h"
#include "tests/conformance/scenes.h"
#include "tests/conformance/triangles.h"
#include "tests/raster/scalar.h"

namespace gnomon_conformance {
namespace {

// A vertex as the contract has it: snapped where it lies within the guard band, for the clipper to leave alone, else as
// it was submitted. Of cut triangles the plane goes through the corners that are left and exactly towards those that
// are not: what the cuts themselves round is far away, and each side's own.
dvec4 as_drawn(const vec4& clip, const Rectangle& viewport) {
    const dvec4 v(clip);
    const dvec2 size(viewport.width, viewport.height), band = 2.0 * guard_band_pixels / size;
    if (!(v.w > 0) || std::abs(v.x) > band.x * v.w || std::abs(v.y) > band.y * v.w) return v;
    const SnappedVertex s = snap(clip, viewport);
    const dvec2 ndc = (dvec2(s.x, s.y) - dvec2(viewport.x, viewport.y)) / size * 2.0 - 1.0;
    return dvec4(dvec3(ndc, 2 * s.z - 1) * v.w, v.w);
}

struct ExactFragment {
    float z; // clamped to [0, 1], as D32F stores it
    bool front;
};

// Whether all corners lie on one side of the pixel, by a pixel and more, along x or y; most do.
bool misses(const std::array<vec4, 3>& corners, const Rectangle& viewport, ivec2 pixel) {
    const vec2 size(viewport.width, viewport.height), step = 2.0f / size;
    const vec2 at = (vec2(pixel) + 0.5f - vec2(viewport.x, viewport.y)) * step - 1.0f;
    for (const glm::length_t axis : {0, 1})
        for (const float sign : {-1.0f, 1.0f})
            if (std::all_of(corners.begin(), corners.end(), [&](const vec4& v) {
                    return sign * (v[axis] - at[axis] * v.w) > step[axis] * std::abs(v.w);
                }))
                return true;
    return false;
}

std::optional<ExactFragment> exact_fragment(const std::array<vec4, 3>& corners, const Rectangle& viewport,
                                            ivec2 pixel) {
    const auto inside = [](const vec4& v) { return v.w > 0 && std::abs(v.x) <= v.w && std::abs(v.y) <= v.w; };
    double z = 0;
    bool front = false;
    if (std::all_of(corners.begin(), corners.end(), inside)) {
        const SnappedTriangle t = snap(corners, viewport);
        gnomon_tests::FixedTriangle fixed{};
        for (size_t i = 0; i < 3; ++i) fixed.v[i] = {std::llrint(t.x[i] * 256), std::llrint(t.y[i] * 256), 0.0f};
        if (!gnomon_tests::covers(fixed, pixel.x, pixel.y)) return std::nullopt;
        z = ExactPlane(t).at(pixel.x, pixel.y);
        front = gnomon_tests::front(fixed);
    } else {
        const dvec4 a = as_drawn(corners[0], viewport), b = as_drawn(corners[1], viewport),
                    c = as_drawn(corners[2], viewport);
        const auto ndc = homogeneous_depth(a, b, c, viewport, dvec2(pixel) + 0.5);
        if (!ndc) return std::nullopt;
        z = 0.5 * *ndc + 0.5;
        front = glm::dot(dvec3(a.x, a.y, a.w), glm::cross(dvec3(b.x, b.y, b.w), dvec3(c.x, c.y, c.w))) > 0;
    }
    return ExactFragment{static_cast<float>(std::clamp(z, 0.0, 1.0)), front};
}

// The volumes of a scene as one view draws them. The scene is drawn as their near caps, so that the two coincide in any
// arithmetic.
struct Case {
    std::vector<vec4> positions; // clip space
    std::vector<uvec3> near_caps, sides, far_caps;
    Rectangle viewport;
};

// The count that exact planes give: front faces −1 and back faces +1 where not nearer than the surface.
std::uint32_t exact_count(const Case& c, ivec2 pixel) {
    const auto visit = [&](const std::vector<uvec3>& triangles, const auto& use) {
        for (const uvec3& t : triangles) {
            const std::array corners = {c.positions[t.x], c.positions[t.y], c.positions[t.z]};
            if (misses(corners, c.viewport, pixel)) continue;
            if (const auto fragment = exact_fragment(corners, c.viewport, pixel)) use(*fragment);
        }
    };
    float surface = 1;
    visit(c.near_caps, [&](const ExactFragment& f) { surface = std::min(surface, f.z); });
    int count = 0;
    for (const auto* part : {&c.sides, &c.near_caps, &c.far_caps})
        visit(*part, [&](const ExactFragment& f) { count += f.z < surface ? 0 : f.front ? -1 : 1; });
    return static_cast<std::uint32_t>(count) & 0xff;
}

// `reach` metres behind each caster, or to infinity.
Case in_clip_space(const ShadowVolume& volume, const mat4& to_clip, std::optional<float> reach,
                   const Rectangle& viewport) {
    Case c{{}, volume.near_caps, volume.sides, volume.far_caps, viewport};
    const auto finite = static_cast<std::uint32_t>(volume.finite.size());
    for (std::uint32_t i = 0; i < 2 * finite; ++i) {
        if (i >= finite && reach) {
            const vec3 p = volume.finite[i - finite];
            c.positions.push_back(transform(to_clip, p + *reach * glm::normalize(p - vec3(volume.light))));
        } else {
            c.positions.push_back(volume.vertex(i, to_clip));
        }
    }
    return c;
}

// The triangles cut at the sides of the viewport, so that nobody else has to: their fans, over vertices of their own.
void cut_at_viewport(Case& c) {
    SetupState state{};
    constexpr int a_little_less = 33000; // than twice the guard band: the cuts are inside
    state.viewport = {0, 0, a_little_less, a_little_less};
    state.depth_clamp = true;
    for (std::vector<uvec3>* part : {&c.near_caps, &c.sides, &c.far_caps}) {
        std::vector<uvec3> fans;
        for (const uvec3& t : *part) {
            const ClippedPolygon polygon = clip(state, {c.positions[t.x], c.positions[t.y], c.positions[t.z]});
            const auto first = static_cast<std::uint32_t>(c.positions.size());
            for (std::uint32_t i = 1; static_cast<int>(i) + 1 < polygon.count; ++i)
                fans.push_back(polygon.mirrored ? uvec3(first, first + i + 1, first + i)
                                                : uvec3(first, first + i, first + i + 1));
            for (size_t i = 0; i < static_cast<size_t>(polygon.count); ++i)
                c.positions.push_back(polygon.corners[i].position);
        }
        *part = std::move(fans);
    }
}

enum class Count { Behind, Everything };

void draw_both(Duel& duel, const Case& c, Count count) {
    Batch batch{c.positions, c.near_caps};
    PipelineState state;
    state.viewport = c.viewport;
    state.depth = {.test = Compare::Less, .write = true, .clamp = true};
    duel.clear();
    duel.draw(batch, state);
    if (count == Count::Everything) state = counting_state(), state.depth.clamp = true, state.viewport = c.viewport;
    state.depth.write = false;
    state.stencil.enabled = true;
    if (count == Count::Behind) {
        state.stencil.front.depth_fail = StencilOp::DecrementWrap;
        state.stencil.back.depth_fail = StencilOp::IncrementWrap;
    }
    for (const auto* part : {&c.sides, &c.near_caps, &c.far_caps}) {
        batch.triangles = *part;
        if (!part->empty()) duel.draw(batch, state);
    }
}

struct Tally {
    std::int64_t pixels = 0, coverage = 0, differ = 0, ours = 0, theirs = 0, neither = 0;
};

void compare(Duel& duel, const Case& c, Tally& tally) {
    draw_both(duel, c, Count::Everything);
    const Picture all_ours = duel.ours(), all_theirs = duel.witness();
    draw_both(duel, c, Count::Behind);
    const Picture a = duel.ours(), b = duel.witness();
    const auto width = static_cast<size_t>(duel.width());
    for (size_t k = 0; k < duel.pixels(); ++k) {
        ++tally.pixels;
        tally.coverage += all_ours.stencil[k] != all_theirs.stencil[k];
        if (a.stencil[k] == b.stencil[k]) continue;
        ++tally.differ;
        const std::uint32_t exact = exact_count(c, ivec2(static_cast<int>(k % width), static_cast<int>(k / width)));
        ++(exact == a.stencil[k] ? tally.ours : exact == b.stencil[k] ? tally.theirs : tally.neither);
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

// Finite: within twice the scene's radius, all of it inside a viewport around the target, so that nothing is clipped.
// Cut: to infinity, cut here at the sides of such a viewport. Infinite: to infinity, cut by each side in its own way.
enum class Volumes { Finite, Cut, Infinite };

Case view_of(const ShadowVolume& volume, const Scene& scene, const Camera& camera, Volumes volumes, const Duel& duel,
             Random& random) {
    const double aspect = static_cast<double>(duel.width()) / duel.height();
    const Rectangle wide = wide_viewport(duel.width(), duel.height());
    if (volumes == Volumes::Finite) {
        Scene around;
        const vec3 margin(0.58f * scene.bounds.diagonal()); // the half diagonal of a cube of this is 2 radii
        around.bounds.extend(scene.bounds.center() - margin);
        around.bounds.extend(scene.bounds.center() + margin);
        return in_clip_space(volume, random_view(around, aspect, 1.6f, random), 0.5f * scene.bounds.diagonal(), wide);
    }
    const dmat4 to_clip = infinite_projection_matrix(camera, aspect) * view_matrix(camera);
    if (volumes == Volumes::Infinite)
        return in_clip_space(volume, mat4(to_clip), {}, {0, 0, duel.width(), duel.height()});
    Case c = in_clip_space(volume, mat4(glm::scale(dmat4(1.0), dvec3(0.25, 0.25, 1.0)) * to_clip), {}, wide);
    cut_at_viewport(c);
    return c;
}

// `few`: the two may differ at one pixel in 10⁴. That is a bound on llvmpipe where ours is right at all of them.
void judge(Verdict& verdict, const std::string& name, const Tally& tally, bool few) {
    verdict.figure(fmt::format("{}: of {} pixels {} differ in what covers them", name, tally.pixels, tally.coverage));
    const double share = fraction(tally.differ, tally.pixels);
    verdict.require((!few || share <= 1e-4) && tally.ours == tally.differ,
                    fmt::format("{}: {} of {} pixels differ in count ({:.1e}); exact planes call ours right at {}, "
                                "theirs at {}, neither at {}",
                                name, tally.differ, tally.pixels, share, tally.ours, tally.theirs, tally.neither));
}

bool check(Verdict verdict, const Options& options, Volumes volumes, bool few) {
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
            compare(duel, view_of(volume, *scene, camera, volumes, duel, random), tally);
        }
        judge(verdict, name, tally, few);
    }
    return verdict.held();
}

} // namespace

bool check_volumes(const Options& options) { return check(Verdict("volumes"), options, Volumes::Finite, true); }
bool check_exact_volumes(const Options& options) {
    const bool infinite = check(Verdict("exact-volumes, cut by each side"), options, Volumes::Infinite, false);
    return check(Verdict("exact-volumes, cut alike"), options, Volumes::Cut, false) && infinite;
}
bool check_infinite_volumes(const Options& options) {
    return check(Verdict("infinite-volumes"), options, Volumes::Infinite, true);
}

} // namespace gnomon_conformance
