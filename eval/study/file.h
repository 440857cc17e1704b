#pragma once
// The document of a study, read and checked, before scenes are looked at and blocks are multiplied out.

#include <string>
#include <vector>

#include "eval/study/study.h"

namespace gnomon {

// One element of a list, with what the tables call it.
struct NamedScene {
    std::string name, scene; // scene: a path that is good from here, or builtin:…
    nlohmann::ordered_json identity;
    std::string missing; // of an optional scene: a file that is not there, else ""
};
struct NamedOptions {
    std::string name;
    ParameterText options;
};

// One point of a technique's grid.
struct StudyVariant {
    StudyChoice choice;
    nlohmann::ordered_json varied = nlohmann::ordered_json::object(); // the parameters that the grid varies
};

struct StudyBlock {
    std::string name;
    std::vector<NamedScene> scenes;
    std::vector<NamedOptions> cameras, lights;
    std::vector<std::string> sizes;
    std::string primary;
    std::vector<StudyVariant> truths, techniques;
    std::vector<std::string> metrics;
};

struct StudyFile {
    std::string name;
    std::vector<StudyBlock> blocks;
    nlohmann::json questions; // the keys of question_keys() that it has
};

// Throws InputError.
StudyFile read_study_file(const std::string& path, const StudyProgram& program);

} // namespace gnomon
