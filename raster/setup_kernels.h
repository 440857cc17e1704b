#pragma once
// Set-up of many triangles at once: the viewport transform, culling, and depth planes, in the order of operations that
// setup.h states.

#include <cstddef>

#include "raster/setup.h"

namespace gnomon::detail {

// Triangles that were not culled, one array a coordinate.
struct Survivors {
    static constexpr std::size_t capacity = 512;
    static constexpr std::size_t slack = 16; // written beyond the count, one vector
    std::size_t count = 0;
    std::size_t empty = 0; // triangles that were dropped besides: neither culled nor here, since they cover no pixel
    alignas(64) std::int32_t x[3][capacity + slack], y[3][capacity + slack];
    alignas(64) float z[3][capacity + slack];
    alignas(64) std::uint32_t primitive[capacity + slack];
    alignas(64) std::uint32_t piece[capacity + slack];
    alignas(64) std::uint32_t mirrored[capacity + slack]; // 1 where the corners run against the order of submission
};

// A rectangle of tiles, inclusive.
struct TileBox {
    int x0, y0, x1, y1;
    bool contains(int x, int y) const { return x >= x0 && x <= x1 && y >= y0 && y <= y1; }
};

struct SetupKernels {
    // Window vertices of clip positions.
    void (*to_window)(const SetupState& state, const vec4* positions, std::size_t count, WindowVertex* window);

    // Appends those triangles that are not culled and may cover a pixel; the k-th is primitive `first` + k. Returns how
    // many it looked at: it stops before the first that needs clipping. Room for `count` more is asked for.
    std::size_t (*cull)(const SetupState& state, const WindowVertex* window, const uvec3* triangles, std::size_t count,
                        std::uint32_t first, bool mirrored, Survivors& survivors);

    // Makes set-up triangles of all survivors, without polygon offset.
    void (*finish)(const SetupState& state, const Survivors& survivors, SetupTriangle* triangles);

    // Which of the tiles (x0 + i, y0 + j), i below 8 and j below `rows`, at most 8, the triangle's edges leave something
    // of inside: a pixel centre, or, where whole pixels count, any point. Tile (i, j) is bit 8·j + i.
    std::uint64_t (*touched_tiles)(const SetupTriangle& triangle, int x0, int y0, int rows, bool whole_pixels);
};

const SetupKernels& setup_kernels(); // errors as kernels()

} // namespace gnomon::detail
