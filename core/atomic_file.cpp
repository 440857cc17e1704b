#include "core/atomic_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "core/error.h"

namespace gnomon {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_to_write(const std::string& path, const std::string& why) {
    throw InputError(fmt::format("cannot write '{}': {}", path, why));
}

// An empty file of an unused name in `folder`, with the permissions the user's umask gives; removed with this object
// unless kept. The name does not lean on the target's, which may already be as long as the file system allows.
class TemporaryFile {
public:
    TemporaryFile(const std::string& target, const fs::path& folder, const fs::path& extension) {
        int descriptor = -1;
        for (int attempt = 0; descriptor < 0; ++attempt) {
            path_ = folder / fmt::format(".gnomon-{}-{}{}", getpid(), attempt, extension.string());
            descriptor = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
            if (descriptor < 0 && errno != EEXIST) fail_to_write(target, std::strerror(errno));
        }
        close(descriptor);
    }
    ~TemporaryFile() {
        std::error_code ignored;
        if (!kept_) fs::remove(path_, ignored);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    const fs::path& path() const { return path_; }
    void keep() { kept_ = true; }

private:
    fs::path path_;
    bool kept_ = false;
};

void flush_to_disk(const fs::path& path, const std::string& target) {
    const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) fail_to_write(target, std::strerror(errno));
    const bool failed = fsync(descriptor) != 0 && errno != EINVAL && errno != EROFS;
    const int reason = errno;
    close(descriptor);
    if (failed) fail_to_write(target, std::strerror(reason));
}

void copy_bytes(const fs::path& from, const std::string& to) {
    std::ofstream out(to, std::ios::binary);
    std::ifstream in(from, std::ios::binary);
    if (in.peek() != std::ifstream::traits_type::eof()) out << in.rdbuf();
    out.close();
    if (!out) fail_to_write(to, "the device or pipe does not take it");
}

} // namespace

void write_atomically(const std::string& path, const std::function<void(const std::string&)>& write) {
    if (path.empty()) throw InputError("cannot write a file without a name");
    std::error_code ignored;
    // A link is written through, as any other program would.
    const fs::path target = fs::is_symlink(path, ignored) ? fs::weakly_canonical(path, ignored) : fs::path(path);
    const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
    if (!fs::is_directory(folder, ignored))
        fail_to_write(path, fmt::format("there is no folder '{}'", folder.string()));
    if (fs::is_directory(target, ignored) || !target.has_filename()) fail_to_write(path, "it is a folder");
    const bool exists = fs::exists(target, ignored);
    if (exists && access(target.c_str(), W_OK) != 0) fail_to_write(path, std::strerror(errno));

    if (exists && !fs::is_regular_file(target, ignored)) { // /dev/stdout, a pipe: renaming over it would remove it
        const TemporaryFile temporary(path, fs::temp_directory_path(), target.extension());
        write(temporary.path().string());
        return copy_bytes(temporary.path(), path);
    }
    TemporaryFile temporary(path, folder, target.extension());
    write(temporary.path().string());
    flush_to_disk(temporary.path(), path);
    std::error_code error;
    fs::rename(temporary.path(), target, error);
    if (error) fail_to_write(path, error.message());
    temporary.keep();
}

void write_text_file(const std::string& path, std::string_view text) {
    write_atomically(path, [&](const std::string& temporary_path) {
        std::ofstream file(temporary_path, std::ios::binary);
        file.write(text.data(), static_cast<std::streamsize>(text.size()));
        file.close();
        if (!file) fail_to_write(path, std::strerror(errno));
    });
}

std::string read_file(const std::string& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) throw InputError(fmt::format("cannot read '{}': it is a folder", path));
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    if (!file) throw InputError(fmt::format("cannot read '{}': {}", path, std::strerror(errno)));
    std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (file.bad()) throw InputError(fmt::format("cannot read '{}': {}", path, std::strerror(errno)));
    return text;
}

} // namespace gnomon
