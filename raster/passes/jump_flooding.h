#pragma once
// Jump flooding: nearest seeds, nearly, in log2(n) passes of nine fetches: the approximation to the distance transform
// that GPUs run fastest. [Rong & Tan 2006, "Jump flooding in GPU with applications to Voronoi diagram and distance
// transform"]
//
// A pass of step s gives every pixel the nearest of the sites held by the nine pixels at offsets {−s, 0, s}²; ties as
// in the exact transform: the smallest x, then the smallest y. Steps are 2^(k−1), …, 2, 1 with 2^k ≥ max(width,
// height). A site is always that of some seed, and every pixel has one as soon as there is a seed; it is the nearest
// one but for few pixels.
//
// Cost: a seeding pass (one byte fetched), then per pass and pixel the fetches that fall inside, 4 bytes each, and a
// 4-byte write.

#include "raster/passes/distance_transform.h"

namespace gnomon {

struct JumpFlooding {
    bool one_before = false; // 1+JFA: a pass of step 1 first, which removes most errors
    int after = 0;           // JFA+1, JFA+2: passes of step 2^(after−1), …, 1 once more
};

// A non-zero pixel is a seed.
Image<Site> jump_flooding(Pass& pass, const Image<std::uint8_t>& seeds, const JumpFlooding& options = {});

} // namespace gnomon
