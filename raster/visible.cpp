#include "raster/visible.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include <hwy/cache_control.h>

#include "raster/block_tests.h"
#include "raster/shading_kernels.h"

namespace gnomon::detail {
namespace {

// The runs of a block: [first, first + count) of its strip's.
struct VisibleBlock {
    std::uint64_t pixels;
    size_t first, count;
    std::array<std::uint8_t, block_pixels> run; // counted from `first`
};

// A row of blocks of a tile, and the triangles that are visible there.
struct Strip {
    static constexpr size_t most_runs = tile_blocks * block_pixels;
    std::array<VisibleBlock, tile_blocks> blocks;
    size_t count; // runs
    std::array<std::uint32_t, most_runs> ids;
    std::array<std::uint64_t, most_runs> masks;
    std::array<FragmentRun, most_runs> runs;
    PlaneInputs inputs;
    std::array<AttributePlanes, PlaneInputs::capacity> planes;
};

// A strip's rows of texels, for targets that take colours as they are and start as cleared.
struct ColorRows {
    int y;
    alignas(64) std::array<std::array<std::array<vec4, tile_side>, block_side>, max_color_targets> texels;
};

// The targets that go by rows, and rows that wait: they are written between the blocks of the next strip, because one
// core cannot write as fast as it shades in between.
struct RowWriter {
    const Targets* targets;
    int x;
    std::array<bool, max_color_targets> used{};
    alignas(64) std::array<vec4, tile_side> cleared;
    std::array<ColorRows, 2> rows;
    ColorRows* waiting = nullptr;

    ColorRows& next(int y) {
        ColorRows& free = waiting == rows.data() ? rows[1] : rows[0];
        free.y = y;
        return free;
    }
    // One row of all targets, as far as they go; `row(c)` gives its texels.
    template <class Row> void write(int y, const Row& row) const {
        for (size_t c = 0; c < targets->color.size(); ++c) {
            if (!used[c]) continue;
            Target& target = *targets->color[c];
            if (y >= target.height(targets->level)) continue;
            const int columns = std::min(tile_side, target.width(targets->level) - x);
            const auto bytes = static_cast<size_t>(columns) * sizeof(vec4);
            std::byte* to = target.texel(x, y, targets->layer, targets->level);
            if (is_streamed(target) && (reinterpret_cast<std::uintptr_t>(to) | bytes) % 64 == 0)
                shading_kernels().stream(row(c), to, bytes);
            else
                std::memcpy(to, row(c), bytes);
        }
    }
    void write_waiting(size_t j) const {
        if (waiting) write(waiting->y + static_cast<int>(j), [&](size_t c) { return waiting->texels[c][j].data(); });
    }
};

// A block's words row by row.
template <class From, class To> void copy_block(const From* from, int x, int y, To* to) {
    static_assert(sizeof(From) == sizeof(To));
    from += place_in_tile(x, y);
    for (int j = 0; j < block_side; ++j)
        for (int i = 0; i < block_side; i += patch_side)
            std::memcpy(to + block_side * j + i, from + place_in_block(i, j), patch_side * sizeof(To));
}

const SetupTriangles& chunk_of(std::span<const TileList> lists, std::uint32_t id) {
    return *lists[id / most_triangles_of_a_list].triangles;
}
const SetupTriangle* triangle_of(std::span<const TileList> lists, std::uint32_t id) {
    return chunk_of(lists, id).data.get() + id % most_triangles_of_a_list;
}

void find_runs(const TileDraw& draw, const DepthTile& tile, int y, std::span<const TileList> lists, Strip& strip) {
    strip.count = 0;
    for (int b = 0; b < tile_blocks; ++b) {
        VisibleBlock& block = strip.blocks[static_cast<size_t>(b)];
        block.first = strip.count;
        block.count = shading_kernels().find_runs(tile.id + place_in_tile(block_side * b, y), DepthTile::no_id,
                                                  strip.ids.data() + strip.count, strip.masks.data() + strip.count,
                                                  block.run.data());
        block.pixels = 0;
        strip.count += block.count;
        for (size_t k = block.first; k < strip.count; ++k) {
            block.pixels |= strip.masks[k];
            const SetupTriangle* triangle = triangle_of(lists, strip.ids[k]);
            strip.runs[k] = {triangle, nullptr, {}, strip.masks[k]};
            hwy::Prefetch(triangle);
            hwy::Prefetch(&triangle->piece);
        }
    }
    for (size_t k = 0; k < strip.count; ++k)
        hwy::Prefetch(&draw.draw->geometry.triangles[strip.runs[k].triangle->primitive]);
}

// Finds the corners of all runs and makes their planes, those of a triangle that is met twice mostly once.
void set_up_varyings(const TileDraw& draw, std::span<const TileList> lists, Strip& strip) {
    for (size_t k = 0; k < strip.count; ++k) {
        FragmentRun& run = strip.runs[k];
        const uvec3 corner = draw.draw->geometry.triangles[run.triangle->primitive];
        const auto set = [&](size_t c, std::uint32_t vertex) {
            run.corners[c] = varyings_of(draw, vertex);
            hwy::Prefetch(run.corners[c]);
            hwy::Prefetch(draw.positions + vertex);
        };
        set(0, corner.x), set(1, corner.y), set(2, corner.z);
    }
    constexpr size_t table_size = 256;
    std::array<std::uint16_t, table_size> table{}; // by id: which planes
    std::array<std::uint32_t, PlaneInputs::capacity> owner;
    size_t count = 0;
    for (size_t k = 0; k < strip.count; ++k) {
        FragmentRun& run = strip.runs[k];
        const std::uint32_t id = strip.ids[k];
        std::uint16_t& entry = table[id % table_size];
        if (entry >= count || owner[entry] != id) {
            entry = static_cast<std::uint16_t>(count++);
            owner[entry] = id;
            const uvec3 corner = draw.draw->geometry.triangles[run.triangle->primitive];
            strip.inputs.set(entry, *run.triangle,
                             {draw.positions[corner.x].w, draw.positions[corner.y].w, draw.positions[corner.z].w});
            strip.planes[entry].anchor_x = run.triangle->anchor_x();
            strip.planes[entry].anchor_y = run.triangle->anchor_y();
        }
        run.planes = &strip.planes[entry];
    }
    shading_kernels().planes(strip.inputs, count, strip.planes.data());
    for (size_t k = 0; k < count; ++k) {
        const SetupTriangle& triangle = *triangle_of(lists, owner[k]);
        if (draw.draw->linear_varyings || triangle.piece != SetupTriangle::whole)
            strip.planes[k] = attribute_planes(draw, triangle, chunk_of(lists, owner[k]).pieces.data());
    }
}

void set_inputs(const TileDraw& draw, const DepthTile& tile, FragmentBlock& block, std::span<const FragmentRun> runs) {
    if (draw.draw->varying_count > 0) {
        constexpr size_t few = 6;
        const auto count = static_cast<size_t>(draw.draw->varying_count);
        if (runs.size() > few) {
            shading_kernels().interpolate(block, count);
        } else {
            shading_kernels().barycentrics(block, runs.size());
            for (const FragmentRun& run : runs)
                draw.kernels->varyings(run.corners[0], run.corners[1], run.corners[2], count, run.mask,
                                       block.second.data(), block.third.data(), block.varyings.front().data());
        }
    }
    if (draw.state->depth.write && draw.targets->depth->format() == Format::D32F) { // the keys of what is visible
        copy_block(tile.depth, block.x - tile.x, block.y - tile.y, block.depth.data());
        return;
    }
    for (const FragmentRun& run : runs) {
        Depths depth;
        draw.kernels->depth(*run.triangle, block.x, block.y, run.mask, depth.data());
        set_depth(run, block, depth);
    }
}

// Runs the program for one block of the strip.
void shade_block(const TileDraw& draw, const DepthTile& tile, const Strip& strip, const VisibleBlock& visible,
                 FragmentBlock& block) {
    const std::span<const FragmentRun> runs = std::span(strip.runs).subspan(visible.first, visible.count);
    block.runs = runs.data();
    block.run = visible.run;
    block.mask = visible.pixels;
    set_inputs(draw, tile, block, runs);
    draw.draw->fragments(block);
}

// What a block gives to the colour targets; those that go by rows get a colour for all of its pixels.
void write_block(const TileDraw& draw, const RowWriter& writer, const FragmentBlock& block, std::uint64_t visible,
                 ColorRows& rows) {
    const Targets& targets = *draw.targets;
    for (size_t c = 0; c < targets.color.size(); ++c)
        if (writer.used[c])
            shading_kernels().interleave(block.color[c].data(),
                                         &rows.texels[c][0][static_cast<size_t>(block.x - writer.x)], tile_side);
        else if (visible)
            write_color(draw, c, block.x, block.y, targets.layer, visible, block.color[c]);
}

// What becomes of the colour targets' load operations: rows, or a fill of the tile right now.
void start_colors(const TileDraw& draw, const DepthTile& tile, bool clear, RowWriter& writer) {
    const Targets& targets = *draw.targets;
    writer.targets = &targets;
    writer.x = tile.x;
    if (!clear) return;
    writer.cleared.fill(*targets.clear_color);
    for (size_t c = 0; c < targets.color.size(); ++c) {
        Target* target = targets.color[c];
        if (!target) continue;
        writer.used[c] = target->format() == Format::RGBA32F && draw.state->color_mask[c] == 15;
        if (writer.used[c]) continue;
        const TilePart part = part_of_tile(*target, targets.level, tile.x, tile.y);
        target->fill(tile.x, tile.y, part.columns, part.rows, targets.layer, targets.level,
                     target->cleared(*targets.clear_color));
    }
}

// Gives the pixels of a block that its program does not run for their clear colour.
void clear_rest(const RowWriter& writer, FragmentBlock& block) {
    const vec4 color = writer.cleared.front();
    for (size_t c = 0; c < max_color_targets; ++c)
        for (glm::length_t k = 0; k < 4 && writer.used[c]; ++k) block.color[c][static_cast<size_t>(k)].fill(color[k]);
}

} // namespace

void shade_visible(const TileDraw& draw, const DepthTile& tile, bool clear, std::span<const TileList> lists,
                   PassCounters& counters) {
    static_assert(tile_blocks == block_side, "a row waits for each block");
    Strip strip;
    RowWriter writer;
    FragmentBlock block;
    block.counters = &counters;
    start_colors(draw, tile, clear, writer);
    for (int y = 0; y < tile_side; y += block_side) {
        block.y = tile.y + y;
        find_runs(draw, tile, y, lists, strip);
        if (strip.count == 0) {
            for (int j = 0; j < block_side; ++j)
                writer.write(block.y + j, [&](size_t) { return writer.cleared.data(); });
            continue;
        }
        if (draw.draw->varying_count > 0) set_up_varyings(draw, lists, strip);
        ColorRows& rows = writer.next(block.y);
        for (size_t b = 0; b < tile_blocks; ++b) {
            const VisibleBlock& visible = strip.blocks[b];
            block.x = tile.x + static_cast<int>(b) * block_side;
            if (visible.pixels != ~std::uint64_t{0}) clear_rest(writer, block);
            if (visible.pixels) shade_block(draw, tile, strip, visible, block);
            write_block(draw, writer, block, visible.pixels, rows);
            writer.write_waiting(b);
        }
        writer.waiting = &rows;
    }
    for (size_t j = 0; j < block_side; ++j) writer.write_waiting(j);
}

} // namespace gnomon::detail
