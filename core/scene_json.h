#pragma once
// The lights and cameras of scene documents, read apart from their objects.

#include <filesystem>

#include "core/json_reader.h"
#include "core/scene.h"

namespace gnomon {

// Appends lights[i] to the scene, with a unique name; image files are looked for in `folder`. Throws InputError.
void read_light(const JsonReader& light, const std::filesystem::path& folder, Scene& scene);
void read_camera(const JsonReader& camera, Scene& scene);

} // namespace gnomon
