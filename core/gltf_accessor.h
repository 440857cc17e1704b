#pragma once
// Numbers out of glTF accessors: any component type, stride and sparse replacement, converted to what a mesh holds.

#include <cstdint>
#include <string>
#include <vector>

#include "core/math.h"

namespace tinygltf {
class Model;
}

namespace gnomon {

// A parsed document whose references check_gltf has verified, and the file's name for messages.
struct GltfFile {
    const tinygltf::Model& model;
    const std::string& name;
};

// Elements of accessors[accessor] as floats; normalized integers become [0, 1] or [−1, 1], other integers their value
// (KHR_mesh_quantization). Throws InputError where the accessor has another number of components, or `expected_count`
// is not 0 and it has another count.
std::vector<vec3> read_vec3(const GltfFile& file, int accessor, size_t expected_count, const std::string& place);
std::vector<vec2> read_vec2(const GltfFile& file, int accessor, size_t expected_count, const std::string& place);
// Scalar unsigned integers of 8, 16 or 32 bits.
std::vector<std::uint32_t> read_indices(const GltfFile& file, int accessor, const std::string& place);

} // namespace gnomon
