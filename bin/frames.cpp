#include "bin/frames.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "bin/outputs.h"
#include "core/error.h"

namespace gnomon {
namespace {

namespace fs = std::filesystem;

bool is_folder(const std::string& name) {
    std::error_code ignored;
    return fs::is_directory(name, ignored);
}

// Numbers sort by value: fewer digits first, once leading zeros are gone.
struct FrameOrder {
    bool operator()(const std::string& a, const std::string& b) const {
        const auto is_number = [](const std::string& text) {
            return text.find_first_not_of("0123456789") == std::string::npos;
        };
        if (!is_number(a) || !is_number(b)) return a < b;
        return a.size() != b.size() ? a.size() < b.size() : a < b;
    }
};
using Frames = std::map<std::string, std::string, FrameOrder>; // name → path

bool is_image(const std::string& name) {
    constexpr std::string_view known[] = {".exr", ".png", ".hdr", ".tif", ".tiff", ".jpg", ".jpeg", ".pfm"};
    return std::find(std::begin(known), std::end(known), extension(name)) != std::end(known);
}

Frames files_of_folder(const std::string& folder) {
    Frames frames;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (entry.is_regular_file() && is_image(entry.path().string()))
            frames[entry.path().filename().string()] = entry.path().string();
    return frames;
}

Frames files_of_pattern(const std::string& pattern) {
    const fs::path path(pattern);
    const std::string name = path.filename().string();
    const size_t first = name.find('#'), end = name.find_first_not_of('#', first);
    const std::string before = name.substr(0, first), after = end == std::string::npos ? "" : name.substr(end);
    const size_t least_digits = (end == std::string::npos ? name.size() : end) - first;
    const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
    Frames frames;
    if (after.find('#') != std::string::npos || first == std::string::npos)
        throw UsageError(
            fmt::format("'{}' must have one run of # in the file's name, for the frame's number", pattern));
    if (!is_folder(folder.string())) throw InputError(fmt::format("there is no folder '{}'", folder.string()));
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        const std::string file = entry.path().filename().string();
        if (file.size() < before.size() + least_digits + after.size() || !file.starts_with(before) ||
            !file.ends_with(after))
            continue;
        std::string number = file.substr(before.size(), file.size() - before.size() - after.size());
        if (number.find_first_not_of("0123456789") != std::string::npos) continue;
        number.erase(0, std::min(number.find_first_not_of('0'), number.size() - 1));
        const auto [place, is_new] = frames.emplace(number, path.has_parent_path() ? entry.path().string() : file);
        if (!is_new) throw InputError(fmt::format("'{}' and '{}' are both frame {}", place->second, file, number));
    }
    return frames;
}

void check_counterparts(const Frames& frames, const Frames& others, const std::string& other_name) {
    for (const auto& [name, path] : frames)
        if (!others.contains(name)) throw InputError(fmt::format("'{}' has no counterpart in '{}'", path, other_name));
}

} // namespace

bool is_sequence(const std::string& name) {
    std::error_code ignored;
    return is_folder(name) || (name.find('#') != std::string::npos && !fs::exists(name, ignored));
}

std::vector<FramePair> pair_frames(const std::string& test, const std::string& reference) {
    if (is_folder(test) != is_folder(reference) || !is_sequence(test) || !is_sequence(reference))
        throw UsageError(fmt::format("'{}' and '{}' must both be images, both folders, or both names with # for the "
                                     "frame's number",
                                     test, reference));
    const bool folders = is_folder(test);
    const Frames tests = folders ? files_of_folder(test) : files_of_pattern(test);
    const Frames references = folders ? files_of_folder(reference) : files_of_pattern(reference);
    check_counterparts(tests, references, reference);
    check_counterparts(references, tests, test);
    if (tests.empty()) throw InputError(fmt::format("there are no frames in '{}'", test));
    std::vector<FramePair> pairs;
    for (const auto& [name, path] : tests) pairs.push_back({name, path, references.at(name)});
    return pairs;
}

} // namespace gnomon
