#pragma once
// Small glTF files for tests, good and broken ones.

#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/math.h"

namespace gnomon_tests {

inline void write_file(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

struct GltfBuilder {
    nlohmann::json document = {{"asset", {{"version", "2.0"}}}};
    std::string binary;

    template <class T> int view(const std::vector<T>& values, int stride = 0) {
        while (binary.size() % 4 != 0) binary.push_back('\0');
        nlohmann::json view = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", values.size() * sizeof(T)}};
        if (stride) view["byteStride"] = stride;
        binary.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        document["bufferViews"].push_back(view);
        return static_cast<int>(document["bufferViews"].size()) - 1;
    }

    int accessor(int view_index, int component_type, size_t count, const std::string& type, size_t offset = 0) {
        document["accessors"].push_back({{"componentType", component_type}, {"count", count}, {"type", type}});
        if (view_index >= 0) document["accessors"].back()["bufferView"] = view_index;
        if (offset) document["accessors"].back()["byteOffset"] = offset;
        return static_cast<int>(document["accessors"].size()) - 1;
    }

    int positions(const std::vector<gnomon::vec3>& values) {
        return accessor(view(values), 5126, values.size(), "VEC3");
    }

    template <class T> int indices(const std::vector<T>& values) {
        const int type = sizeof(T) == 1 ? 5121 : sizeof(T) == 2 ? 5123 : 5125;
        return accessor(view(values), type, values.size(), "SCALAR");
    }

    // A mesh of one primitive; index_accessor −1 where it has none.
    int mesh(int position_accessor, int index_accessor, int mode = 4) {
        nlohmann::json primitive = {{"attributes", {{"POSITION", position_accessor}}}, {"mode", mode}};
        if (index_accessor >= 0) primitive["indices"] = index_accessor;
        document["meshes"].push_back({{"primitives", nlohmann::json::array({primitive})}});
        return static_cast<int>(document["meshes"].size()) - 1;
    }

    nlohmann::json& node(nlohmann::json value, bool root = true) {
        if (root) document["scenes"][0]["nodes"].push_back(document["nodes"].size());
        document["nodes"].push_back(std::move(value));
        return document["nodes"].back();
    }

    // One triangle in one node: what every file here starts from.
    static GltfBuilder triangle() {
        GltfBuilder builder;
        const int position = builder.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
        const int index = builder.indices(std::vector<std::uint16_t>{0, 1, 2});
        builder.node({{"name", "triangle"}, {"mesh", builder.mesh(position, index)}});
        return builder;
    }

    std::string glb() {
        document["buffers"] = {{{"byteLength", binary.size()}}};
        std::string text = document.dump(), body = binary;
        while (text.size() % 4 != 0) text.push_back(' ');
        while (body.size() % 4 != 0) body.push_back('\0');
        const auto word = [](size_t value) {
            const auto bits = static_cast<std::uint32_t>(value);
            return std::string(reinterpret_cast<const char*>(&bits), 4);
        };
        std::string file = "glTF" + word(2) + word(12 + 8 + text.size() + 8 + body.size());
        file += word(text.size()) + "JSON" + text;
        return file + word(body.size()) + std::string("BIN\0", 4) + body;
    }

    std::string write(const std::string& path) {
        write_file(path, glb());
        return path;
    }
};

} // namespace gnomon_tests
