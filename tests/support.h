#pragma once
// What tests share: the folder of real meshes, visible skipping, a folder for files, and the command line run as a user
// would.

#include <string>
#include <vector>

namespace gnomon_tests {

// Marks the running test as skipped and says why on standard error.
void skip(const std::string& why);
bool skipped();

// Path inside the shared folder, or "" after skip() where it is absent.
std::string shared_path(const std::string& relative);

// A fresh, empty folder for one test, removed at exit.
std::string temporary_folder();

// Runs the gnomon program with these arguments (no shell).
struct ProgramRun {
    int exit_code = -1;
    std::string output; // standard output
    std::string errors; // standard error
};
ProgramRun run_gnomon(const std::vector<std::string>& arguments);

} // namespace gnomon_tests
