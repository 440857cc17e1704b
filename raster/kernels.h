#pragma once
// The innermost loops of the tile rasterizer, compiled for several instruction sets and chosen once at run time:
// AVX-512, AVX2, or plain. All give the same bits: integers, and IEEE operations in one written order without
// contraction. The environment variable GNOMON_ISA=avx512|avx2|plain forces one.

#include <cstddef>
#include <cstdint>

#include "raster/depth_tile.h"
#include "raster/setup.h"

namespace gnomon::detail {

// In all of them bit 8·j + i of a mask stands for pixel (x + i, y + j) of an 8×8 block.
struct Kernels {
    const char* name;

    // Pixels of the block at (x, y), relative to the tile, inside all three edges; rows outside [first, last] are not
    // looked at.
    std::uint64_t (*coverage)(const TileEdges& edges, int x, int y, int first, int last);

    // Window depth of every row that has a pixel in the mask: the plane in double, clamped to the triangle's own range,
    // offset, clamped to [0, 1].
    void (*depth)(const SetupTriangle& triangle, int x, int y, std::uint64_t mask, double* depth);

    // Of every pixel in the mask: 1/w, and the perspective barycentric coordinates of the second and
    // third corner, from their planes in double.
    void (*barycentrics)(const SetupTriangle& triangle, const AttributePlanes& planes, int x, int y, std::uint64_t mask,
                         float* inverse_w, float* second, float* third);

    // Varyings of every pixel in the mask, from the corners' and the barycentric coordinates of `second` and `third`:
    // `count` floats each, out[64·i + pixel] = v0[i] + second·(v1[i] − v0[i]) + third·(v2[i] − v0[i]) in float.
    void (*varyings)(const float* v0, const float* v1, const float* v2, std::size_t count, std::uint64_t mask,
                     const float* second, const float* third, float* out);

    // Depth test of a D32F block whose lower left value is at `stored`, rows `stride` floats apart: the pixels of the
    // mask that pass; their depth is stored if `write`.
    std::uint64_t (*test_d32f)(const SetupTriangle& triangle, int x, int y, std::uint64_t mask, float* stored,
                               std::size_t stride, Compare test, bool write);

    // Fills a whole tile with one word.
    void (*fill_tile)(std::int32_t* tile, std::int32_t word);

    // Store rows of a tile (tile_stores.h).
    StoreRows store_rows;
    FillRows fill_rows;
};

// Throws UsageError where GNOMON_ISA names no instruction set, or one that this machine lacks.
const Kernels& kernels();

} // namespace gnomon::detail
