#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "core/scene_files.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

void write(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

std::vector<std::string> names_of(const std::string& path) {
    std::vector<std::string> names;
    for (const SceneFile& file : scene_files(path)) {
        CHECK(file.path == std::filesystem::path(path).parent_path().string() + "/" + file.name);
        names.push_back(file.name);
    }
    return names;
}

} // namespace

TEST_CASE("a scene's files are found without loading it", "[core]") {
    const std::string folder = temporary_folder();
    std::filesystem::create_directory(folder + "/meshes");
    write(folder + "/meshes/a.gltf",
          R"({"asset": {"version": "2.0"}, "buffers": [{"uri": "a%20b.bin"}, {"uri": "data:abc"}, {}],
        "images": [{"uri": "t/skin.png"}, {"uri": "a%20b.bin"}]})");
    write(folder + "/scene.json", R"({"objects": [{"gltf": "meshes/a.gltf"}, {"gltf": "gone.glb"}, {"shape": "box"}],
        "lights": [{"image": "glass.exr"}]})");
    CHECK(names_of(folder + "/meshes/a.gltf") == std::vector<std::string>{"a.gltf", "a b.bin", "t/skin.png"});
    CHECK(names_of(folder + "/scene.json") == std::vector<std::string>{"scene.json", "meshes/a.gltf", "meshes/a b.bin",
                                                                       "meshes/t/skin.png", "gone.glb", "glass.exr"});
    write(folder + "/broken.glb", "no glTF");
    CHECK(names_of(folder + "/broken.glb") == std::vector<std::string>{"broken.glb"});
    CHECK_THROWS_AS(scene_files(folder + "/nowhere.glb"), InputError);
}
