#pragma once
// The inner loops between visible triangles and colour targets: which triangles a block shows, the planes of many of
// them at once, their varyings pixel by pixel, and rows of texels on their way to memory. Compiled like kernels.h, with
// the same bits.

#include <cstddef>
#include <cstdint>

#include "raster/draw.h"

namespace gnomon::detail {

// What the planes of triangles are made of, one array a value.
struct PlaneInputs {
    static constexpr std::size_t capacity = 512;
    alignas(64) std::int32_t e1x[capacity], e1y[capacity], e2x[capacity], e2y[capacity]; // edges from the anchor, 1/256
                                                                                         // pixels
    alignas(64) float w[3][capacity];                           // of the corners, from the anchor
    alignas(64) std::int32_t second[capacity], third[capacity]; // which of them was submitted second, and third

    void set(std::size_t k, const SetupTriangle& t, const vec3& submitted_w) {
        e1x[k] = t.x[1] - t.x[0], e1y[k] = t.y[1] - t.y[0];
        e2x[k] = t.x[2] - t.x[0], e2y[k] = t.y[2] - t.y[0];
        const std::size_t places[3] = {t.corner(0), t.corner(1), t.corner(2)};
        for (std::int32_t place = 0; place < 3; ++place) {
            const std::size_t corner = places[place];
            w[place][k] = submitted_w[static_cast<glm::length_t>(corner)];
            if (corner == 1) second[k] = place;
            if (corner == 2) third[k] = place;
        }
    }
};

struct ShadingKernels {
    // The distinct ones of a block's 64 ids, in the order of a tile, besides `none`: id and pixels of the k-th, and k
    // for each of its pixels. Returns how many.
    std::size_t (*find_runs)(const std::uint32_t* ids, std::uint32_t none, std::uint32_t* found, std::uint64_t* masks,
                             std::uint8_t* run);

    // Perspective planes of `count` triangles, exactly as attribute_planes() makes them of whole ones. Writes up to
    // planes[capacity − 1].
    void (*planes)(const PlaneInputs& inputs, std::size_t count, AttributePlanes* planes);

    // 1/w and barycentric coordinates of the pixels of a block of a few runs.
    void (*barycentrics)(FragmentBlock& block, std::size_t runs);

    // 1/w, barycentric coordinates and `count` varyings of all pixels of a block of few pixels a run, each from its
    // run's planes. Reads up to 7 floats beyond the corners' varyings.
    void (*interpolate)(FragmentBlock& block, std::size_t count);

    // Four channels of a block as 8 rows of 8 texels, rows `stride` texels apart.
    void (*interleave)(const std::array<float, 64>* channels, vec4* texels, std::size_t stride);

    // Copies past the caches: another thread sees it after a store fence. Whole cache lines.
    void (*stream)(const void* from, void* to, std::size_t bytes);
};

const ShadingKernels& shading_kernels(); // errors as kernels()

} // namespace gnomon::detail
