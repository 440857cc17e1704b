#pragma once
// The fraction of an area light that a receiver sees, by geometry instead of samples: the triangles between receiver
// and light are projected onto the light's plane, and the area that their union leaves of the light is measured. It
// knows neither patterns nor rays, so it is a witness for both.
//
// It answers what the rays ask: from the same origin, off the surface by its rounding; the receiver's own triangle
// hides nothing; points of the light below the receiver's horizon are not seen; what touches the light from behind
// hides nothing. The union is formed on a grid of 2⁻²⁹ of the light's size [Clipper library, after Vatti 1992, "A
// Generic Solution to Polygon Clipping"], so that an answer is off by some 10⁻⁸ for each edge at most. Disks and the
// limbs of spheres are polygons of 256 sides and equal area.

#include "core/image.h"
#include "core/receiver.h"
#include "raytrace/triangle_clusters.h"

namespace gnomon {

class Progress;

// Of the light's area; a mesh light's is that of its triangles. A flat light in whose plane the receiver lies is seen
// from a ten-millionth of its size beside that plane. Needs an area light. `clusters` are those of the scene.
double exact_visibility(const Scene& scene, const TriangleClusters& clusters, const Receiver& receiver,
                        const Light& light);

// For every receiver; 1 where the camera sees nothing. `progress` may be null; it advances by one a pixel. Throws
// UsageError for a punctual light, whose visibility is a question of one ray.
Image<float> exact_visibility(const Scene& scene, const TriangleClusters& clusters, const Receivers& receivers,
                              const Light& light, Progress* progress);

} // namespace gnomon
