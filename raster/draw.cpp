#include "raster/draw.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdlib>
#include <thread>

#include <emmintrin.h>
#include <fmt/format.h>

#include "core/error.h"
#include "core/image.h"
#include "core/large_memory.h"
#include "raster/bins.h"
#include "raster/fast_tile.h"
#include "raster/setup_kernels.h"
#include "raster/tile.h"

namespace gnomon::detail {
namespace {

constexpr size_t vertex_grain = 1024;
// A batch of triangles is set up, then drawn, before the next: that bounds the memory of the bins. A large batch loads
// and stores tiles less often, a small one stays in the caches.
constexpr size_t batch_chunks = 64; // set-up tasks of a batch
constexpr size_t least_chunk_triangles = 2048, most_chunk_triangles = 16384;
constexpr size_t batch_triangles_per_tile = 1024;
// What fits into few chunks is shared among so many, or as many of the least size, so that threads get equal parts.
constexpr size_t even_chunks = 8, least_even_chunk_triangles = 1024;
static_assert(least_chunk_triangles * most_clipped_pieces <= Chunk::most_triangles);
constexpr size_t least_tile_tasks = 16;
constexpr size_t most_vertices = size_t{1} << 29;

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
    const Rectangle& v = setup.viewport;
    if (v.width < 0 || v.height < 0 || std::max(v.width, v.height) > max_image_side ||
        std::max(std::abs(v.x), std::abs(v.y)) > max_image_side)
        throw UsageError(fmt::format("a viewport of {}x{} at ({}, {}) is not possible; sides and offsets go up to {}",
                                     v.width, v.height, v.x, v.y, max_image_side));
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

} // namespace

// Memory that grows to what a draw needs and stays for the next.
struct DrawScratch {
    template <class T> class Buffer {
    public:
        T* room_for(size_t count) {
            if (count > data_.size()) {
                data_ = {};
                data_.resize(count);
            }
            return data_.data();
        }

    private:
        std::vector<T, LargeAllocator<T>> data_; // uninitialized
    };
    Buffer<vec4> positions;
    Buffer<float> varyings;
    Buffer<WindowVertex> window;
    std::vector<Chunk> chunks;
};

namespace {

void run_vertices(const Draw& draw, const SetupState& setup, vec4* positions, float* varyings, WindowVertex* window) {
    parallel_for(draw.geometry.vertex_count, vertex_grain, [&](size_t begin, size_t end) {
        draw.vertices(static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end), positions, varyings);
        setup_kernels().to_window(setup, positions + begin, end - begin, window + begin);
    });
}

// Clears what the targets ask for, outside the fast path.
void clear_targets(const Targets& targets) {
    const auto clear = [&](Target* target, const std::array<std::byte, 16>& texel) {
        const int width = target->width(targets.level), height = target->height(targets.level);
        for (int s = 0; s < targets.samples; ++s)
            parallel_for(static_cast<size_t>(height), 64, [&](size_t begin, size_t end) {
                target->fill(0, static_cast<int>(begin), width, static_cast<int>(end - begin),
                             targets.layer * targets.samples + s, targets.level, texel);
                _mm_sfence();
            });
    };
    if (targets.depth && targets.clear_depth) clear(targets.depth, targets.depth->cleared_depth(*targets.clear_depth));
    if (targets.stencil && targets.clear_stencil)
        clear(targets.stencil, targets.stencil->cleared_uint(*targets.clear_stencil));
    if (!targets.clear_color) return;
    for (Target* target : targets.color)
        if (target) clear(target, target->cleared(*targets.clear_color));
}

std::int64_t cleared_bytes(const Targets& targets) {
    std::int64_t bytes = 0;
    const auto add = [&](const Target* target, bool cleared) {
        if (!target || !cleared) return;
        bytes += std::int64_t{target->width(targets.level)} * target->height(targets.level) * target->texel_bytes() *
                 targets.samples;
    };
    add(targets.depth, targets.clear_depth.has_value());
    add(targets.stencil, targets.clear_stencil.has_value());
    for (const Target* target : targets.color) add(target, targets.clear_color.has_value());
    return bytes;
}

// How many triangles a set-up task takes; the last may get fewer.
size_t triangles_of_a_chunk(size_t triangles, const TileGrid& drawable) {
    const size_t most = std::clamp(batch_triangles_per_tile * drawable.count() / batch_chunks, least_chunk_triangles,
                                   most_chunk_triangles);
    return std::min(most, std::max(chunk_count(triangles, even_chunks), least_even_chunk_triangles));
}

// A tile's lists, one for each chunk that has triangles for it.
struct TileLists {
    std::vector<TileList> lists;
    std::vector<std::uint16_t> merged;

    void make(const TileGrid& grid, std::span<const Chunk> chunks, const TileWork& work) {
        lists.clear();
        merged.clear();
        size_t most_merged = 0;
        for (std::uint64_t rest = work.chunks; rest; rest &= rest - 1)
            most_merged += chunks[static_cast<size_t>(std::countr_zero(rest))].most_merged();
        merged.reserve(most_merged);
        const int x = grid.tile_x(work.tile), y = grid.tile_y(work.tile);
        for (std::uint64_t rest = work.chunks; rest; rest &= rest - 1) {
            const Chunk& chunk = chunks[static_cast<size_t>(std::countr_zero(rest))];
            lists.push_back({&chunk.triangles, chunk.list(x, y, merged)});
        }
    }
};

// Asked once, since the answer comes from the file system.
unsigned machine_threads() {
    static const unsigned threads = std::max(1u, std::thread::hardware_concurrency());
    return threads;
}

// Work that threads take from both ends, so that of two each stays among neighbours, which share triangles and which
// memory likes to be written together: much while much is left, in the end little, so that all threads end together.
class SharedWork {
public:
    explicit SharedWork(std::span<const TileWork> work)
        : work_(work), left_{{0, static_cast<std::uint32_t>(work.size())}} {}

    size_t taker() { return takers_++; }
    std::span<const TileWork> take(size_t taker) { // none where all is taken
        Range left = left_;
        for (;;) {
            if (left.begin == left.end) return {};
            const std::uint32_t count = std::max((left.end - left.begin) / (8 * machine_threads()), 1u);
            const bool front = taker % 2 == 0;
            const Range rest = {left.begin + (front ? count : 0), left.end - (front ? 0 : count)};
            if (left_.compare_exchange_weak(left, rest)) return work_.subspan(front ? left.begin : rest.end, count);
        }
    }

private:
    struct Range {
        std::uint32_t begin, end;
    };
    std::span<const TileWork> work_;
    std::atomic<Range> left_;
    std::atomic<size_t> takers_ = 0;
};

// The tiles of a batch, on the fast path. Few more tasks than threads carry on from tile to tile.
void draw_fast_tiles(const TileDraw& tile_draw, const ListState& state, bool load, const TileGrid& grid,
                     std::span<const Chunk> chunks, std::span<const TileWork> work, PassCounters& counters) {
    const size_t tasks = std::max<size_t>(machine_threads(), least_tile_tasks);
    std::vector<PassCounters> task_counters(std::min(work.size(), tasks));
    SharedWork shared(work);
    parallel_for(task_counters.size(), 1, [&](size_t task, size_t) {
        FastTiles tiles(tile_draw, state, load);
        TileLists lists;
        PassCounters own; // apart from those of other threads
        const size_t taker = shared.taker();
        for (auto taken = shared.take(taker); !taken.empty(); taken = shared.take(taker))
            for (const TileWork& tile : taken) {
                lists.make(grid, chunks, tile);
                tiles.draw(grid.pixel_x(tile.tile), grid.pixel_y(tile.tile), lists.lists, own);
            }
        tiles.finish();
        task_counters[task] = own;
    });
    for (const PassCounters& c : task_counters) counters.add(c);
}

// The tiles of one batch, drawn. With `load`, every tile of the grid starts with the load operations.
void draw_batch(const TileDraw& tile_draw, const std::optional<ListState>& fast, bool load, const TileGrid& grid,
                std::span<const Chunk> chunks, PassCounters& counters) {
    const std::vector<TileWork> work = tiles_with_work(grid, chunks, load);
    if (fast) return draw_fast_tiles(tile_draw, *fast, load, grid, chunks, work, counters);
    const size_t grain = std::clamp<size_t>(work.size() / 256, 1, 8);
    std::vector<PassCounters> tile_counters(chunk_count(work.size(), grain));
    parallel_for(work.size(), grain, [&](size_t begin, size_t end) {
        TileLists lists;
        for (size_t k = begin; k < end; ++k) {
            lists.make(grid, chunks, work[k]);
            for (const TileList& list : lists.lists)
                for (const std::uint16_t i : list.indices)
                    draw_in_tile(tile_draw, list.triangles->data[i], list.triangles->pieces.data(),
                                 grid.pixel_x(work[k].tile), grid.pixel_y(work[k].tile), tile_counters[begin / grain]);
        }
        _mm_sfence(); // what was streamed is seen by whoever comes next
    });
    for (const PassCounters& c : tile_counters) counters.add(c);
}

} // namespace

size_t bin_bytes(const PassLog& log) {
    size_t bytes = 0;
    if (log.scratch)
        for (const Chunk& chunk : log.scratch->chunks) bytes += chunk.bytes();
    return bytes;
}

void execute(Pass& pass, const Draw& draw, const PipelineState& state, const Targets& targets) {
    const SetupState setup = setup_state(draw, state, targets);
    PassCounters& counters = pass.counters();
    const std::span<const uvec3> triangles = draw.geometry.triangles;
    const size_t vertex_count = draw.geometry.vertex_count;
    if (vertex_count > most_vertices)
        throw UsageError(fmt::format("a draw has at most {} vertices, not {}", most_vertices, vertex_count));
    ++counters.draws;
    counters.vertices += static_cast<std::int64_t>(vertex_count);
    counters.triangles += static_cast<std::int64_t>(triangles.size());
    counters.bytes_written += cleared_bytes(targets);

    std::shared_ptr<DrawScratch>& scratch = pass.log().scratch;
    if (!scratch) scratch = std::make_shared<DrawScratch>();
    vec4* positions = scratch->positions.room_for(vertex_count);
    WindowVertex* window = scratch->window.room_for(vertex_count);
    constexpr size_t slack = 7; // what kernels read beyond the last vertex
    float* varyings = scratch->varyings.room_for(static_cast<size_t>(draw.varying_count) * vertex_count + slack);
    run_vertices(draw, setup, positions, varyings, window);

    const std::optional<ListState> fast = list_state(draw, state, targets);
    const bool load = cleared_bytes(targets) > 0;
    if (load && !fast) clear_targets(targets);
    const TileDraw tile_draw = {&draw, &state, &targets, positions, varyings, &kernels()};
    const ivec2 size = target_size(targets);
    const bool whole_pixels = setup.multisampled || setup.conservative;
    const TileGrid whole({0, 0, size.x, size.y}, whole_pixels), drawable(setup.drawable, whole_pixels);
    bool loading = load && fast;
    if (setup.drawable.width == 0 || setup.drawable.height == 0) {
        counters.culled += static_cast<std::int64_t>(triangles.size());
        if (loading) draw_batch(tile_draw, fast, true, whole, {}, counters);
        return;
    }
    std::vector<Chunk>& chunks = scratch->chunks;
    if (chunks.size() < batch_chunks) chunks.resize(batch_chunks);
    size_t chunk_triangles = triangles_of_a_chunk(triangles.size(), drawable);
    for (size_t first = 0; first < triangles.size() || loading;) {
        const size_t count = std::min(batch_chunks * chunk_triangles, triangles.size() - first);
        const std::span<Chunk> batch = std::span(chunks).first(chunk_count(count, chunk_triangles));
        const TileGrid& grid = loading ? whole : drawable;
        parallel_for(count, chunk_triangles, [&](size_t begin, size_t end) {
            Chunk& chunk = batch[begin / chunk_triangles];
            chunk.triangles.clear();
            set_up_triangles(setup, positions, window, triangles.subspan(first + begin, end - begin),
                             static_cast<std::uint32_t>(first + begin), chunk.triangles);
            if (chunk.fits()) chunk.bin(grid);
        });
        if (!std::all_of(batch.begin(), batch.end(), [](const Chunk& chunk) { return chunk.fits(); })) {
            chunk_triangles = least_chunk_triangles; // again, in chunks that fit even if all are clipped
            continue;
        }
        draw_batch(tile_draw, fast, loading, grid, batch, counters);
        for (const Chunk& chunk : batch) {
            counters.clipped += chunk.triangles.counts.clipped;
            counters.culled += chunk.triangles.counts.culled;
        }
        first += count;
        loading = false;
    }
}

} // namespace gnomon::detail
