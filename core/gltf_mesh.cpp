#include "core/gltf_mesh.h"

#include <algorithm>
#include <cstring>

#include <tiny_gltf.h>

#include "core/error.h"

namespace gnomon {
namespace {

// Triangles of a list, strip or fan; every other triangle of a strip is turned so that all face the same way.
// [glTF 2.0, 3.7.2.1]
std::vector<uvec3> assemble(const std::vector<std::uint32_t>& indices, int mode) {
    std::vector<uvec3> triangles;
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        triangles.resize(indices.size() / 3);
        if (!triangles.empty()) std::memcpy(triangles.data(), indices.data(), triangles.size() * sizeof(uvec3));
        return triangles;
    }
    for (size_t i = 0; i + 2 < indices.size(); ++i) {
        if (mode == TINYGLTF_MODE_TRIANGLE_FAN)
            triangles.emplace_back(indices[i + 1], indices[i + 2], indices[0]);
        else
            triangles.emplace_back(indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]);
    }
    return triangles;
}

template <class Value> void keep(std::vector<Value>& values, const std::vector<std::uint32_t>& used) {
    if (values.empty()) return;
    for (size_t i = 0; i < used.size(); ++i) values[i] = values[used[i]]; // `used` ascends
    values.resize(used.size());
}

// Some files put all vertices into one accessor that every primitive shares: without this each object would carry them
// all.
void drop_unused_vertices(MeshData& mesh) {
    const size_t count = mesh.positions.size();
    if (mesh.triangles.size() * 3 >= count) return;
    std::vector<std::uint32_t> local(count, 0);
    for (const uvec3 t : mesh.triangles) {
        if (std::max({t.x, t.y, t.z}) >= count) return; // add_object complains
        local[t.x] = local[t.y] = local[t.z] = 1;
    }
    std::vector<std::uint32_t> used;
    for (std::uint32_t i = 0; i < count; ++i)
        if (local[i]) local[i] = static_cast<std::uint32_t>(used.size()), used.push_back(i);
    for (uvec3& t : mesh.triangles) t = {local[t.x], local[t.y], local[t.z]};
    keep(mesh.positions, used);
    keep(mesh.normals, used);
    keep(mesh.uvs, used);
}

} // namespace

MeshData read_primitive(const GltfFile& file, const tinygltf::Primitive& primitive, const std::string& place) {
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) {
        const bool compressed = primitive.extensions.contains("KHR_draco_mesh_compression");
        throw InputError(file.name + ": " + place + " has no POSITION; export it " +
                         (compressed ? "without mesh compression" : "again"));
    }
    MeshData mesh;
    mesh.positions = read_vec3(file, position->second, 0, place + ".attributes.POSITION");
    const size_t count = mesh.positions.size();
    if (count == 0) return {};
    if (const auto normal = primitive.attributes.find("NORMAL"); normal != primitive.attributes.end())
        mesh.normals = read_vec3(file, normal->second, count, place + ".attributes.NORMAL");
    if (const auto uv = primitive.attributes.find("TEXCOORD_0"); uv != primitive.attributes.end())
        mesh.uvs = read_vec2(file, uv->second, count, place + ".attributes.TEXCOORD_0");
    std::vector<std::uint32_t> indices;
    if (primitive.indices >= 0) {
        indices = read_indices(file, primitive.indices, place + ".indices");
    } else {
        indices.resize(count);
        for (size_t i = 0; i < count; ++i) indices[i] = static_cast<std::uint32_t>(i);
    }
    mesh.triangles = assemble(indices, primitive.mode < 0 ? TINYGLTF_MODE_TRIANGLES : primitive.mode);
    drop_unused_vertices(mesh);
    return mesh;
}

} // namespace gnomon
