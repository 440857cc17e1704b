#pragma once
// The triangles of glTF primitives.

#include <string>

#include "core/gltf_accessor.h"
#include "core/scene.h"

namespace tinygltf {
struct Primitive;
}

namespace gnomon {

// Positions, normals, TEXCOORD_0 and triangles of a primitive whose mode is triangles, a strip or a fan, indexed or
// not. `place` names it in messages. Throws InputError.
MeshData read_primitive(const GltfFile& file, const tinygltf::Primitive& primitive, const std::string& place);

} // namespace gnomon
