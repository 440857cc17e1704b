#pragma once
// The full-screen pass: a program run once for every pixel of its targets, the deferred pass that most techniques end
// in.

#include <array>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "raster/blend.h"
#include "raster/target.h"

namespace gnomon {

struct Pixel {
    int x, y;
    PassCounters& counters; // samplers count their texels here
    std::array<vec4, max_color_targets> color{};
    bool discarded = false;
};

namespace detail {
inline constexpr size_t full_screen_rows = 4; // rows of one task

// Runs body(y, counters) for all rows in parallel and adds the counters up in order.
template <class Body> void for_each_row(Pass& pass, int height, const Body& body) {
    std::vector<PassCounters> counters(chunk_count(static_cast<size_t>(height), full_screen_rows));
    parallel_for(static_cast<size_t>(height), full_screen_rows, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y) body(static_cast<int>(y), counters[begin / full_screen_rows]);
    });
    for (const PassCounters& c : counters) pass.counters().add(c);
    ++pass.counters().draws;
}

void write_pixel(const Targets& targets, const BlendState& blend, const Pixel& pixel);
} // namespace detail

// program(Pixel&) for every pixel of the targets' layer and level (all of one size); what it leaves in pixel.color is
// blended and stored.
template <class Program>
void full_screen(Pass& pass, const Targets& targets, const Program& program, const BlendState& blend = {}) {
    const Target& first = *targets.color.at(0);
    const int width = first.width(targets.level);
    detail::for_each_row(pass, first.height(targets.level), [&](int y, PassCounters& counters) {
        for (int x = 0; x < width; ++x) {
            Pixel pixel{x, y, counters};
            program(pixel);
            ++counters.fragments_covered;
            ++counters.fragments_shaded;
            if (pixel.discarded) continue;
            ++counters.fragments_passed;
            detail::write_pixel(targets, blend, pixel);
        }
    });
}

// The same into one float per pixel: program(Pixel&) -> float.
template <class Program> void full_screen(Pass& pass, Image<float>& target, const Program& program) {
    detail::for_each_row(pass, target.height(), [&](int y, PassCounters& counters) {
        for (int x = 0; x < target.width(); ++x) {
            Pixel pixel{x, y, counters};
            target(x, y) = program(pixel);
        }
        counters.fragments_covered += target.width();
        counters.fragments_passed += target.width();
        counters.fragments_shaded += target.width();
        counters.bytes_written += target.width() * static_cast<std::int64_t>(sizeof(float));
    });
}

} // namespace gnomon
