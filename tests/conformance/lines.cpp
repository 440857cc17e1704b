// Lines: the quads of wide_line against OpenGL's lines, one pixel wide, each in a cell of its own. Between the ends
// both draw, in each column of a line that is nearer to x, the pixel that it crosses; at the ends OpenGL asks whether
// the line leaves a pixel's diamond, and a quad whether it covers the centre, so a column of an end may differ.

#include <cmath>

#include <fmt/format.h>

#include "raster/geometry.h"
#include "tests/conformance/triangles.h"

namespace gnomon_conformance {
namespace {

constexpr int cell = 32, cells_across = 16, side = cell * cells_across;

struct Line {
    dvec2 a, b; // pixels, multiples of 1/256

    glm::length_t major() const { return std::abs(b.x - a.x) >= std::abs(b.y - a.y) ? 0 : 1; }
    // Whether the pixel is in a column (a row of a line that is nearer to y) strictly between those of the ends.
    bool between_ends(ivec2 pixel) const {
        const int first = static_cast<int>(std::min(a[major()], b[major()])),
                  last = static_cast<int>(std::max(a[major()], b[major()]));
        return first < pixel[major()] && pixel[major()] < last;
    }
    // Where the line crosses the middle of the pixel's column.
    double crossing(ivec2 pixel) const {
        const glm::length_t along = major(), across = 1 - along;
        return a[across] + (b[across] - a[across]) * (pixel[along] + 0.5 - a[along]) / (b[along] - a[along]);
    }
};

vec4 to_clip(dvec2 window) {
    const Rectangle v = wide_viewport(side, side);
    return vec4(dvec4((window - dvec2(v.x, v.y)) / dvec2(v.width, v.height) * 2.0 - 1.0, 0, 1));
}

std::vector<Line> random_lines(Random& random) {
    std::vector<Line> lines;
    for (int i = 0; i < cells_across * cells_across; ++i) {
        const dvec2 corner(cell * (i % cells_across), cell * (i / cells_across));
        const auto end = [&] {
            return corner +
                   dvec2(random.between(2 * 256, (cell - 2) * 256), random.between(2 * 256, (cell - 2) * 256)) / 256.0;
        };
        const dvec2 a = end();
        lines.push_back({a, end()});
    }
    return lines;
}

Batch quads_of(const std::vector<Line>& lines) {
    Batch batch;
    const Rectangle viewport = wide_viewport(side, side);
    for (const Line& line : lines) {
        const auto wide = wide_line(to_clip(line.a), to_clip(line.b), 1.0f, {viewport.width, viewport.height});
        batch.positions.insert(batch.positions.end(), wide->corners.begin(), wide->corners.end());
    }
    batch.triangles = triangles_of_quads(sequence(static_cast<std::uint32_t>(batch.positions.size())));
    return batch;
}

} // namespace

bool check_lines(const Options& options) {
    Verdict verdict("lines");
    Random random(options.seed + 9);
    Duel duel({.width = side, .height = side});
    PipelineState state = counting_state();
    state.viewport = wide_viewport(side, side);
    std::int64_t between = 0, wrong = 0, differ = 0, explained = 0, at_ends = 0;
    for (int i = 0; i < options.repeat(20); ++i) {
        const std::vector<Line> lines = random_lines(random);
        std::vector<vec4> ends;
        for (const Line& line : lines) ends.push_back(to_clip(line.a)), ends.push_back(to_clip(line.b));
        duel.clear();
        duel.draw_lines(ends, quads_of(lines), state);
        const Picture ours = duel.ours(), theirs = duel.witness();
        for (size_t k = 0; k < duel.pixels(); ++k) {
            const ivec2 pixel(static_cast<int>(k % side), static_cast<int>(k / side));
            const Line& line = lines[static_cast<size_t>(pixel.y / cell * cells_across + pixel.x / cell)];
            const bool same = ours.stencil[k] == theirs.stencil[k];
            if (!line.between_ends(pixel)) {
                at_ends += !same;
                continue;
            }
            const double crossing = line.crossing(pixel), across = pixel[1 - line.major()];
            if (crossing == std::round(crossing)) continue; // between two pixels: OpenGL leaves it open
            between += ours.stencil[k] != 0;
            wrong += ours.stencil[k] != (std::floor(crossing) == across ? 1u : 0u);
            differ += !same;
            explained += !same && std::abs(crossing - std::round(crossing)) < 1.0 / 256;
        }
    }
    verdict.figure(fmt::format("{} pixels of the ends differ", at_ends));
    verdict.require(wrong == 0 && differ == explained && between > 0,
                    fmt::format("{} pixels between the ends: ours wrong at {}; the two differ at {}, of which {} are "
                                "within a sub-pixel step of a tie",
                                between, wrong, differ, explained));
    return verdict.held();
}

} // namespace gnomon_conformance
