#pragma once
// Which files a scene is made of, found without loading it: for those who must know whether it has changed.

#include <string>
#include <vector>

namespace gnomon {

struct SceneFile {
    std::string name; // of the scene file without its folder; of the others as seen from that folder
    std::string path;
};

// The .gltf, .glb or .json file itself, then the buffers, images and glTF files that it refers to, each once, in the
// order of the document. Those that are missing are listed too; what a broken document refers to is not. Throws
// InputError where the file itself cannot be read.
std::vector<SceneFile> scene_files(const std::string& path);

} // namespace gnomon
