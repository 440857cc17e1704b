// gnomon-conformance: holds the rasterizer against another one that nobody here wrote, Mesa's llvmpipe, or with --gpu
// against whatever device EGL offers. Exits with 0 where every bound holds, 1 where one does not, 77 where there is
// nothing to compare with.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "tests/conformance/check.h"
#include "tests/gl/context.h"

namespace gnomon_conformance {
namespace {

struct Check {
    const char* name;
    bool (*run)(const Options&);
    const char* what;
};
constexpr Check checks[] = {
    {"coverage", check_coverage, "10^6 random triangles: the same pixels in the same order"},
    {"stencil", check_stencil, "two-sided stencil under constant depth: the same counts"},
    {"meshes", check_meshes, "real meshes under random cameras: the same pixels but for rounded vertices"},
    {"clipping", check_clipping, "triangles across the near plane and far off screen"},
    {"depth", check_depth, "distance of depth from the exact plane, ours and theirs"},
    {"volumes", check_volumes, "stencil volumes over interpolated depth, nothing clipped"},
    {"exact-volumes", check_exact_volumes, "volumes that reach to infinity: wherever the two differ, ours is right"},
    {"infinite-volumes", check_infinite_volumes, "and the two differ at one pixel in 10^4"},
    {"states", check_states, "depth functions, clamp, polygon offset, scissor, viewport, culling, masks"},
    {"blending", check_blending, "factors and operations on normalised, half and float targets"},
    {"lines", check_lines, "lines as quads: the pixels of OpenGL's lines but for those at the ends"},
    {"multisampling", check_multisampling, "4 and 8 samples: the same triangle in every sample, and their mean"},
};

int usage() {
    fmt::print(stderr, "usage: gnomon-conformance [--gpu] [--soak FACTOR] [--seed N] [CHECK...]\nchecks:\n");
    for (const Check& check : checks) fmt::print(stderr, "  {:<17} {}\n", check.name, check.what);
    return 2;
}

const Check* find(const char* name) {
    for (const Check& check : checks)
        if (std::strcmp(check.name, name) == 0) return &check;
    return nullptr;
}

} // namespace
} // namespace gnomon_conformance

int main(int argc, char** argv) try {
    using namespace gnomon_conformance;
    gnomon_gl::ContextOptions context_options;
    Options options;
    std::vector<const Check*> chosen;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--gpu")
            context_options.hardware = true;
        else if (argument == "--soak" && i + 1 < argc)
            options.soak = std::atof(argv[++i]);
        else if (argument == "--seed" && i + 1 < argc)
            options.seed = static_cast<std::uint32_t>(std::strtoul(argv[++i], nullptr, 10));
        else if (const Check* check = find(argv[i]))
            chosen.push_back(check);
        else
            return usage();
    }
    if (chosen.empty())
        for (const Check& check : checks) chosen.push_back(&check);

    std::string reason;
    const auto context = gnomon_gl::Context::open(context_options, reason);
    if (!context) {
        fmt::print("skipped: {}\n", reason);
        return 77;
    }
    fmt::print("compared with {}; seed {}, soak {}\n", context->description(), options.seed, options.soak);
    bool all = true;
    for (const Check* check : chosen) {
        const auto start = std::chrono::steady_clock::now();
        const bool held = check->run(options);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        fmt::print("{} {} ({:.1f} s)\n", held ? "ok    " : "FAILED", check->name, seconds.count());
        std::fflush(stdout);
        all &= held;
    }
    return all ? 0 : 1;
} catch (const std::exception& error) {
    fmt::print(stderr, "gnomon-conformance: {}\n", error.what());
    return 1;
}
