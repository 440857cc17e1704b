// Look-ups in a shadow map beside Mesa's llvmpipe: the same points, the same map, the same taps.

#include <fmt/format.h>

#include "bench/raster.h"
#include "techniques/map/shadow_map.h"
#include "tests/gl/context.h"
#include "tests/gl/draw.h"
#include "tests/gl/framebuffer.h"

namespace gnomon_bench {
namespace {

// The taps of percentage_closer() at one texel apart, without its gradient.
const char* const pcf_fragment = R"(#version 450 core
layout(binding = 0) uniform sampler2D points; // texel x, texel y, depth, 1 where a look-up is needed
layout(binding = 1) uniform sampler2D map;
layout(location = 0) out float visibility;
void main() {
    vec4 point = texelFetch(points, ivec2(gl_FragCoord.xy), 0);
    visibility = 1.0;
    if (point.w == 0.0) return;
    ivec2 first = ivec2(floor(point.xy)) - 7, size = textureSize(map, 0);
    int lit = 0;
    for (int v = 0; v < 15; ++v)
        for (int u = 0; u < 15; ++u) {
            ivec2 at = first + ivec2(u, v);
            bool inside = all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, size));
            lit += int(!inside || point.z <= texelFetch(map, clamp(at, ivec2(0), size - 1), 0).x);
        }
    visibility = float(lit) / 225.0;
})";

} // namespace

void time_pcf(Bench& bench, Scene scene) {
    const ivec2 size(1280, 720);
    const std::string name = fmt::format("pcf 15x15 {}x{}", size.x, size.y);
    if (!bench.wanted(name)) return;
    scene.lights.front().position = {4, 20, 3}; // high enough for one view to see all casters
    Frame frame(scene, scene.cameras.front(), size.x, size.y);
    ShadowMapParams params;
    params.projection = Projection::Single;
    const Light& light = scene.lights.front();
    const ShadowMap map = draw_shadow_map(frame, light, params);
    Image<MapPoint> points(size.x, size.y);
    std::vector<vec4> packed;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            MapPoint& p = points(x, y);
            p.lit = true;
            const Receiver& receiver = frame.receivers()(x, y);
            if (receiver.valid()) p = map_point(map, light, receiver);
            p.lit |= p.dark; // the same answer for both sides: no look-up
            packed.emplace_back(p.texel, p.depth, p.lit ? 0.0f : 1.0f);
        }
    std::vector<float> depths;
    for (const std::uint32_t key : keys_of(map.depth)) depths.push_back(depth_from_key(Format::D32F, key));
    const gnomon_gl::Framebuffer input({.width = size.x, .height = size.y, .depth = {}, .color = {Format::RGBA32F}});
    const gnomon_gl::Framebuffer map_copy(
        {.width = map.depth.width(), .height = map.depth.height(), .depth = Format::D32F, .stencil = false});
    const gnomon_gl::Framebuffer output({.width = size.x, .height = size.y, .depth = {}, .color = {Format::R32F}});
    input.upload_color(0, packed);
    map_copy.upload_depth(depths);
    const gnomon_gl::Program program(gnomon_gl::screen_vertex_source, pcf_fragment);
    const gnomon_gl::Screen screen;

    PassLog log;
    Image<float> visibility(size.x, size.y);
    const auto ours = [&] {
        Pass pass(log, "pcf");
        full_screen(pass, visibility, [&](Pixel& pixel) {
            const MapPoint& point = points(pixel.x, pixel.y);
            return point.lit ? 1.0f : percentage_closer(map, point, 15, vec2(7.5f), pixel.counters);
        });
    };
    const auto theirs = [&] {
        output.bind();
        gnomon_gl::set_state({}, size.x, size.y);
        input.bind_color_texture(0, 0);
        map_copy.bind_depth_texture(1);
        program.use();
        screen.draw();
        gnomon_gl::finish();
    };
    bench.run(name, ours, peer, theirs);
    double sum = 0, their_sum = 0;
    for (const float v : visibility.values()) sum += static_cast<double>(v);
    for (const vec4& v : output.colors(0)) their_sum += static_cast<double>(v.x);
    bench.agree(name, sum, their_sum, 1e-3);
}

} // namespace gnomon_bench
