#include "tests/support.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <sys/wait.h>
#include <unistd.h>

namespace gnomon_tests {
namespace {

bool any_skipped = false;

struct Folders {
    std::vector<std::string> paths;
    ~Folders() {
        for (const std::string& path : paths) {
            std::error_code ignored;
            std::filesystem::remove_all(path, ignored);
        }
    }
};

std::string slurp(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
}

} // namespace

void skip(const std::string& why) {
    any_skipped = true;
    std::fprintf(stderr, "skipped: %s\n", why.c_str());
}

bool skipped() { return any_skipped; }

std::string shared_path(const std::string& relative) {
    const std::string path = std::string(GNOMON_SHARED) + "/" + relative;
    if (std::filesystem::exists(path)) return path;
    skip("no " + relative + " in the shared folder beside the project");
    return "";
}

std::string temporary_folder() {
    static Folders folders;
    std::string pattern = (std::filesystem::temp_directory_path() / "gnomon-test-XXXXXX").string();
    if (!mkdtemp(pattern.data())) std::abort();
    folders.paths.push_back(pattern);
    return pattern;
}

ProgramRun run_gnomon(const std::vector<std::string>& arguments) {
    const std::string folder = temporary_folder();
    const std::string output = folder + "/stdout", errors = folder + "/stderr";
    const pid_t child = fork();
    if (child == 0) {
        if (!std::freopen(output.c_str(), "wb", stdout) || !std::freopen(errors.c_str(), "wb", stderr)) _exit(126);
        std::vector<char*> argv = {const_cast<char*>(GNOMON_PROGRAM)};
        for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
        argv.push_back(nullptr);
        execv(GNOMON_PROGRAM, argv.data());
        _exit(127);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(output), slurp(errors)};
}

} // namespace gnomon_tests
