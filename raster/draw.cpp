#include "raster/draw.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/error.h"
#include "raster/tile.h"

namespace gnomon::detail {
namespace {

constexpr size_t vertex_grain = 8192;
constexpr size_t chunk_triangles = 2048;  // one set-up task
constexpr size_t batch_triangles = 65536; // set up, then drawn, before the next: bounds the memory of the bins

Rectangle intersect(const Rectangle& a, const Rectangle& b) {
    const int x0 = std::max(a.x, b.x), y0 = std::max(a.y, b.y);
    const int x1 = std::min(a.x + a.width, b.x + b.width), y1 = std::min(a.y + a.height, b.y + b.height);
    return {x0, y0, std::max(0, x1 - x0), std::max(0, y1 - y0)};
}

// The common size of all targets.
ivec2 target_size(const Targets& targets) {
    ivec2 size(0);
    sample_positions(targets.samples); // throws for an impossible number
    const auto take = [&](const Target* target) {
        if (!target) return;
        if (targets.level < 0 || targets.level >= target->levels())
            throw UsageError(fmt::format("a target of {} levels has no level {}", target->levels(), targets.level));
        const ivec2 mine(target->width(targets.level), target->height(targets.level));
        if (size != ivec2(0) && size != mine)
            throw UsageError(
                fmt::format("the targets of a draw differ in size: {}x{} and {}x{}", size.x, size.y, mine.x, mine.y));
        const int layers = target->layers() / targets.samples;
        if (targets.layer < 0 || targets.layer >= layers)
            throw UsageError(fmt::format("a target of {} layers has no layer {}", layers, targets.layer));
        size = mine;
    };
    take(targets.depth);
    take(targets.stencil);
    for (const Target* color : targets.color) take(color);
    if (size == ivec2(0)) throw UsageError("a draw needs at least one target");
    if (targets.color.size() > max_color_targets)
        throw UsageError(fmt::format("a draw has at most {} colour targets", max_color_targets));
    return size;
}

SetupState setup_state(const Draw& draw, const PipelineState& state, const Targets& targets) {
    const ivec2 size = target_size(targets);
    const Rectangle whole = {0, 0, size.x, size.y};
    SetupState setup;
    setup.viewport = state.viewport.value_or(whole);
    setup.drawable = intersect(whole, setup.viewport);
    if (state.scissor) setup.drawable = intersect(setup.drawable, *state.scissor);
    setup.cull = state.cull;
    setup.front_face = state.front_face;
    setup.clip_depth = state.clip_depth;
    setup.depth_clamp = state.depth.clamp;
    setup.polygon_offset = state.polygon_offset;
    setup.depth_format = targets.depth ? targets.depth->format() : Format::D32F;
    setup.attributes = draw.varying_count > 0;
    setup.conservative = state.conservative;
    setup.multisampled = targets.samples > 1;
    return setup;
}

// One task's set-up triangles, and for each tile the list of those that may touch it, in order of submission.
struct Chunk {
    std::vector<SetupTriangle> triangles;
    std::vector<AttributePlanes> attributes;
    std::vector<std::uint32_t> tile_begin; // tiles + 1 offsets into tile_triangles
    std::vector<std::uint32_t> tile_triangles;
    SetupCounts counts;
};

struct Grid {
    int x0, y0, columns, rows; // tiles; tile (0, 0) starts at pixel (0, 0)
    bool multisampled;
    size_t count() const { return static_cast<size_t>(columns) * static_cast<size_t>(rows); }
};

// Whether the triangle's edges leave any sample of the tile inside: the corner most inside decides for each edge.
// Samples lie within half a pixel of the centres.
bool touches(const SetupTriangle& t, int tile_x, int tile_y, bool multisampled) {
    const std::int64_t left = tile_x * tile_side * 256 + 128, bottom = tile_y * tile_side * 256 + 128;
    constexpr std::int64_t span = (tile_side - 1) * 256;
    for (int e = 0; e < 3; ++e) {
        const std::int64_t x = t.a[e] > 0 ? left + span : left, y = t.b[e] > 0 ? bottom + span : bottom;
        const std::int64_t beyond_center = multisampled ? 128 * (std::abs(t.a[e]) + std::abs(t.b[e])) : 0;
        if (t.a[e] * x + t.b[e] * y + t.c[e] + beyond_center < 0) return false;
    }
    return true;
}

template <class Visit> void for_each_tile(const SetupTriangle& t, const Grid& grid, const Visit& visit) {
    // Boxes lie inside the target, so the shifts are divisions.
    const int x0 = t.x0 >> tile_shift, x1 = t.x1 >> tile_shift, y0 = t.y0 >> tile_shift, y1 = t.y1 >> tile_shift;
    const bool single = x0 == x1 && y0 == y1;
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x)
            if (single || touches(t, x, y, grid.multisampled))
                visit(static_cast<size_t>(y - grid.y0) * static_cast<size_t>(grid.columns) +
                      static_cast<size_t>(x - grid.x0));
}

void bin(Chunk& chunk, const Grid& grid) {
    // Counting sort by tile, in two passes over the triangles.
    chunk.tile_begin.assign(grid.count() + 1, 0);
    for (const SetupTriangle& t : chunk.triangles)
        for_each_tile(t, grid, [&](size_t tile) { ++chunk.tile_begin[tile + 1]; });
    for (size_t i = 1; i < chunk.tile_begin.size(); ++i) chunk.tile_begin[i] += chunk.tile_begin[i - 1];
    chunk.tile_triangles.resize(chunk.tile_begin.back());
    std::vector<std::uint32_t> next(chunk.tile_begin.begin(), chunk.tile_begin.end() - 1);
    for (std::uint32_t i = 0; i < chunk.triangles.size(); ++i)
        for_each_tile(chunk.triangles[i], grid, [&](size_t tile) { chunk.tile_triangles[next[tile]++] = i; });
}

// All of the fragment and byte counters, summed over tiles in order.
void draw_batch(const TileDraw& tile_draw, const std::vector<Chunk>& chunks, size_t chunk_count_, const Grid& grid,
                PassCounters& counters) {
    std::vector<PassCounters> tile_counters(grid.count());
    parallel_for(grid.count(), 1, [&](size_t tile, size_t) {
        const int x = (grid.x0 + static_cast<int>(tile) % grid.columns) * tile_side;
        const int y = (grid.y0 + static_cast<int>(tile) / grid.columns) * tile_side;
        for (size_t c = 0; c < chunk_count_; ++c) {
            const Chunk& chunk = chunks[c];
            for (std::uint32_t k = chunk.tile_begin[tile]; k < chunk.tile_begin[tile + 1]; ++k) {
                const std::uint32_t i = chunk.tile_triangles[k];
                draw_in_tile(tile_draw, chunk.triangles[i], chunk.attributes.empty() ? nullptr : &chunk.attributes[i],
                             x, y, tile_counters[tile]);
            }
        }
    });
    for (const PassCounters& c : tile_counters) counters.add(c);
}

} // namespace

void execute(Pass& pass, const Draw& draw, const PipelineState& state, const Targets& targets) {
    const SetupState setup = setup_state(draw, state, targets);
    PassCounters& counters = pass.counters();
    const std::span<const uvec3> triangles = draw.geometry.triangles;
    ++counters.draws;
    counters.vertices += draw.geometry.vertex_count;
    counters.triangles += static_cast<std::int64_t>(triangles.size());

    const auto positions = std::make_unique_for_overwrite<vec4[]>(draw.geometry.vertex_count);
    const auto varyings =
        std::make_unique_for_overwrite<float[]>(static_cast<size_t>(draw.varying_count) * draw.geometry.vertex_count);
    const auto window = std::make_unique_for_overwrite<WindowVertex[]>(draw.geometry.vertex_count);
    parallel_for(draw.geometry.vertex_count, vertex_grain, [&](size_t begin, size_t end) {
        draw.vertices(static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end), positions.get(),
                      varyings.get());
        for (size_t i = begin; i < end; ++i) window[i] = to_window(setup, positions[i]);
    });
    if (setup.drawable.width == 0 || setup.drawable.height == 0) {
        counters.culled += static_cast<std::int64_t>(triangles.size());
        return;
    }

    const Rectangle& d = setup.drawable;
    const int tx0 = d.x / tile_side, ty0 = d.y / tile_side;
    const Grid grid = {tx0, ty0, (d.x + d.width - 1) / tile_side - tx0 + 1, (d.y + d.height - 1) / tile_side - ty0 + 1,
                       setup.multisampled};
    const TileDraw tile_draw = {&draw, &state, &targets, varyings.get(), &kernels()};
    std::vector<Chunk> chunks(chunk_count(std::min(triangles.size(), batch_triangles), chunk_triangles));
    for (size_t first = 0; first < triangles.size(); first += batch_triangles) {
        const size_t count = std::min(batch_triangles, triangles.size() - first);
        parallel_for(count, chunk_triangles, [&](size_t begin, size_t end) {
            Chunk& chunk = chunks[begin / chunk_triangles];
            chunk.triangles.clear();
            chunk.attributes.clear();
            for (size_t i = first + begin; i < first + end; ++i)
                set_up_triangle(setup, positions.get(), window.get(), triangles[i], static_cast<std::uint32_t>(i),
                                chunk.triangles, chunk.attributes, chunk.counts);
            bin(chunk, grid);
        });
        draw_batch(tile_draw, chunks, chunk_count(count, chunk_triangles), grid, counters);
    }
    for (const Chunk& chunk : chunks) {
        counters.clipped += chunk.counts.clipped;
        counters.culled += chunk.counts.culled;
    }
}

} // namespace gnomon::detail
