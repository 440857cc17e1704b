#include "tests/bin/cli.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

namespace gnomon_tests {
namespace {

template <class T> void append(std::string& bytes, const std::vector<T>& values) {
    const size_t at = bytes.size();
    bytes.resize(at + values.size() * sizeof(T));
    if (!values.empty()) std::memcpy(bytes.data() + at, values.data(), values.size() * sizeof(T));
}

void append_chunk(std::string& file, const char* type, std::string bytes, char padding) {
    while (bytes.size() % 4) bytes += padding;
    append(file, std::vector<std::uint32_t>{static_cast<std::uint32_t>(bytes.size())});
    file += std::string(type, 4) + bytes;
}

void strip_times(nlohmann::json& json) {
    if (json.is_object()) json.erase("seconds"), json.erase("peak_resident_bytes");
    for (auto& child : json)
        if (child.is_structured()) strip_times(child);
}

} // namespace

std::map<std::string, std::string> files_in(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            files[std::filesystem::relative(entry.path(), folder).string()] = read_bytes(entry.path().string());
    return files;
}

void write_bytes(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

std::string read_bytes(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    REQUIRE(file);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string make_glb(const std::vector<float>& positions, const std::vector<unsigned>& indices) {
    std::string binary;
    append(binary, positions);
    append(binary, indices);
    const size_t position_bytes = positions.size() * sizeof(float), index_bytes = indices.size() * sizeof(unsigned);
    const nlohmann::json json = {
        {"asset", {{"version", "2.0"}}},
        {"scene", 0},
        {"scenes", {{{"nodes", {0}}}}},
        {"nodes", {{{"mesh", 0}}}},
        {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}},
        {"buffers", {{{"byteLength", binary.size()}}}},
        {"bufferViews",
         {{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", position_bytes}},
          {{"buffer", 0}, {"byteOffset", position_bytes}, {"byteLength", index_bytes}}}},
        {"accessors",
         {{{"bufferView", 0},
           {"componentType", 5126},
           {"count", positions.size() / 3},
           {"type", "VEC3"},
           {"min", {-100, -100, -100}},
           {"max", {100, 100, 100}}},
          {{"bufferView", 1}, {"componentType", 5125}, {"count", indices.size()}, {"type", "SCALAR"}}}},
    };
    std::string chunks, file = "glTF";
    append_chunk(chunks, "JSON", json.dump(), ' ');
    append_chunk(chunks, "BIN\0", binary, '\0');
    append(file, std::vector<std::uint32_t>{2, static_cast<std::uint32_t>(12 + chunks.size())});
    return file + chunks;
}

void check_failure(const std::vector<std::string>& arguments, int exit_code, const std::string& words) {
    std::string command = "gnomon";
    for (const std::string& argument : arguments) command += " " + argument;
    const ProgramRun run = run_gnomon(arguments);
    INFO(command << "\n" << run.errors);
    CHECK(run.exit_code == exit_code);
    CHECK(run.output.empty());
    CHECK(std::count(run.errors.begin(), run.errors.end(), '\n') == 1);
    CHECK(run.errors.starts_with("gnomon: "));
    CHECK(run.errors.find(words) != std::string::npos);
}

std::string check_success(const std::vector<std::string>& arguments) {
    std::string command = "gnomon";
    for (const std::string& argument : arguments) command += " " + argument;
    const ProgramRun run = run_gnomon(arguments);
    INFO(command << "\n" << run.errors);
    REQUIRE(run.exit_code == 0);
    return run.output;
}

double milliseconds_of(const std::vector<std::string>& arguments) {
    const auto start = std::chrono::steady_clock::now();
    check_success(arguments);
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

int run_and_stop(const std::vector<std::string>& arguments, int milliseconds, int signal) {
    const pid_t child = fork();
    if (child == 0) {
        std::vector<char*> argv = {const_cast<char*>(GNOMON_PROGRAM)};
        for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
        argv.push_back(nullptr);
        if (!freopen("/dev/null", "w", stderr) || !freopen("/dev/null", "w", stdout)) _exit(97);
        execv(GNOMON_PROGRAM, argv.data());
        _exit(98);
    }
    REQUIRE(child > 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    kill(child, signal);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

std::string without_times(const std::string& json) {
    nlohmann::json parsed = nlohmann::json::parse(json);
    strip_times(parsed);
    return parsed.dump(1);
}

} // namespace gnomon_tests
