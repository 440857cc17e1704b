#include "core/gltf_check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace gnomon {
namespace {

std::uint32_t read_u32(std::string_view bytes, size_t offset) {
    std::uint32_t value;
    static_assert(std::endian::native == std::endian::little);
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

// The elements of a top-level array; none where it is absent.
size_t array_size(const JsonReader& document, const char* key) {
    return document.has(key) ? document.at(key).size() : 0;
}

template <class Check> void for_each(const JsonReader& owner, const char* key, const Check& check) {
    if (!owner.has(key)) return;
    const JsonReader array = owner.at(key);
    for (size_t i = 0; i < array.size(); ++i) check(array[i]);
}

// The reference at `key`, where there is one, points into the array `target` of the document.
void check_reference(const JsonReader& document, const JsonReader& owner, const char* key, const char* target) {
    if (owner.has(key)) owner.at(key).index(array_size(document, target), target);
}

void check_numbers(const JsonReader& owner, const char* key, size_t size) {
    if (!owner.has(key)) return;
    const JsonReader array = owner.at(key);
    if (array.size() != size) array.fail(fmt::format("must have {} numbers", size));
    for (size_t i = 0; i < size; ++i) array[i].number(-1e30, 1e30);
}

size_t count_or(const JsonReader& owner, const char* key, size_t otherwise) {
    return owner.has(key) ? owner.at(key).count() : otherwise;
}

void check_buffer_view(const JsonReader& document, const JsonReader& view) {
    const size_t buffer = view.at("buffer").index(array_size(document, "buffers"), "buffers");
    const size_t available = document.at("buffers")[buffer].at("byteLength").count();
    const size_t offset = count_or(view, "byteOffset", 0), length = view.at("byteLength").count();
    if (offset > available || length > available - offset)
        view.fail(
            fmt::format("covers bytes {} to {}, but buffers[{}] has {} bytes; the file is damaged or was cut short",
                        offset, offset + length, buffer, available));
    const size_t stride = count_or(view, "byteStride", 0);
    if (stride != 0 && (stride < 4 || stride > 252)) view.at("byteStride").fail("must be between 4 and 252");
}

// `count` elements from `offset` on, `stride` apart (0: packed), lie inside bufferViews[view].
void check_range(const JsonReader& document, const JsonReader& accessor, size_t view, size_t offset, size_t count,
                 size_t stride, size_t element) {
    const size_t available = document.at("bufferViews")[view].at("byteLength").count();
    if (stride == 0) stride = element;
    // Divisions instead of products: counts in a hostile file may be anything up to 2^53.
    const bool inside = count == 0 || (element <= available && offset <= available - element &&
                                       (count - 1) <= (available - element - offset) / stride);
    if (!inside)
        accessor.fail(fmt::format("reads {} elements of {} bytes from byte {} on, which reaches beyond the {} bytes of "
                                  "bufferViews[{}]; the file is damaged or was cut short",
                                  count, element, offset, available, view));
}

void check_sparse(const JsonReader& document, const JsonReader& accessor, size_t count, size_t element) {
    const JsonReader sparse = accessor.at("sparse");
    const size_t replaced = sparse.at("count").count(), views = array_size(document, "bufferViews");
    if (replaced > count)
        sparse.at("count").fail(fmt::format("is {}, but the accessor has {} elements", replaced, count));
    const JsonReader indices = sparse.at("indices"), values = sparse.at("values");
    const size_t index_bytes = component_bytes(indices.at("componentType").integer(0, 65535));
    if (index_bytes == 0) indices.at("componentType").fail("is not a component type");
    check_range(document, sparse, indices.at("bufferView").index(views, "bufferViews"),
                count_or(indices, "byteOffset", 0), replaced, 0, index_bytes);
    check_range(document, sparse, values.at("bufferView").index(views, "bufferViews"),
                count_or(values, "byteOffset", 0), replaced, 0, element);
}

void check_accessor(const JsonReader& document, const JsonReader& accessor) {
    const size_t bytes = component_bytes(accessor.at("componentType").integer(0, 65535));
    if (bytes == 0) accessor.at("componentType").fail("is not a component type of glTF (5120 to 5123, 5125, 5126)");
    const size_t components = component_count(accessor.at("type").text());
    if (components == 0) accessor.at("type").fail("is not a type of glTF (SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3, MAT4)");
    const size_t count = accessor.at("count").count();
    if (accessor.has("bufferView")) {
        const size_t view = accessor.at("bufferView").index(array_size(document, "bufferViews"), "bufferViews");
        const size_t stride = count_or(document.at("bufferViews")[view], "byteStride", 0);
        if (stride % bytes != 0 || (stride != 0 && stride < bytes * components))
            accessor.fail(fmt::format("does not fit the byteStride {} of bufferViews[{}]", stride, view));
        check_range(document, accessor, view, count_or(accessor, "byteOffset", 0), count, stride, bytes * components);
    } else if (count > (size_t{1} << 31)) {
        accessor.at("count").fail(
            "is too large"); // no bytes stand behind it: memory must not be had for a number alone
    }
    if (accessor.has("sparse")) check_sparse(document, accessor, count, bytes * components);
}

void check_primitive(const JsonReader& document, const JsonReader& primitive) {
    const JsonReader attributes = primitive.at("attributes");
    attributes.expect_object();
    for (const auto& attribute : attributes.value().items())
        attributes.at(attribute.key()).index(array_size(document, "accessors"), "accessors");
    check_reference(document, primitive, "indices", "accessors");
    check_reference(document, primitive, "material", "materials");
    if (primitive.has("mode")) primitive.at("mode").integer(0, 6);
}

void check_node(const JsonReader& document, const JsonReader& node) {
    check_reference(document, node, "mesh", "meshes");
    check_reference(document, node, "camera", "cameras");
    check_reference(document, node, "skin", "skins");
    for_each(node, "children", [&](const JsonReader& child) { child.index(array_size(document, "nodes"), "nodes"); });
    check_numbers(node, "matrix", 16);
    check_numbers(node, "translation", 3);
    check_numbers(node, "rotation", 4);
    check_numbers(node, "scale", 3);
}

void check_material(const JsonReader& document, const JsonReader& material) {
    check_numbers(material, "emissiveFactor", 3);
    if (!material.has("pbrMetallicRoughness")) return;
    const JsonReader surface = material.at("pbrMetallicRoughness");
    check_numbers(surface, "baseColorFactor", 4);
    if (surface.has("baseColorTexture"))
        surface.at("baseColorTexture").at("index").index(array_size(document, "textures"), "textures");
}

// Extensions without which the geometry can still be read exactly; what they add to a surface's look is left out.
void check_required_extensions(const JsonReader& document) {
    constexpr std::array readable = {"KHR_lights_punctual", "KHR_mesh_quantization", "KHR_texture_transform"};
    for_each(document, "extensionsRequired", [&](const JsonReader& extension) {
        const std::string name = extension.text();
        if (std::find(readable.begin(), readable.end(), name) != readable.end() || name.starts_with("KHR_materials_"))
            return;
        const bool compressed = name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression";
        extension.fail(fmt::format("is '{}', which is not supported; export the file again without {}", name,
                                   compressed ? "mesh compression" : "this extension"));
    });
}

} // namespace

bool is_glb(std::string_view bytes) { return bytes.starts_with("glTF"); }

std::string_view glb_json(std::string_view bytes, const std::string& file) {
    constexpr std::uint32_t json_chunk = 0x4e4f534a;
    constexpr size_t header = 12, chunk_header = 8;
    if (!is_glb(bytes)) {
        const bool text = bytes.substr(0, 64).find('{') != std::string_view::npos;
        throw InputError(file + ": not a binary glTF file (it does not start with 'glTF'); " +
                         (text ? "a text file needs the extension .gltf" : "export it again"));
    }
    if (bytes.size() < header + chunk_header)
        throw InputError(fmt::format("{}: the file ends inside its header, after {} bytes; copy or export it again",
                                     file, bytes.size()));
    if (read_u32(bytes, 4) != 2)
        throw InputError(
            fmt::format("{}: glTF version {} is not supported; export it as glTF 2.0", file, read_u32(bytes, 4)));
    if (read_u32(bytes, 8) > bytes.size())
        throw InputError(fmt::format("{}: the file ends after {} of {} bytes; copy or export it again", file,
                                     bytes.size(), read_u32(bytes, 8)));
    bytes = bytes.substr(0, read_u32(bytes, 8));
    const size_t length = bytes.size() < header + chunk_header ? SIZE_MAX : read_u32(bytes, header);
    if (length > bytes.size() - header - chunk_header || read_u32(bytes, header + 4) != json_chunk)
        throw InputError(file + ": the first chunk of the file is not a whole JSON chunk; copy or export it again");
    const std::string_view json = bytes.substr(header + chunk_header, length);
    const std::string_view rest = bytes.substr(header + chunk_header + length);
    if (!rest.empty() && (rest.size() < chunk_header || read_u32(rest, 0) > rest.size() - chunk_header))
        throw InputError(file + ": the binary chunk reaches beyond the end of the file; copy or export it again");
    return json;
}

void check_gltf(const JsonReader& document) {
    document.expect_object();
    const std::string version = document.at("asset").at("version").text();
    if (!version.starts_with("2."))
        document.at("asset").at("version").fail("is '" + version + "', which is not supported; export it as glTF 2.0");
    check_required_extensions(document);
    for_each(document, "buffers", [](const JsonReader& buffer) { buffer.at("byteLength").count(); });
    for_each(document, "bufferViews", [&](const JsonReader& view) { check_buffer_view(document, view); });
    for_each(document, "accessors", [&](const JsonReader& accessor) { check_accessor(document, accessor); });
    for_each(document, "images",
             [&](const JsonReader& image) { check_reference(document, image, "bufferView", "bufferViews"); });
    for_each(document, "textures", [&](const JsonReader& texture) {
        check_reference(document, texture, "source", "images");
        check_reference(document, texture, "sampler", "samplers");
    });
    for_each(document, "materials", [&](const JsonReader& material) { check_material(document, material); });
    for_each(document, "meshes", [&](const JsonReader& mesh) {
        for_each(mesh, "primitives", [&](const JsonReader& primitive) { check_primitive(document, primitive); });
    });
    for_each(document, "cameras", [](const JsonReader& camera) { camera.at("type").text(); });
    for_each(document, "nodes", [&](const JsonReader& node) { check_node(document, node); });
    for_each(document, "scenes", [&](const JsonReader& scene) {
        for_each(scene, "nodes", [&](const JsonReader& node) { node.index(array_size(document, "nodes"), "nodes"); });
    });
    check_reference(document, document, "scene", "scenes");
}

size_t component_bytes(int component_type) {
    switch (component_type) {
    case 5120:
    case 5121:
        return 1;
    case 5122:
    case 5123:
        return 2;
    case 5125:
    case 5126:
        return 4;
    default:
        return 0;
    }
}

size_t component_count(std::string_view type) {
    constexpr std::array<std::pair<std::string_view, size_t>, 7> types = {
        {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}};
    for (const auto& [name, count] : types)
        if (name == type) return count;
    return 0;
}

} // namespace gnomon
