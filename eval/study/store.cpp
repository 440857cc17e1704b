#include "eval/study/store.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/atomic_file.h"

namespace gnomon {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

[[noreturn]] void fail_to_write(const std::string& path, const std::string& why) {
    throw InputError(fmt::format("cannot write '{}': {}", path, why));
}

std::string dump(const ordered_json& json) {
    return json.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

// Runs that share a study's folder remove what they leave empty, and put cells where others put them: whatever is to be
// made there is tried again.
constexpr int attempts = 1000;

void make_folders(const std::string& folder) {
    std::error_code error;
    for (int attempt = 0; attempt < attempts; ++attempt) {
        std::error_code ignored;
        fs::create_directories(folder, error);
        if (!error) return;
        const bool vanished = error == std::errc::no_such_file_or_directory ||
                              (error == std::errc::file_exists && !fs::exists(folder, ignored));
        if (!vanished) break;
    }
    fail_to_write(folder, error.message());
}

// Nothing where the file is not there, or no longer.
std::optional<std::string> read_if_there(const std::string& file) {
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) return {};
    try {
        return read_file(file);
    } catch (const InputError&) {
        if (fs::exists(file, ignored)) throw;
        return {};
    }
}

// Locks end with the process that holds them, however it ends.
bool lock(int descriptor, bool wait) {
    int result = 0;
    do {
        result = flock(descriptor, LOCK_EX | (wait ? 0 : LOCK_NB));
    } while (result != 0 && errno == EINTR);
    return result == 0;
}

// Removes what a run left behind that is no more: nobody holds the lock in its scratch folder.
void remove_if_abandoned(const fs::path& folder) {
    std::error_code ignored;
    const int descriptor = open((folder / "lock").c_str(), O_RDWR | O_CLOEXEC);
    if (descriptor < 0) {
        fs::remove(folder, ignored); // only where it is empty: a run may just be making it
        return;
    }
    if (lock(descriptor, false)) fs::remove_all(folder, ignored);
    close(descriptor);
}

bool same_file(int descriptor, const std::string& path) {
    struct stat held {
    }, named{};
    return fstat(descriptor, &held) == 0 && stat(path.c_str(), &named) == 0 && held.st_ino == named.st_ino &&
           held.st_dev == named.st_dev;
}

// A scratch folder with a lock that is held; the descriptor, or −1 where another run took it for abandoned meanwhile,
// or its parent.
int try_scratch(const std::string& parent, std::string& folder) {
    make_folders(parent);
    folder = parent + "/run-XXXXXX";
    if (!mkdtemp(folder.data())) {
        if (errno == ENOENT) return -1;
        fail_to_write(parent, std::strerror(errno));
    }
    const std::string name = folder + "/lock";
    const int descriptor = open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor < 0) return -1;
    const bool locked = lock(descriptor, false) || (errno != EWOULDBLOCK && fs::exists(name)); // or there are no locks
    if (locked && same_file(descriptor, name)) return descriptor;
    close(descriptor);
    return -1;
}

} // namespace

TruthClaim::TruthClaim(std::string path, bool wait) : path_(std::move(path)) {
    for (int attempt = 0; attempt < attempts; ++attempt) {
        make_folders(fs::path(path_).parent_path());
        descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (descriptor_ < 0 && errno != ENOENT) return;
        const bool locked = descriptor_ >= 0 && lock(descriptor_, wait);
        if (locked && same_file(descriptor_, path_)) return;
        const bool known = descriptor_ >= 0 && !locked; // held by another, or there are no locks
        if (descriptor_ >= 0) close(descriptor_);
        descriptor_ = -1;
        if (known) return;
    }
}

// Whoever waits for the file that is unlinked here makes another, finds the truth there and goes on.
TruthClaim::~TruthClaim() {
    if (descriptor_ < 0) return;
    unlink(path_.c_str());
    close(descriptor_);
    rmdir(fs::path(path_).parent_path().c_str()); // unless others are there
}

StudyStore::~StudyStore() {
    if (scratch_.empty()) return;
    std::error_code ignored;
    fs::remove_all(scratch_, ignored);
    close(scratch_lock_);
    fs::remove(path("scratch"), ignored); // unless another run is there
}

void StudyStore::make_folder(const std::string& name) { make_folders(name.empty() ? folder_ : path(name)); }

void StudyStore::remove_abandoned() const {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(path("scratch"), ignored))
        remove_if_abandoned(entry.path());
    fs::remove(path("scratch"), ignored); // unless another run is there
}

const std::string& StudyStore::scratch() {
    if (!scratch_.empty()) return scratch_;
    for (int attempt = 0; attempt < attempts && scratch_lock_ < 0; ++attempt)
        scratch_lock_ = try_scratch(path("scratch"), scratch_);
    if (scratch_lock_ < 0) fail_to_write(std::exchange(scratch_, ""), "its scratch folder vanishes again and again");
    return scratch_;
}

std::optional<ordered_json> StudyStore::result(const std::string& hash) const {
    const std::string folder = path("cells/" + hash);
    const std::optional<std::string> text = read_if_there(folder + "/result.json");
    if (!text) return {};
    ordered_json result = ordered_json::parse(*text, nullptr, false);
    if (!result.is_object() || !result.contains("status") || !result.contains("identity")) return {};
    if (!result.contains("visibility_bytes")) return result;
    std::error_code missing;
    const std::uintmax_t size = fs::file_size(folder + "/visibility.exr", missing);
    if (missing || result["visibility_bytes"] != size) return {};
    return result;
}

ordered_json StudyStore::timing(const std::string& hash) const {
    const std::optional<std::string> text = read_if_there(path("cells/" + hash + "/timing.json"));
    return text ? ordered_json::parse(*text, nullptr, false) : ordered_json();
}

void StudyStore::put_cell(const std::string& hash, ordered_json result, const ordered_json& timing,
                          const ChannelImage* image) {
    make_folder("cells");
    const std::string made = scratch() + "/" + hash, place = path("cells/" + hash), replaced = made + ".replaced";
    fs::create_directories(made);
    if (image) {
        write_exr(made + "/visibility.exr", *image);
        result["visibility_bytes"] = fs::file_size(made + "/visibility.exr");
    }
    write_text_file(made + "/timing.json", dump(timing));
    write_text_file(made + "/result.json", dump(result));
    std::error_code error;
    for (int attempt = 0; attempt < attempts; ++attempt) {
        fs::rename(made, place, error);
        if (error != std::errc::directory_not_empty && error != std::errc::file_exists) break;
        // Something is there: an older failure, a cell of which the half was copied, or what another run made
        // meanwhile.
        std::error_code ignored;
        fs::rename(place, replaced, ignored);
        fs::remove_all(replaced, ignored);
    }
    if (error) fail_to_write(place, error.message());
}

std::optional<ChannelImage> StudyStore::truth(const std::string& hash) const {
    const std::string file = path("truths/" + hash + ".exr");
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) return {};
    try {
        return read_image(file);
    } catch (const InputError&) { // a copy that was cut short
        return {};
    }
}

void StudyStore::put_truth(const std::string& hash, const ChannelImage& image) {
    make_folder("truths");
    const std::string made = scratch() + "/" + hash + ".exr", place = path("truths/" + hash + ".exr");
    write_exr(made, image);
    std::error_code error;
    fs::rename(made, place, error);
    if (error) fail_to_write(place, error.message());
}

TruthClaim StudyStore::claim_truth(const std::string& hash, bool wait) { return {path("claims/" + hash), wait}; }

void StudyStore::tidy(const std::string& truth_hash) {
    std::error_code ignored;
    if (!fs::exists(path("claims/" + truth_hash), ignored) ||
        !fs::exists(path("truths/" + truth_hash + ".exr"), ignored))
        return;
    if (const TruthClaim claim(path("claims/" + truth_hash), false); claim.held())
        fs::remove(truth_state(truth_hash), ignored);
}

void StudyStore::put_text(const std::string& name, const std::string& text) {
    if (read_if_there(path(name)) == text) return;
    make_folder("");
    const std::string made = scratch() + "/" + name;
    write_text_file(made, text);
    std::error_code error;
    fs::rename(made, path(name), error);
    if (error) fail_to_write(path(name), error.message());
}

std::string StudyStore::text(const std::string& name) const { return read_file(path(name)); }

} // namespace gnomon
