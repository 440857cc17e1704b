#pragma once
// Tiles on their way to a target. Memory takes them more slowly than a core gives them, so they leave a few rows at a
// time, while the triangles of another tile are drawn.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace gnomon::detail {

// What stores rows [first, last) of a whole tile of 32-bit words, which lie patch by patch (depth_tile.h), to rows
// `stride` bytes apart, `to` being the tile's first; with `stream` past the caches, where they are aligned to 64 bytes.
using StoreRows = void (*)(const std::int32_t* words, int first, int last, std::byte* to, std::size_t stride,
                           bool stream);
// The same for rows that hold one word.
using FillRows = void (*)(std::int32_t word, int first, int last, std::byte* to, std::size_t stride, bool stream);

struct TileStores {
    struct Tile {
        const std::int32_t* words; // null: cleared
        std::byte* to;
        int row = 0; // the next to be stored
    };
    StoreRows store_rows;
    FillRows fill_rows;
    std::size_t stride;
    bool stream;
    std::int32_t cleared;         // word
    std::vector<Tile> tiles = {}; // that are not stored yet; the last goes first
    int rows_at_once = 0;         // stored after each triangle

    bool empty() const { return tiles.empty(); }
    int rows_left() const; // of all tiles
    void store(int rows);  // so many, or all that are left
};

} // namespace gnomon::detail
