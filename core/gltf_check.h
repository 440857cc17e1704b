#pragma once
// The structure of a glTF document, checked before anything follows its indices: tinygltf trusts several of them, and
// its complaints do not name the place.

#include <cstddef>
#include <string>
#include <string_view>

#include "core/json_reader.h"

namespace gnomon {

// The JSON chunk of a GLB file whose header and chunks lie inside the file. Throws InputError.
std::string_view glb_json(std::string_view bytes, const std::string& file);
bool is_glb(std::string_view bytes);

// Throws InputError where a reference points at nothing, a range leaves its buffer, a value has the wrong type, or a
// required extension is one that the loader does not read.
void check_gltf(const JsonReader& document);

// Bytes of a component type (5120 …), components of a type ("VEC3"); 0 for what glTF does not know.
size_t component_bytes(int component_type);
size_t component_count(std::string_view type);

} // namespace gnomon
