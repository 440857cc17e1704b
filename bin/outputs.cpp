#include "bin/outputs.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <unistd.h>

#include "core/error.h"

namespace gnomon {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view placeholder = "{id}";

fs::path folder_of(const std::string& path) {
    const fs::path folder = fs::path(path).parent_path();
    return folder.empty() ? fs::path(".") : folder;
}

// Permissions say little (root, read-only mounts, /proc): a file is made and removed.
void try_folder(const fs::path& folder, const std::string& target) {
    std::string probe = (folder / ".gnomon-probe-XXXXXX").string();
    const int descriptor = mkstemp(probe.data());
    if (descriptor < 0)
        throw InputError(fmt::format("cannot write '{}': the folder '{}' takes no files ({})", target, folder.string(),
                                     std::strerror(errno)));
    close(descriptor);
    unlink(probe.c_str());
}

// Made later, inside the nearest folder that is there.
void try_missing_folder(fs::path folder, const std::string& target) {
    std::error_code ignored;
    while (!fs::exists(folder, ignored)) {
        const fs::path parent = folder.parent_path();
        folder = parent.empty() || parent == folder ? fs::path(".") : parent;
    }
    if (!fs::is_directory(folder, ignored))
        throw InputError(fmt::format("cannot write '{}': '{}' is no folder", target, folder.string()));
    try_folder(folder, target);
}

bool names_a_folder(const std::string& out) {
    std::error_code ignored;
    return out.ends_with('/') || fs::path(out).extension().empty() || fs::is_directory(out, ignored);
}

OutputFiles single_file(const std::string& label, const std::string& path) {
    const std::string kind = extension(path);
    if (kind == ".exr") return {label, path, "", false};
    if (kind == ".png") return {label, "", path, false};
    throw UsageError(fmt::format("--output is '{}', but images are written as .exr or .png", path));
}

std::string fill_in(std::string text, const std::string& label) {
    for (size_t at = 0; (at = text.find(placeholder, at)) != std::string::npos; at += label.size())
        text.replace(at, placeholder.size(), label);
    return text;
}

} // namespace

std::string extension(const std::string& path) {
    std::string kind = fs::path(path).extension().string();
    std::transform(kind.begin(), kind.end(), kind.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return kind;
}

bool can_hold_several(const std::string& out) {
    return out.find(placeholder) != std::string::npos || names_a_folder(out);
}

std::vector<OutputFiles> plan_outputs(const std::string& out, const std::vector<std::string>& ids) {
    if (out.empty()) throw UsageError("--output is empty; name a file (.exr or .png) or a folder");
    const bool fills = out.find(placeholder) != std::string::npos;
    const bool folder = !fills && names_a_folder(out);
    if (!fills && !folder && ids.size() > 1) {
        single_file("", out); // an unknown extension is the more helpful complaint
        throw UsageError(fmt::format("--output is '{}', but {} techniques need a folder or a name with {{id}} in it",
                                     out, ids.size()));
    }
    std::vector<OutputFiles> plan;
    std::map<std::string, int> seen;
    for (const std::string& id : ids) {
        const int count = ++seen[id];
        const std::string label = count == 1 ? id : fmt::format("{}-{}", id, count);
        if (folder)
            plan.push_back({label, (fs::path(out) / (label + ".exr")).string(),
                            (fs::path(out) / (label + ".png")).string(), true});
        else
            plan.push_back(single_file(label, fill_in(out, label)));
    }
    return plan;
}

void check_writable(const std::string& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) throw InputError(fmt::format("cannot write '{}': it is a folder", path));
    if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored)) return; // a device or a pipe
    const fs::path folder = folder_of(path);
    if (!fs::is_directory(folder, ignored))
        throw InputError(fmt::format("cannot write '{}': there is no folder '{}'", path, folder.string()));
    try_folder(folder, path);
}

void check_writable(const std::vector<OutputFiles>& plan) {
    for (const OutputFiles& files : plan)
        for (const std::string& path : {files.exr, files.png}) {
            std::error_code ignored;
            if (path.empty()) continue;
            if (files.in_folder && !fs::exists(folder_of(path), ignored))
                try_missing_folder(folder_of(path), path);
            else
                check_writable(path);
        }
}

void check_writable_beside(const std::vector<OutputFiles>& plan, const std::string& path) {
    const auto normal = [](const std::string& file) { return fs::absolute(folder_of(file)).lexically_normal(); };
    std::error_code ignored;
    const bool made_later = !plan.empty() && plan.front().in_folder && normal(plan.front().exr) == normal(path) &&
                            !fs::exists(folder_of(path), ignored);
    if (!made_later) check_writable(path);
}

void make_folders(const std::vector<OutputFiles>& plan) {
    for (const OutputFiles& files : plan) {
        if (!files.in_folder) continue;
        const fs::path folder = folder_of(files.exr.empty() ? files.png : files.exr);
        std::error_code error;
        fs::create_directories(folder, error);
        if (error) throw InputError(fmt::format("cannot make the folder '{}': {}", folder.string(), error.message()));
    }
}

} // namespace gnomon
