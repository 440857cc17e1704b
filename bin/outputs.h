#pragma once
// Where results go, decided and tried out before any work is done, so that a misspelt folder does not cost an hour of
// rendering.

#include <string>
#include <vector>

namespace gnomon {

// The files of one technique; an empty name is not written.
struct OutputFiles {
    std::string label; // the technique's id, "-2" behind it where the id came before: "pcf", "pcf-2"
    std::string exr, png;
    bool in_folder = false; // OUT was a folder, which is made where it is missing
};

// One entry per technique id. A name with {id} in it is filled in; a folder gets LABEL.exr and LABEL.png; a single
// technique may have its file named. Throws UsageError for an extension that is neither .exr nor .png, and where
// several would share a file.
std::vector<OutputFiles> plan_outputs(const std::string& out, const std::vector<std::string>& ids);

// Whether `out` is a folder or has {id} in it.
bool can_hold_several(const std::string& out);

// Throws InputError unless a file could be put at `path` now: its folder is there and takes files, and it is no folder
// itself.
void check_writable(const std::string& path);

// The same for all of a plan. OUT as a folder need not exist yet if it can be made.
void check_writable(const std::vector<OutputFiles>& plan);

// The same for a file that may lie in the folder of a plan, which need not exist yet.
void check_writable_beside(const std::vector<OutputFiles>& plan, const std::string& path);

// Makes the folder of a plan whose OUT is one.
void make_folders(const std::vector<OutputFiles>& plan);

// Lower-case extension with its dot, ".exr".
std::string extension(const std::string& path);

} // namespace gnomon
