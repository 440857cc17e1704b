#pragma once
// What a result depends on, as JSON whose bytes are hashed. Paths are no part of it, only what lies there: a study that
// moves to another folder or machine has the same hashes.

#include <string>

#include <nlohmann/json.hpp>

#include "eval/study/study.h"

namespace gnomon {

// Of a file: its name and the bytes of all files that it refers to. Of builtin:NAME: name, parameters and the triangles
// that the program makes of them. Throws InputError, or UsageError for a builtin scene or parameter that is unknown.
nlohmann::ordered_json scene_identity(const std::string& specification);

// `scene` is the view's scene_identity.
nlohmann::ordered_json truth_cell_identity(const std::string& program_version, const nlohmann::ordered_json& scene,
                                           const StudyView& view, const StudyChoice& truth);
nlohmann::ordered_json cell_identity(const std::string& program_version, const nlohmann::ordered_json& scene,
                                     const StudyView& view, const StudyChoice& technique, const StudyChoice& truth,
                                     const std::vector<std::string>& metrics);

// 16 hexadecimal digits. Cells keep their identity beside it, so that two with one hash would be noticed.
std::string identity_hash(const nlohmann::ordered_json& identity);

} // namespace gnomon
