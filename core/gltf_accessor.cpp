#include "core/gltf_accessor.h"

#include <algorithm>
#include <cstring>
#include <span>

#include <fmt/format.h>
#include <tiny_gltf.h>

#include "core/error.h"
#include "core/gltf_check.h"
#include "core/parallel.h"

namespace gnomon {
namespace {

constexpr size_t grain = size_t{1} << 15;

// `count` elements, `stride` bytes apart; no bytes: all zeros.
struct Elements {
    const unsigned char* bytes = nullptr;
    size_t stride = 0;
    size_t count = 0;
};

[[noreturn]] void fail(const GltfFile& file, const std::string& place, const std::string& complaint) {
    throw InputError(file.name + ": " + place + " " + complaint);
}

Elements elements_of(const GltfFile& file, int view_index, size_t offset, size_t count, size_t element_bytes,
                     const std::string& place) {
    if (view_index < 0 || count == 0) return {nullptr, element_bytes, count};
    const tinygltf::BufferView& view = file.model.bufferViews[static_cast<size_t>(view_index)];
    const std::vector<unsigned char>& data = file.model.buffers[static_cast<size_t>(view.buffer)].data;
    const size_t stride = view.byteStride != 0 ? view.byteStride : element_bytes;
    // check_gltf has compared everything with the document's numbers; this compares it with the bytes that were loaded.
    const size_t begin = view.byteOffset + offset;
    if (begin > data.size() || element_bytes > data.size() - begin ||
        (count - 1) > (data.size() - begin - element_bytes) / stride)
        fail(file, place, "reaches beyond the bytes that were loaded; the file was cut short");
    return {data.data() + begin, stride, count};
}

template <class T> T load(const unsigned char* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

// One component as a float. [glTF 2.0, 3.6.2.2]
float component(const unsigned char* bytes, int type, bool normalized) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: {
        const float value = load<std::int8_t>(bytes);
        return normalized ? std::max(value / 127.0f, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: {
        const float value = load<std::uint8_t>(bytes);
        return normalized ? value / 255.0f : value;
    }
    case TINYGLTF_COMPONENT_TYPE_SHORT: {
        const float value = load<std::int16_t>(bytes);
        return normalized ? std::max(value / 32767.0f, -1.0f) : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: {
        const float value = load<std::uint16_t>(bytes);
        return normalized ? value / 65535.0f : value;
    }
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return static_cast<float>(load<std::uint32_t>(bytes));
    default:
        return load<float>(bytes);
    }
}

std::uint32_t index_value(const unsigned char* bytes, int type) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return load<std::uint8_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return load<std::uint16_t>(bytes);
    default:
        return load<std::uint32_t>(bytes);
    }
}

bool is_index_type(int type) {
    return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
           type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

template <class Vector> Vector element(const unsigned char* bytes, int type, size_t type_bytes, bool normalized) {
    Vector v;
    for (int i = 0; i < Vector::length(); ++i)
        v[i] = component(bytes + static_cast<size_t>(i) * type_bytes, type, normalized);
    return v;
}

// The elements that a sparse accessor replaces. [glTF 2.0, 3.6.2.3]
template <class Vector>
void replace_sparse(const GltfFile& file, const tinygltf::Accessor& accessor, std::vector<Vector>& values,
                    const std::string& place) {
    const auto& sparse = accessor.sparse;
    const int index_type = sparse.indices.componentType;
    if (!is_index_type(index_type))
        fail(file, place + ".sparse.indices.componentType", "must be an unsigned integer type");
    const auto count = static_cast<size_t>(sparse.count);
    const size_t index_bytes = component_bytes(index_type), type_bytes = component_bytes(accessor.componentType);
    const size_t value_bytes = type_bytes * static_cast<size_t>(Vector::length());
    const Elements indices =
        elements_of(file, sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset), count, index_bytes,
                    place + ".sparse.indices");
    const Elements replacements =
        elements_of(file, sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset), count, value_bytes,
                    place + ".sparse.values");
    for (size_t i = 0; i < count; ++i) {
        const size_t target = index_value(indices.bytes + i * indices.stride, index_type);
        if (target >= values.size())
            fail(file, place + ".sparse", fmt::format("replaces element {} of {}", target, values.size()));
        values[target] = element<Vector>(replacements.bytes + i * replacements.stride, accessor.componentType,
                                         type_bytes, accessor.normalized);
    }
}

template <class Vector>
std::vector<Vector> read_vectors(const GltfFile& file, int index, size_t expected_count, const std::string& place) {
    const tinygltf::Accessor& accessor = file.model.accessors[static_cast<size_t>(index)];
    if (accessor.type != (Vector::length() == 3 ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_VEC2))
        fail(file, place, fmt::format("(accessors[{}]) must be of type VEC{}", index, Vector::length()));
    if (expected_count != 0 && accessor.count != expected_count)
        fail(file, place,
             fmt::format("(accessors[{}]) has {} elements for {} positions", index, accessor.count, expected_count));
    const size_t type_bytes = component_bytes(accessor.componentType);
    const Elements elements = elements_of(file, accessor.bufferView, accessor.byteOffset, accessor.count,
                                          type_bytes * static_cast<size_t>(Vector::length()), place);
    std::vector<Vector> values(accessor.count, Vector(0.0f));
    const bool packed_floats =
        accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT && elements.stride == sizeof(Vector);
    if (elements.bytes && packed_floats)
        std::memcpy(values.data(), elements.bytes, values.size() * sizeof(Vector));
    else if (elements.bytes)
        parallel_for(values.size(), grain, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                values[i] = element<Vector>(elements.bytes + i * elements.stride, accessor.componentType, type_bytes,
                                            accessor.normalized);
        });
    if (accessor.sparse.isSparse) replace_sparse(file, accessor, values, place);
    return values;
}

} // namespace

std::vector<vec3> read_vec3(const GltfFile& file, int accessor, size_t expected_count, const std::string& place) {
    return read_vectors<vec3>(file, accessor, expected_count, place);
}

std::vector<vec2> read_vec2(const GltfFile& file, int accessor, size_t expected_count, const std::string& place) {
    return read_vectors<vec2>(file, accessor, expected_count, place);
}

std::vector<std::uint32_t> read_indices(const GltfFile& file, int index, const std::string& place) {
    const tinygltf::Accessor& accessor = file.model.accessors[static_cast<size_t>(index)];
    const int type = accessor.componentType;
    if (accessor.type != TINYGLTF_TYPE_SCALAR || !is_index_type(type) || accessor.sparse.isSparse)
        fail(file, place, fmt::format("(accessors[{}]) must be a plain accessor of unsigned integers", index));
    const Elements elements =
        elements_of(file, accessor.bufferView, accessor.byteOffset, accessor.count, component_bytes(type), place);
    std::vector<std::uint32_t> values(accessor.count, 0u);
    if (!elements.bytes) return values;
    parallel_for(values.size(), grain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) values[i] = index_value(elements.bytes + i * elements.stride, type);
    });
    return values;
}

} // namespace gnomon
