#pragma once
// What tests of the command line share: files of a folder, broken inputs, and the shape of a failure.

#include <map>
#include <string>
#include <vector>

#include "tests/support.h"

namespace gnomon_tests {

// Relative path → bytes of every file under `folder`.
std::map<std::string, std::string> files_in(const std::string& folder);

void write_bytes(const std::string& path, const std::string& bytes);
std::string read_bytes(const std::string& path);

// A binary glTF of one mesh. `positions` are floats, three a vertex.
std::string make_glb(const std::vector<float>& positions, const std::vector<unsigned>& indices);

// Requires the exit code, exactly one line "gnomon: …" on standard error with `words` in it, and nothing on standard
// output.
void check_failure(const std::vector<std::string>& arguments, int exit_code, const std::string& words);

// Runs and requires exit code 0; returns standard output.
std::string check_success(const std::vector<std::string>& arguments);

// The same, and how long it took.
double milliseconds_of(const std::vector<std::string>& arguments);

// Starts the program and ends it by `signal` after so many milliseconds, unless it is done before; its exit code, or
// 128 + the signal that it died of.
int run_and_stop(const std::vector<std::string>& arguments, int milliseconds, int signal);

// The JSON text without what differs from run to run: every "seconds", and the resident memory.
std::string without_times(const std::string& json);

} // namespace gnomon_tests
