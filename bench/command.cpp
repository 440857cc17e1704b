#include "bench/command.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <stdexcept>

#include <fmt/format.h>

namespace gnomon_bench {

Output run(const std::vector<std::string>& command, int allowed) {
    std::array<int, 2> ends{};
    if (pipe(ends.data()) != 0) throw std::runtime_error("there is no pipe");
    const pid_t child = fork();
    if (child == 0) {
        dup2(ends[1], STDOUT_FILENO), dup2(ends[1], STDERR_FILENO);
        close(ends[0]), close(ends[1]);
        std::vector<char*> arguments;
        for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
        arguments.push_back(nullptr);
        execvp(arguments[0], arguments.data());
        _exit(127);
    }
    close(ends[1]);
    Output output{"", 0};
    std::array<char, 4096> buffer{};
    for (ssize_t got; (got = read(ends[0], buffer.data(), buffer.size())) > 0;)
        output.text.append(buffer.data(), static_cast<size_t>(got));
    close(ends[0]);
    int status = 0;
    rusage usage{};
    wait4(child, &status, 0, &usage);
    if (!WIFEXITED(status) || WEXITSTATUS(status) > allowed)
        throw std::runtime_error(fmt::format("'{}' failed: {}", fmt::join(command, " "), output.text));
    output.peak_mib = static_cast<double>(usage.ru_maxrss) / 1024.0;
    return output;
}

bool is_installed(const std::string& program) {
    const std::string path = std::getenv("PATH") ? std::getenv("PATH") : "";
    for (size_t first = 0; first < path.size();) {
        const size_t end = std::min(path.find(':', first), path.size());
        if (access((path.substr(first, end - first) + "/" + program).c_str(), X_OK) == 0) return true;
        first = end + 1;
    }
    return false;
}

double number_after(const std::string& text, const std::string& words) {
    const size_t at = text.find(words);
    if (at == std::string::npos) throw std::runtime_error(fmt::format("no '{}' in: {}", words, text));
    return std::strtod(text.c_str() + at + words.size(), nullptr);
}

TemporaryFolder::TemporaryFolder()
    : path_(std::filesystem::temp_directory_path() / fmt::format("gnomon-bench-{}", getpid())) {
    std::filesystem::create_directory(path_);
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

} // namespace gnomon_bench
