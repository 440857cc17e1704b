// The rasterizer beside Mesa's llvmpipe: the same vertices, states and targets, on the same number of threads.

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "bench/raster.h"
#include "raster/draw.h"
#include "techniques/volume/shadow_volume.h"
#include "tests/gl/context.h"
#include "tests/gl/draw.h"
#include "tests/gl/framebuffer.h"

namespace gnomon_bench {

std::vector<std::uint32_t> keys_of(const Target& target) {
    std::vector<std::uint32_t> keys;
    for (int y = 0; y < target.height(); ++y)
        for (int x = 0; x < target.width(); ++x) keys.push_back(target.load_key(x, y));
    return keys;
}

namespace {

const char* const depth_vertex = R"(#version 450 core
layout(location = 0) in vec4 p;
uniform mat4 m;
void main() { gl_Position = m * p; })";
const char* const empty_fragment = "#version 450 core\nvoid main() {}";

const char* const gbuffer_vertex = R"(#version 450 core
layout(location = 0) in vec3 p;
layout(location = 1) in vec3 n;
uniform mat4 m;
out vec3 position, normal;
void main() { gl_Position = m * vec4(p, 1.0); position = p; normal = n; })";
const char* const gbuffer_fragment = R"(#version 450 core
in vec3 position, normal;
layout(location = 0) out vec4 out_position;
layout(location = 1) out vec4 out_normal;
void main() { out_position = vec4(position, 1.0); out_normal = vec4(normalize(normal), 0.0); })";

Geometry geometry(std::span<const vec3> positions, std::span<const uvec3> triangles) {
    return {static_cast<std::uint32_t>(positions.size()), triangles};
}

double mean_depth(const std::vector<std::uint32_t>& keys, Format format) {
    double sum = 0;
    for (const std::uint32_t key : keys) sum += static_cast<double>(depth_from_key(format, key));
    return sum / static_cast<double>(keys.size());
}

std::int64_t count_nonzero(const std::vector<std::uint32_t>& values) {
    return std::count_if(values.begin(), values.end(), [](std::uint32_t v) { return v != 0; });
}

void depth_pass(Bench& bench, const Scene& scene, const Camera& camera, Cull cull) {
    const gnomon_gl::Program program(depth_vertex, empty_fragment);
    std::optional<gnomon_gl::Mesh> mesh;
    for (const int side : {1024, 2048, 4096}) {
        const std::string name = fmt::format("depth {} {}", scene.name, side);
        if (!bench.wanted(name)) continue;
        if (!mesh) mesh.emplace(std::span<const vec3>(scene.positions), scene.triangles);
        const mat4 matrix = to_clip(camera, side, side);
        PipelineState state;
        state.depth = {.test = Compare::Less, .write = true};
        state.cull = cull;
        PassLog log;
        Target depth(Format::D32F, side, side);
        const gnomon_gl::Framebuffer framebuffer(
            {.width = side, .height = side, .depth = Format::D32F, .stencil = false});
        const auto ours = [&] {
            Pass pass(log, "depth");
            draw(
                pass, geometry(scene.positions, scene.triangles), state,
                [&](std::uint32_t i) { return transform(matrix, scene.positions[i]); }, depth_only,
                Targets{.depth = &depth, .clear_depth = 1.0f});
        };
        const auto theirs = [&] {
            framebuffer.bind();
            framebuffer.clear_depth(1.0f);
            gnomon_gl::set_state(state, side, side);
            program.set("m", matrix);
            program.use();
            mesh->draw();
            gnomon_gl::finish();
        };
        bench.run(name, ours, peer, theirs);
        bench.agree(name, mean_depth(keys_of(depth), Format::D32F), mean_depth(framebuffer.depth_keys(), Format::D32F),
                    1e-4);
    }
}

struct SurfaceVaryings {
    vec3 position, normal;
};

void gbuffer_pass(Bench& bench, const Scene& scene) {
    const gnomon_gl::Program program(gbuffer_vertex, gbuffer_fragment);
    for (const ivec2 size : {ivec2(1280, 720), ivec2(1920, 1080)}) {
        const std::string name = fmt::format("gbuffer {} {}x{}", scene.name, size.x, size.y);
        if (!bench.wanted(name)) continue;
        const gnomon_gl::Mesh mesh(std::span<const vec3>(scene.positions), scene.triangles, scene.normals);
        const mat4 matrix = to_clip(scene.cameras.front(), size.x, size.y);
        PipelineState state;
        state.depth = {.test = Compare::Less, .write = true};
        state.cull = Cull::Back;
        PassLog log;
        Target depth(Format::D32F, size.x, size.y), position(Format::RGBA32F, size.x, size.y),
            normal(Format::RGBA32F, size.x, size.y);
        const gnomon_gl::Framebuffer framebuffer({.width = size.x,
                                                  .height = size.y,
                                                  .depth = Format::D32F,
                                                  .stencil = false,
                                                  .color = {Format::RGBA32F, Format::RGBA32F}});
        const auto ours = [&] {
            Pass pass(log, "gbuffer");
            draw(
                pass, geometry(scene.positions, scene.triangles), state,
                [&](std::uint32_t i) {
                    return Vertex<SurfaceVaryings>{transform(matrix, scene.positions[i]),
                                                   {scene.positions[i], scene.normals[i]}};
                },
                FragmentProgram{[](const Fragment<SurfaceVaryings>& in, FragmentOutput& out) {
                                    out.color[0] = vec4(in.varyings.position, 1.0f);
                                    out.color[1] = vec4(glm::normalize(in.varyings.normal), 0.0f);
                                },
                                {.visible_only = true}},
                Targets{
                    .depth = &depth, .color = {&position, &normal}, .clear_depth = 1.0f, .clear_color = vec4(0.0f)});
        };
        const auto theirs = [&] {
            framebuffer.bind();
            framebuffer.clear_depth(1.0f);
            framebuffer.clear_color(0, vec4(0.0f));
            framebuffer.clear_color(1, vec4(0.0f));
            gnomon_gl::set_state(state, size.x, size.y);
            program.set("m", matrix);
            program.use();
            mesh.draw();
            gnomon_gl::finish();
        };
        bench.run(name, ours, peer, theirs);
        double sum = 0;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) sum += static_cast<double>(glm::dot(position.load(x, y), vec4(1.0f)));
        double their_sum = 0;
        for (const vec4& p : framebuffer.colors(0)) their_sum += static_cast<double>(glm::dot(p, vec4(1.0f)));
        bench.agree(name, sum, their_sum, 1e-3);
    }
}

// Counts the volume behind the visible surface. Building it is no part of the time.
void volume_pass(Bench& bench, const Scene& scene) {
    const gnomon_gl::Program program(depth_vertex, empty_fragment);
    std::optional<gnomon_gl::Mesh> caster, mesh;
    std::vector<vec4> points, vertices;
    std::vector<uvec3> triangles;
    for (const ivec2 size : {ivec2(1280, 720), ivec2(1920, 1080)}) {
        const std::string name = fmt::format("z-fail {} {}x{}", scene.name, size.x, size.y);
        if (!bench.wanted(name)) continue;
        const Camera& camera = scene.cameras.front();
        if (!mesh) {
            Frame frame(scene, camera, 64, 36);
            const ShadowVolume volume = build_shadow_volume(frame, scene.lights.front());
            for (const vec3& p : volume.finite) vertices.emplace_back(p, 1.0f);
            for (const vec3& p : volume.finite) vertices.emplace_back(p - vec3(volume.light), 0.0f);
            for (const auto* part : {&volume.sides, &volume.near_caps, &volume.far_caps})
                triangles.insert(triangles.end(), part->begin(), part->end());
            for (const vec3& p : scene.positions) points.emplace_back(p, 1.0f);
            caster.emplace(points, scene.triangles);
            mesh.emplace(vertices, triangles);
        }
        const mat4 matrix(infinite_projection_matrix(camera, static_cast<double>(size.x) / size.y) *
                          view_matrix(camera));
        PipelineState surface;
        surface.depth = {.test = Compare::Less, .write = true};
        PipelineState state;
        state.depth = {.test = Compare::Less, .write = false, .clamp = true};
        state.stencil.enabled = true;
        state.stencil.front.depth_fail = StencilOp::DecrementWrap;
        state.stencil.back.depth_fail = StencilOp::IncrementWrap;

        PassLog log;
        Target depth(Format::D24, size.x, size.y), stencil(Format::S8, size.x, size.y);
        const auto vertex = [&](const std::vector<vec4>& from) {
            return [&](std::uint32_t i) { return transform(matrix, vec3(from[i]), from[i].w); };
        };
        {
            Pass pass(log, "surface");
            depth.clear_depth(pass, 1.0f);
            draw(pass, geometry(scene.positions, scene.triangles), surface, vertex(points), depth_only,
                 Targets{.depth = &depth});
        }
        const gnomon_gl::Framebuffer framebuffer({.width = size.x, .height = size.y, .depth = Format::D24});
        framebuffer.bind();
        framebuffer.clear_depth(1.0f);
        program.set("m", matrix);
        program.use();
        gnomon_gl::set_state(surface, size.x, size.y);
        caster->draw();

        const auto ours = [&] {
            Pass pass(log, "volume");
            draw(pass, {static_cast<std::uint32_t>(vertices.size()), triangles}, state, vertex(vertices), depth_only,
                 Targets{.depth = &depth, .stencil = &stencil, .clear_stencil = 0});
        };
        const auto theirs = [&] {
            framebuffer.bind();
            framebuffer.clear_stencil(0);
            gnomon_gl::set_state(state, size.x, size.y);
            program.set("m", matrix);
            program.use();
            mesh->draw();
            gnomon_gl::finish();
        };
        bench.run(name, ours, peer, theirs);
        // Their depth meets near caps only nearly, so lit surfaces count a few casters of their own.
        bench.agree(name, static_cast<double>(count_nonzero(keys_of(stencil))),
                    static_cast<double>(count_nonzero(framebuffer.stencil())), 0.5);
    }
}

enum class Fill { Write, Reject, Stencil };

void fill(Bench& bench, Fill fill, const char* fill_name) {
    const gnomon_gl::Program program(depth_vertex, empty_fragment);
    for (const int side : {1024, 2048, 4096}) {
        const std::string name = fmt::format("fill {} {}", fill_name, side);
        if (!bench.wanted(name)) continue;
        const int layers = side == 4096 ? 16 : 64;
        std::vector<vec4> vertices;
        std::vector<uvec3> triangles;
        for (int i = 0; i < layers; ++i) {
            const float step = static_cast<float>(i) / static_cast<float>(layers);
            const float z = fill == Fill::Write ? 0.99f - 1.98f * step : 0.99f * step; // written: each nearer
            const auto first = static_cast<std::uint32_t>(vertices.size());
            vertices.insert(vertices.end(), {{-1, -1, z, 1}, {1, -1, z, 1}, {-1, 1, z, 1}, {1, 1, z, 1}});
            triangles.push_back({first, first + 1, first + 2});
            triangles.push_back({first + 2, first + 1, first + 3});
        }
        const gnomon_gl::Mesh mesh(vertices, triangles);
        PipelineState state;
        state.depth = {.test = Compare::Less, .write = fill != Fill::Stencil};
        state.stencil.enabled = fill == Fill::Stencil;
        state.stencil.front.depth_fail = StencilOp::IncrementWrap;
        const Format format = fill == Fill::Stencil ? Format::D24 : Format::D32F;
        const float cleared = fill == Fill::Write ? 1.0f : 0.05f;
        PassLog log;
        Target depth(format, side, side);
        std::optional<Target> stencil;
        if (fill == Fill::Stencil) stencil.emplace(Format::S8, side, side);
        const gnomon_gl::Framebuffer framebuffer(
            {.width = side, .height = side, .depth = format, .stencil = fill == Fill::Stencil});
        {
            Pass pass(log, "clear");
            depth.clear_depth(pass, cleared);
            framebuffer.clear_depth(cleared);
            if (stencil) framebuffer.clear_stencil(0);
        }
        const auto ours = [&] {
            Pass pass(log, "fill");
            Targets targets{.depth = &depth, .stencil = stencil ? &*stencil : nullptr};
            if (fill == Fill::Write) targets.clear_depth = cleared;
            draw(
                pass, {static_cast<std::uint32_t>(vertices.size()), triangles}, state,
                [&](std::uint32_t i) { return vertices[i]; }, depth_only, targets);
        };
        const auto theirs = [&] {
            framebuffer.bind();
            if (fill == Fill::Write) framebuffer.clear_depth(cleared);
            gnomon_gl::set_state(state, side, side);
            program.set("m", mat4(1.0f));
            program.use();
            mesh.draw();
            gnomon_gl::finish();
        };
        bench.run(name, ours, peer, theirs);
        bench.agree(name, mean_depth(keys_of(depth), format), mean_depth(framebuffer.depth_keys(), format), 1e-4);
    }
}

// The same pass on 2 threads and on 1.
void scaling(Bench& bench, const Scene& scene) {
    constexpr int side = 4096;
    const std::string name = fmt::format("threads depth {} {}", scene.name, side);
    if (!bench.wanted(name)) return;
    const mat4 matrix = to_clip(scene.cameras.front(), side, side);
    PipelineState state;
    state.depth = {.test = Compare::Less, .write = true};
    PassLog log;
    Target depth(Format::D32F, side, side);
    const auto work = [&] {
        Pass pass(log, "depth");
        draw(
            pass, geometry(scene.positions, scene.triangles), state,
            [&](std::uint32_t i) { return transform(matrix, scene.positions[i]); }, depth_only,
            Targets{.depth = &depth, .clear_depth = 1.0f});
    };
    bench.run(name, work, "gnomon on 1 thread", [&] { with_threads(1, work); });
}

} // namespace

void bench_raster(Bench& bench) {
    std::string reason;
    const auto context = gnomon_gl::Context::open({.hardware = false, .threads = threads}, reason);
    if (!context) throw std::runtime_error("there is no peer to time: " + reason);
    fmt::print(stderr, "peer: {}, {} threads each\n", context->description(), threads);
    const Scene big = spheres(true), small = spheres(false), field = height_field();
    if (big.triangles.size() != 1003520 || small.triangles.size() != 20000 || field.triangles.size() < 1000000)
        throw std::logic_error("the procedural scenes have lost triangles");
    const std::optional<Scene> house = shared_scene("house"), armadillo = shared_scene("armadillo");
    for (const auto& [scene, name] : {std::pair{&house, "house"}, {&armadillo, "armadillo"}})
        if (!*scene) fmt::print(stderr, "skipped: {} is not among the shared scenes here\n", name);

    depth_pass(bench, big, big.cameras[1], Cull::Back);
    depth_pass(bench, small, small.cameras[1], Cull::Back);
    depth_pass(bench, field, field.cameras[0], Cull::None);
    if (house) depth_pass(bench, *house, house->cameras[0], Cull::None);
    if (house) scaling(bench, *house);
    gbuffer_pass(bench, small);
    gbuffer_pass(bench, big);
    gbuffer_pass(bench, field);
    volume_pass(bench, small);
    volume_pass(bench, big);
    if (armadillo) volume_pass(bench, *armadillo);
    volume_pass(bench, field);
    fill(bench, Fill::Write, "depth-write");
    fill(bench, Fill::Reject, "depth-reject");
    fill(bench, Fill::Stencil, "stencil");
    time_pcf(bench, small);
}

} // namespace gnomon_bench
