// The rest of the fixed function: each state on its own, over random triangles.

#include <algorithm>

#include <fmt/format.h>

#include "tests/conformance/exact_depth.h"
#include "tests/conformance/triangles.h"

namespace gnomon_conformance {
namespace {

constexpr int side = 256;

struct Difference {
    std::int64_t pixels = 0, stencil = 0, ids = 0, depth = 0;
};

void compare(const Duel& duel, Difference& d) {
    const Picture a = duel.ours(), b = duel.witness();
    for (size_t k = 0; k < duel.pixels(); ++k) {
        if (!a.stencil.empty()) d.stencil += a.stencil[k] != b.stencil[k];
        d.ids += a.ids[k] != b.ids[k];
        d.depth += a.depth[k] != b.depth[k];
    }
    d.pixels += static_cast<std::int64_t>(duel.pixels());
}

void require_identical(Verdict& verdict, const char* what, const Difference& d) {
    verdict.require(d.stencil == 0 && d.ids == 0 && d.depth == 0,
                    fmt::format("{}: {} pixels; differ: {} in count, {} in id, {} in depth", what, d.pixels, d.stencil,
                                d.ids, d.depth));
}

// One depth a triangle, of few values: equality is tested for, and gradients are zero.
void flatten(Batch& batch, Random& random) {
    for (const uvec3& t : batch.triangles) {
        const auto z = static_cast<float>(random.between(-3, 3)) * 0.25f;
        for (glm::length_t i = 0; i < 3; ++i) batch.positions[t[i]].z = z;
    }
}

Difference scissor_viewport_culling(const Options& options, Random& random) {
    Difference d;
    Duel duel({.width = side, .height = side});
    for (int i = 0; i < options.repeat(60); ++i) {
        Batch batch = random_batch(1024, {.width = side, .height = side}, random);
        flatten(batch, random);
        PipelineState state = counting_state();
        state.viewport = wide_viewport(side, side);
        state.viewport->x += random.between(-300, 300), state.viewport->y += random.between(-300, 300);
        const int x = random.between(-10, side), y = random.between(-10, side);
        if (random.chance(2)) state.scissor = Rectangle{x, y, random.between(0, side), random.between(0, side)};
        state.cull = random.pick<Cull>(3);
        state.front_face = random.pick<FrontFace>(2);
        duel.clear();
        duel.draw(batch, state);
        compare(duel, d);
    }
    return d;
}

// Over depths that draws have left, for bounds that some of them equal.
Difference depth_bounds(const Options& options, Random& random) {
    Difference d;
    for (const Format format : {Format::D16, Format::D24, Format::D32F}) {
        Duel duel({.width = side, .height = side, .depth = format});
        for (int i = 0; i < options.repeat(20); ++i) {
            duel.clear(0.5f);
            for (int layer = 0; layer < 3; ++layer) {
                Batch batch = random_batch(512, {.width = side, .height = side}, random);
                flatten(batch, random);
                PipelineState state = counting_state();
                state.viewport = wide_viewport(side, side);
                state.depth = {.test = random.pick<Compare>(8), .write = random.chance(2)};
                if (layer == 0) state.depth = {.test = Compare::Always, .write = true};
                if (layer > 0) {
                    const auto low = static_cast<float>(random.between(0, 8)),
                               high = static_cast<float>(random.between(0, 8));
                    state.depth.bounds = DepthState::Bounds{0.125f * std::min(low, high), 0.125f * std::max(low, high)};
                }
                duel.draw(batch, state);
            }
            compare(duel, d);
        }
    }
    return d;
}

Difference depth_functions(const Options& options, Random& random) {
    Difference d;
    for (const Format format : {Format::D16, Format::D24, Format::D32F}) {
        Duel duel({.width = side, .height = side, .depth = format});
        for (int i = 0; i < options.repeat(40); ++i) {
            Batch batch = random_batch(1024, {.width = side, .height = side}, random);
            flatten(batch, random);
            PipelineState state = counting_state();
            state.viewport = wide_viewport(side, side);
            state.depth = {.test = static_cast<Compare>(i % 8), .write = i % 16 < 8};
            state.stencil.front.depth_fail = StencilOp::Keep;
            state.clip_depth = random.chance(2) ? ClipDepth::ZeroToOne : ClipDepth::NegativeOneToOne;
            if (state.clip_depth == ClipDepth::ZeroToOne)
                for (vec4& p : batch.positions) p.z = 0.5f * p.z + 0.5f;
            duel.clear(0.5f);
            duel.draw(batch, state);
            compare(duel, d);
        }
    }
    return d;
}

// Depth with clamp or offset: how far each is from the exact value at pixels that show the same primitive.
struct DepthErrors {
    std::int64_t pixels = 0, coverage = 0;
    double ours = 0, theirs = 0, between = 0;
};

template <class Exact>
void compare_depth(const Duel& duel, const Batch& batch, Format format, const Exact& exact_depth, DepthErrors& e) {
    const Picture a = duel.ours(), b = duel.witness();
    const auto value = [&](std::uint32_t key) {
        return format == Format::D24 ? key / 16777215.0 : static_cast<double>(depth_from_key(format, key));
    };
    for (size_t k = 0; k < duel.pixels(); ++k) {
        e.coverage += a.ids[k] != b.ids[k] || a.stencil[k] != b.stencil[k];
        if (a.ids[k] == no_id || a.ids[k] != b.ids[k]) continue;
        const SnappedTriangle t = snap(batch, a.ids[k], wide_viewport(side, side));
        const double exact =
            std::clamp(exact_depth(t, ExactPlane(t), static_cast<int>(k % side), static_cast<int>(k / side)), 0.0, 1.0);
        e.ours = std::max(e.ours, std::abs(value(a.depth[k]) - exact));
        e.theirs = std::max(e.theirs, std::abs(value(b.depth[k]) - exact));
        e.between = std::max(e.between, std::abs(value(a.depth[k]) - value(b.depth[k])));
        ++e.pixels;
    }
}

void require_nearer(Verdict& verdict, const std::string& what, const DepthErrors& e) {
    verdict.require(
        e.coverage == 0 && e.ours <= e.theirs,
        fmt::format("{}: {} pixels, {} differ in coverage; from the exact depth at most: ours {:.2e}, theirs "
                    "{:.2e}; between the two {:.2e}",
                    what, e.pixels, e.coverage, e.ours, e.theirs, e.between));
}

DepthErrors depth_clamp(const Options& options, Random& random, Format format) {
    DepthErrors e;
    Duel duel({.width = side, .height = side, .depth = format});
    for (int i = 0; i < options.repeat(10); ++i) {
        Batch batch = random_batch(1024, {.width = side, .height = side}, random);
        for (vec4& p : batch.positions) p.z *= 3.0f; // two thirds lie beyond near or far
        PipelineState state = counting_state();
        state.viewport = wide_viewport(side, side);
        state.depth = {.test = Compare::Always, .write = true, .clamp = true};
        duel.clear();
        duel.draw(batch, state);
        compare_depth(
            duel, batch, format,
            [](const SnappedTriangle&, const ExactPlane& plane, int x, int y) { return plane.at(x, y); }, e);
    }
    return e;
}

DepthErrors polygon_offset(const Options& options, Random& random, Format format) {
    DepthErrors e;
    Duel duel({.width = side, .height = side, .depth = format});
    for (int i = 0; i < options.repeat(20); ++i) {
        Batch batch;
        while (batch.triangles.size() < 300) // gentle slopes, as offsets are meant for
            add_random(batch, random.chance(2) ? Shape::Large : Shape::Fan, {.width = side, .height = side}, random);
        for (vec4& p : batch.positions) p.z = 0.4f + 0.1f * p.z;
        PipelineState state = counting_state();
        state.viewport = wide_viewport(side, side);
        state.depth = {.test = Compare::Always, .write = true};
        state.polygon_offset = {static_cast<float>(random.between(-2, 4)), static_cast<float>(random.between(-50, 50)),
                                0};
        if (i % 4 == 3) state.polygon_offset.clamp = static_cast<float>(random.real(-1e-3, 1e-3));
        duel.clear();
        duel.draw(batch, state);
        const auto exact = [&](const SnappedTriangle& t, const ExactPlane& plane, int x, int y) {
            const PolygonOffset& o = state.polygon_offset;
            const double unit = depth_resolution(format, *std::max_element(t.z.begin(), t.z.end()));
            double offset = static_cast<double>(o.factor) * plane.slope() + static_cast<double>(o.units) * unit;
            if (o.clamp > 0) offset = std::min(offset, static_cast<double>(o.clamp));
            if (o.clamp < 0) offset = std::max(offset, static_cast<double>(o.clamp));
            return plane.at(x, y) + offset;
        };
        compare_depth(duel, batch, format, exact, e);
    }
    return e;
}

} // namespace

bool check_states(const Options& options) {
    Verdict verdict("states");
    Random random(options.seed + 6);
    require_identical(verdict, "scissor, viewport, culling", scissor_viewport_culling(options, random));
    require_identical(verdict, "depth functions, both clip ranges", depth_functions(options, random));
    if (gnomon_gl::has_depth_bounds())
        require_identical(verdict, "depth bounds", depth_bounds(options, random));
    else
        verdict.skip("depth bounds: the other side has no GL_EXT_depth_bounds_test");
    for (const Format format : {Format::D24, Format::D32F}) {
        require_nearer(verdict, fmt::format("{} depth clamp", info(format).name), depth_clamp(options, random, format));
        require_nearer(verdict, fmt::format("{} polygon offset", info(format).name),
                       polygon_offset(options, random, format));
    }
    return verdict.held();
}

} // namespace gnomon_conformance
