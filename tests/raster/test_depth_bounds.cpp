#include <catch2/catch.hpp>

#include "raster/draw.h"

using namespace gnomon;

TEST_CASE("depth bounds are inclusive and ask about the stored depth alone", "[bits]") {
    const StencilOp count =
        GENERATE(StencilOp::Increment, StencilOp::IncrementWrap); // wrapping counts have a path of their own
    constexpr float stored[] = {0.0f, 0.25f, 0.5f, 0.75f, 1.0f};  // 0.25 and 0.75 are the bounds
    for (const Format format : {Format::D16, Format::D24, Format::D32F}) {
        Target depth(format, 8, 8), stencil(Format::S8, 8, 8);
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 8; ++x) depth.store_key(x, y, 0, depth_key(format, double(stored[x % 5])));
        const float low = depth_from_key(format, depth_key(format, 0.25)),
                    high = depth_from_key(format, depth_key(format, 0.75));
        PipelineState state;
        state.depth = {.test = Compare::Never, .bounds = DepthState::Bounds{low, high}};
        state.stencil.enabled = true;
        state.stencil.front = state.stencil.back = {.depth_fail = count}; // of what passes the bounds
        const std::vector<vec4> positions = {{-1, -1, -1, 1}, {3, -1, 1, 1}, {-1, 3, 1, 1}};
        const std::vector<uvec3> triangle = {{0, 1, 2}};
        PassLog log;
        Pass pass(log, "bounds");
        draw(
            pass, {3, triangle}, state, [&](std::uint32_t i) { return positions[i]; }, depth_only,
            Targets{.depth = &depth, .stencil = &stencil});
        for (int x = 0; x < 8; ++x) {
            INFO(info(format).name << ", stored " << stored[x % 5]);
            CHECK(stencil.load_key(x, 3) == (x % 5 >= 1 && x % 5 <= 3 ? 1u : 0u));
        }
    }
}
