#include "core/scene_files.h"

#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/gltf_check.h"
#include "core/json_reader.h"

namespace gnomon {
namespace {

namespace fs = std::filesystem;

int hexadecimal(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

// "my%20buffer.bin" as the file is called.
std::string decoded(const std::string& uri) {
    std::string name;
    for (size_t i = 0; i < uri.size(); ++i) {
        const int high = uri[i] == '%' && i + 2 < uri.size() ? hexadecimal(uri[i + 1]) : -1;
        const int low = high >= 0 ? hexadecimal(uri[i + 2]) : -1;
        if (low >= 0)
            name += static_cast<char>(high * 16 + low), i += 2;
        else
            name += uri[i];
    }
    return name;
}

class Finder {
public:
    explicit Finder(const fs::path& scene) : folder_(scene.parent_path()) {}

    void add_scene(const fs::path& name) {
        add(name);
        const std::string path = (folder_ / name).string();
        const nlohmann::json document = parse(read_file(path), path);
        if (document.contains("asset")) return add_references_of_gltf(name, document);
        for_each_text(document, "objects", "gltf", [&](const std::string& file) { add_gltf(file); });
        for_each_text(document, "lights", "image", [&](const std::string& file) { add(file); });
    }

    std::vector<SceneFile> files;

private:
    // Null where it is not JSON: loading will say so.
    static nlohmann::json parse(const std::string& bytes, const std::string& path) {
        try {
            return parse_json(is_glb(bytes) ? glb_json(bytes, path) : std::string_view(bytes), path);
        } catch (const Error&) {
            return nullptr;
        }
    }

    template <class Use>
    static void for_each_text(const nlohmann::json& document, const char* list, const char* key, const Use& use) {
        if (!document.is_object() || !document.contains(list) || !document[list].is_array()) return;
        for (const nlohmann::json& item : document[list])
            if (item.is_object() && item.contains(key) && item[key].is_string()) use(item[key].get<std::string>());
    }

    void add(const fs::path& name) {
        const auto known = [&](const SceneFile& file) { return file.name == name.generic_string(); };
        if (std::none_of(files.begin(), files.end(), known))
            files.push_back({name.generic_string(), (folder_ / name).string()});
    }

    void add_gltf(const fs::path& name) {
        add(name);
        const std::string path = (folder_ / name).string();
        std::error_code ignored;
        if (fs::is_regular_file(path, ignored)) add_references_of_gltf(name, parse(read_file(path), path));
    }

    void add_references_of_gltf(const fs::path& name, const nlohmann::json& document) {
        for (const char* list : {"buffers", "images"})
            for_each_text(document, list, "uri", [&](const std::string& uri) {
                if (!uri.starts_with("data:")) add(name.parent_path() / decoded(uri));
            });
    }

    fs::path folder_;
};

} // namespace

std::vector<SceneFile> scene_files(const std::string& path) {
    Finder finder{fs::path(path)};
    finder.add_scene(fs::path(path).filename());
    return finder.files;
}

} // namespace gnomon
