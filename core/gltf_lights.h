#pragma once
// Area lights out of glTF, which has none of its own: emissive quads, and `extras.area` on the node of a punctual
// light.

#include <optional>

#include "core/gltf_accessor.h"
#include "core/json_reader.h"
#include "core/scene.h"

namespace gnomon {

// The light of an object whose triangles form a planar rectangle: two of them, wound the same way around four corners.
// It shines along the geometric normal with the material's emission as its radiance. Nothing for any other shape.
std::optional<Light> quad_light(const Scene& scene, const Object& object);

// The light that nodes[i].extensions.KHR_lights_punctual refers to, in the node's own frame (shining along −z, tangent
// along x), with `extras.area` of the node applied. Throws InputError naming the place.
Light node_light(const GltfFile& file, const JsonReader& document, const JsonReader& node);

} // namespace gnomon
