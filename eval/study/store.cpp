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

// A scratch folder with a lock that is held; the descriptor, or −1 where another run took it for abandoned meanwhile.
int try_scratch(const std::string& parent, std::string& folder) {
    folder = parent + "/run-XXXXXX";
    if (!mkdtemp(folder.data())) fail_to_write(parent, std::strerror(errno));
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
    descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0 || lock(descriptor_, wait)) return;
    close(descriptor_);
    descriptor_ = -1;
}

// Whoever waits for the file that is unlinked here gets its lock, finds the truth there and goes on.
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

void StudyStore::make_folder(const std::string& name) {
    std::error_code error;
    const std::string folder = name.empty() ? folder_ : path(name);
    fs::create_directories(folder, error);
    if (error) fail_to_write(folder, error.message());
}

void StudyStore::remove_abandoned() const {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(path("scratch"), ignored))
        remove_if_abandoned(entry.path());
    fs::remove(path("scratch"), ignored); // unless another run is there
}

const std::string& StudyStore::scratch() {
    if (!scratch_.empty()) return scratch_;
    make_folder("scratch");
    for (int attempt = 0; attempt < 100 && scratch_lock_ < 0; ++attempt) {
        make_folder("scratch");
        scratch_lock_ = try_scratch(path("scratch"), scratch_);
    }
    if (scratch_lock_ < 0) fail_to_write(std::exchange(scratch_, ""), "its scratch folder vanishes again and again");
    return scratch_;
}

std::optional<ordered_json> StudyStore::result(const std::string& hash) const {
    const std::string folder = path("cells/" + hash);
    std::error_code ignored;
    if (!fs::is_regular_file(folder + "/result.json", ignored)) return {};
    ordered_json result = ordered_json::parse(read_file(folder + "/result.json"), nullptr, false);
    if (!result.is_object() || !result.contains("status") || !result.contains("identity")) return {};
    if (!result.contains("visibility_bytes")) return result;
    const std::uintmax_t size = fs::file_size(folder + "/visibility.exr", ignored);
    if (ignored || result["visibility_bytes"] != size) return {};
    return result;
}

ordered_json StudyStore::timing(const std::string& hash) const {
    const std::string file = path("cells/" + hash + "/timing.json");
    std::error_code ignored;
    return fs::is_regular_file(file, ignored) ? ordered_json::parse(read_file(file), nullptr, false) : ordered_json();
}

void StudyStore::put_cell(const std::string& hash, ordered_json result, const ordered_json& timing,
                          const ChannelImage* image) {
    make_folder("cells");
    const std::string made = scratch() + "/" + hash, place = path("cells/" + hash);
    fs::create_directories(made);
    if (image) {
        write_exr(made + "/visibility.exr", *image);
        result["visibility_bytes"] = fs::file_size(made + "/visibility.exr");
    }
    write_text_file(made + "/timing.json", dump(timing));
    write_text_file(made + "/result.json", dump(result));
    std::error_code error;
    fs::rename(made, place, error);
    if (!error) return;
    // Something is there: an older failure, a cell of which the half was copied, or what another run made meanwhile.
    fs::rename(place, scratch() + "/" + hash + ".replaced", error);
    fs::rename(made, place, error);
    fs::remove_all(scratch() + "/" + hash + ".replaced");
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

TruthClaim StudyStore::claim_truth(const std::string& hash, bool wait) {
    make_folder("claims");
    return {path("claims/" + hash), wait};
}

void StudyStore::tidy(const std::string& truth_hash) {
    std::error_code ignored;
    if (!fs::exists(path("claims/" + truth_hash), ignored) ||
        !fs::exists(path("truths/" + truth_hash + ".exr"), ignored))
        return;
    if (const TruthClaim claim(path("claims/" + truth_hash), false); claim.held())
        fs::remove(truth_state(truth_hash), ignored);
}

void StudyStore::put_text(const std::string& name, const std::string& text) {
    std::error_code error;
    if (fs::is_regular_file(path(name), error) && read_file(path(name)) == text) return;
    make_folder("");
    const std::string made = scratch() + "/" + name;
    write_text_file(made, text);
    fs::rename(made, path(name), error);
    if (error) fail_to_write(path(name), error.message());
}

std::string StudyStore::text(const std::string& name) const { return read_file(path(name)); }

} // namespace gnomon
