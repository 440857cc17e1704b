#pragma once
// Peers that are programs: what they are asked with, print and leave.

#include <filesystem>
#include <string>
#include <vector>

namespace gnomon_bench {

struct Output {
    std::string text; // standard output and standard error
    double peak_mib;  // resident
};

// Runs a command; throws where its exit code is above `allowed`.
Output run(const std::vector<std::string>& command, int allowed = 0);

bool is_installed(const std::string& program);

// The number behind `words`; throws where they are not in the text.
double number_after(const std::string& text, const std::string& words);

// Removed with all that is in it.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    std::string path() const { return path_.string(); }
    std::string file(const std::string& name) const { return (path_ / name).string(); }

private:
    std::filesystem::path path_;
};

} // namespace gnomon_bench
