#include "core/scene_load.h"
namespace gnomon {
Scene load_scene_json(const std::string& path) {
    throw InputError(path + ": scene documents are not readable yet; use .glb");
}
} // namespace gnomon
