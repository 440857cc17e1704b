#pragma once
// The depth of one tile, its stencil counts or triangle ids, while the triangles of a draw go through it: loaded from
// the targets once, written back once.

#include <cstddef>
#include <cstdint>

#include "raster/counters.h"
#include "raster/setup.h"
#include "raster/target.h"
#include "raster/tile_stores.h"

namespace gnomon::detail {

inline constexpr int block_side = 8;
inline constexpr int patch_side = 4;
inline constexpr int tile_blocks = tile_side / block_side; // along one side
inline constexpr std::size_t block_pixels = std::size_t{block_side} * block_side;
inline constexpr std::size_t patch_pixels = std::size_t{patch_side} * patch_side;
inline constexpr std::size_t tile_pixels = std::size_t{tile_side} * tile_side;

// A tile's pixels lie block by block, in each block patch by patch, four of 4×4 pixels, in each patch row by row: a
// vector holds a patch, and what one triangle stores there the next one loads whole. Masks of a block follow this
// order. The place of a pixel in its block:
constexpr std::size_t place_in_block(int x, int y) {
    return static_cast<std::size_t>((y & 4) << 3 | (x & 4) << 2 | (y & 3) << 2 | (x & 3));
}

enum class ListMode : std::uint8_t {
    Depth,   // nothing besides depth
    Ids,     // and which triangle is visible
    Count8,  // stencil counts of 8 bits, modulo 256; depth is read only
    Count32, // of 32 bits
};
constexpr bool is_counting(ListMode mode) { return mode == ListMode::Count8 || mode == ListMode::Count32; }

constexpr std::size_t place_in_tile(int x, int y) {
    return block_pixels * static_cast<std::size_t>((y >> 3) * tile_blocks + (x >> 3)) + place_in_block(x, y);
}

// What is the same for all triangles of a draw.
struct ListState {
    ListMode mode = ListMode::Depth;
    Compare test = Compare::Always;
    bool write = false;
    bool conservative = false;
    bool offset = false;                         // a polygon offset may move depths
    double key_scale = 0;                        // of unorm depth: 2ⁿ − 1; 0 for floats
    std::int8_t counts[2][2] = {{0, 0}, {0, 0}}; // added to the stencil: [front][passes depth]
};

struct TileCounts {
    std::int64_t covered = 0, passed = 0, counted = 0; // fragments; those that changed the stencil
};

struct DepthTile {
    int x, y;                                    // pixel of the lower left corner
    alignas(64) std::int32_t depth[tile_pixels]; // depth_key
    alignas(64) std::uint32_t id[tile_pixels];   // no_id where nothing was drawn
    alignas(64) std::uint8_t count8[tile_pixels];
    alignas(64) std::uint32_t count32[tile_pixels];
    // Bounds of the depths in each block: unknown, or true; loose where a part of the block was written since they were
    // exact, and `drawn` is then the farthest that was drawn there (the nearest, for reversed depth).
    alignas(64) std::int32_t nearest[tile_blocks * tile_blocks], farthest[tile_blocks * tile_blocks];
    alignas(64) std::int32_t drawn[tile_blocks * tile_blocks];
    std::uint64_t unknown, loose;

    static constexpr std::uint32_t no_id = 0xffffffffu;
};

// Draws triangles list[0], list[1], … of `triangles` into the tile, in this order; `first_id` + their index is their
// id. After each of them some rows of `stores` are stored, where only depth is drawn.
using DrawList = void (*)(const ListState& state, DepthTile& tile, const SetupTriangle* triangles,
                          const std::uint16_t* list, std::size_t count, std::uint32_t first_id, TileStores& stores,
                          TileCounts& counts);
DrawList draw_list(const ListState& state); // for the chosen instruction set; errors as kernels()

} // namespace gnomon::detail
