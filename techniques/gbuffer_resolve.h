#pragma once
// From "which triangle does this pixel show" to everything the G-buffer stores about it. The rasterized and the
// ray-traced camera pass both end here, so that a pixel that shows the same triangle has the same receiver, bit for
// bit.

#include <cstdint>

#include "techniques/frame.h"

namespace gnomon {

// All images at width × height, showing nothing: no triangle, depth +∞, the rest zero.
void clear_gbuffer(GBuffer& gbuffer, int width, int height);

// Fills pixel (x, y) with the point of `triangle` that the ray through the pixel's centre meets; no_triangle clears the
// pixel. The rasterizer snaps to 1/256 pixel, so a centre may lie that much outside the triangle: the point is moved to
// its edge.
void resolve_receiver(GBuffer& gbuffer, int x, int y, const Scene& scene, const Camera& camera, std::uint32_t triangle);

// The same for all pixels, in parallel; clears the G-buffer to the size of `triangles` first.
void resolve_gbuffer(GBuffer& gbuffer, const Scene& scene, const Camera& camera, const Image<std::uint32_t>& triangles);

// The `--primary ray` camera pass: the first triangle along each pixel's central ray between the near and the far
// plane.
void trace_gbuffer(GBuffer& gbuffer, const Scene& scene, const Camera& camera, const EmbreeScene& rays, int width,
                   int height);

} // namespace gnomon
