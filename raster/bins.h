#pragma once
// Which triangles touch which 64×64 tile. A chunk of triangles is sorted by tile over the rectangle of tiles that it
// touches; triangles over very many tiles are kept aside, so that memory grows with the triangles and not with their
// area: small ones have at most 4 entries of 2 bytes each, and of 8 more while they are sorted, large ones at most 64,
// and 262144 a chunk. With the 88 bytes of a set-up triangle a chunk of 16384, the largest, takes at most 7 MB, vectors
// doubling included, and a batch of 64 of them at most 448 MB; targets of 1024² pixels and fewer have batches of a
// quarter of that or less. Each triangle that is clipped may count up to seven times.

#include <cstdint>
#include <span>
#include <vector>

#include "raster/counters.h"
#include "raster/setup_kernels.h"

namespace gnomon::detail {

struct TileGrid {
    int x0, y0, columns, rows; // tiles; tile (0, 0) starts at pixel (0, 0)
    bool whole_pixels;         // any point of a pixel may be covered, not only its centre

    TileGrid(const Rectangle& pixels, bool whole);
    size_t count() const { return static_cast<size_t>(columns) * static_cast<size_t>(rows); }
    size_t index(int x, int y) const { // of the tile (x, y)
        return static_cast<size_t>(y - y0) * static_cast<size_t>(columns) + static_cast<size_t>(x - x0);
    }
    int tile_x(size_t index) const { return x0 + static_cast<int>(index % static_cast<size_t>(columns)); }
    int tile_y(size_t index) const { return y0 + static_cast<int>(index / static_cast<size_t>(columns)); }
    int pixel_x(size_t index) const { return tile_x(index) << tile_shift; }
    int pixel_y(size_t index) const { return tile_y(index) << tile_shift; }
};

// One task's set-up triangles, and for each tile the list of those that may touch it, in order of submission.
class Chunk {
public:
    static constexpr size_t most_triangles = size_t{1} << 16; // as entries name them

    SetupTriangles triangles;

    // Where clipping has made too many of them, they cannot be sorted, and a chunk must begin with fewer.
    bool fits() const { return triangles.count <= most_triangles; }
    void bin(const TileGrid& grid);
    // Triangles for the tile (x, y); where they must be merged first, they are appended to `merged`.
    std::span<const std::uint16_t> list(int x, int y, std::vector<std::uint16_t>& merged) const;
    size_t bytes() const; // of memory that it holds, used or not
    size_t most_merged() const { return wide_.empty() ? 0 : triangles.count; }
    // Bits c of those tiles, in the order of the grid, for which there are triangles.
    void mark_tiles(const TileGrid& grid, size_t c, std::vector<std::uint64_t>& bits) const;

private:
    struct Entry {
        std::uint32_t tile; // of the chunk's rectangle
        std::uint16_t triangle;
    };
    size_t local(int x, int y) const {
        return static_cast<size_t>(y - y0_) * static_cast<size_t>(x1_ - x0_ + 1) + static_cast<size_t>(x - x0_);
    }
    size_t add_small(size_t i);
    bool add_touched(const TileGrid& grid, const TileBox& box, size_t i);

    int x0_ = 0, y0_ = 0, x1_ = -1, y1_ = -1; // rectangle of tiles
    std::vector<std::uint32_t> begin_;        // of each tile's list, and the end of the last
    std::vector<std::uint16_t> lists_;
    std::vector<std::uint16_t> wide_; // triangles over more tiles than are listed
    std::vector<Entry> entries_;      // of which entry_count_ are in use
    size_t entry_count_ = 0;
};

// Of all chunks that draws into the log have left to the next.
size_t bin_bytes(const PassLog& log);

// A tile and the chunks, as bits, that have triangles for it; at most 64 chunks.
struct TileWork {
    std::uint32_t tile;
    std::uint64_t chunks;
};
// In the order of the tiles; with `all` also those without triangles.
std::vector<TileWork> tiles_with_work(const TileGrid& grid, std::span<const Chunk> chunks, bool all);

} // namespace gnomon::detail
