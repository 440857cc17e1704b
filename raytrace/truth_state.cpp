#include "raytrace/truth_state.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "core/atomic_file.h"
#include "core/digest.h"
#include "core/error.h"

namespace gnomon {
namespace {

constexpr std::string_view first_line = "gnomon truth state 1\n";
constexpr std::uint32_t record_mark = 0x474e4f4d;

struct RecordHead {
    std::uint32_t mark = record_mark;
    std::uint32_t light = 0;
    std::uint64_t tile = 0, size = 0, checksum = 0;
};
static_assert(sizeof(RecordHead) == 32);

std::uint64_t checksum(RecordHead head, std::span<const unsigned char> payload) {
    Digest digest;
    head.checksum = 0;
    digest.add(head);
    digest.add_all(payload);
    return digest.value();
}

[[noreturn]] void fail_to_save(const std::string& path, const std::string& why) {
    throw InputError(fmt::format("cannot save the state of the run in '{}': {}", path, why));
}

void write_whole(int file, std::span<const unsigned char> bytes, const std::string& path) {
    while (!bytes.empty()) {
        const ssize_t written = write(file, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) fail_to_save(path, std::strerror(errno));
        bytes = bytes.subspan(static_cast<size_t>(written));
    }
}

bool read_whole(int file, std::uint64_t offset, void* bytes, size_t size) {
    auto* at = static_cast<char*>(bytes);
    while (size > 0) {
        const ssize_t got = pread(file, at, size, static_cast<off_t>(offset));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return false;
        at += got, offset += static_cast<std::uint64_t>(got), size -= static_cast<size_t>(got);
    }
    return true;
}

// Throws InputError naming the first thing that differs.
void compare(const nlohmann::ordered_json& saved, const nlohmann::ordered_json& wanted, const std::string& path) {
    for (const auto& [key, value] : wanted.items())
        if (!saved.contains(key) || saved[key] != value)
            throw InputError(fmt::format("'{}' belongs to another run: its {} is {}, this run's is {}; resume with the "
                                         "same settings, or start over without --resume",
                                         path, key, saved.contains(key) ? saved[key].dump() : "not there",
                                         value.dump()));
    for (const auto& [key, value] : saved.items())
        if (!wanted.contains(key))
            throw InputError(fmt::format("'{}' belongs to another run: it has a {}, this run has none; start over "
                                         "without --resume",
                                         path, key));
}

std::string light_digest(const Light& light) {
    Digest digest;
    digest.add(light.type);
    for (const vec3 v : {light.position, light.direction, light.tangent, light.intensity}) digest.add(v);
    digest.add(light.size);
    for (const float f : {light.inner_cone, light.outer_cone, light.range}) digest.add(f);
    digest.add_all(light.texture.values());
    digest.add_all(std::span<const LightTriangle>(light.triangles));
    return digest.text();
}

} // namespace

nlohmann::ordered_json truth_identity(const Scene& scene, const Receivers& receivers, std::span<const Light> lights) {
    Digest casters, points;
    casters.add_all(std::span<const vec3>(scene.positions));
    casters.add_all(std::span<const uvec3>(scene.triangles));
    for (const Object& object : scene.objects)
        if (object.light_source) casters.add(object.first_triangle), casters.add(object.triangle_count);
    static_assert(sizeof(Receiver) == 28); // no padding
    points.add_all(receivers.values());
    nlohmann::ordered_json identity = {{"scene", casters.text()},
                                       {"size", fmt::format("{}x{}", receivers.width(), receivers.height())},
                                       {"view", points.text()}};
    for (size_t i = 0; i < lights.size(); ++i)
        identity[fmt::format("light {}", i + 1)] = lights[i].name + " " + light_digest(lights[i]);
    return identity;
}

TruthState::TruthState(std::string path, nlohmann::ordered_json identity, bool resume, double seconds_between_saves)
    : path_(std::move(path)), header_(std::string(first_line) + identity.dump() + "\n"), identity_(std::move(identity)),
      seconds_between_saves_(seconds_between_saves), saved_(std::chrono::steady_clock::now()) {
    std::error_code ignored;
    if (resume && std::filesystem::exists(path_, ignored)) read();
}

TruthState::~TruthState() {
    if (file_ >= 0) close(file_);
}

void TruthState::read() {
    const auto is_none = [&]() -> void {
        throw InputError(fmt::format("cannot resume from '{}': it is no state of a run", path_));
    };
    std::ifstream text(path_, std::ios::binary);
    std::string first, second;
    if (!std::getline(text, first) || first + "\n" != first_line || !std::getline(text, second)) is_none();
    const auto saved = nlohmann::ordered_json::parse(second, nullptr, false);
    if (!saved.is_object()) is_none();
    compare(saved, identity_, path_);
    file_ = open(path_.c_str(), O_RDWR | O_CLOEXEC);
    if (file_ < 0) throw InputError(fmt::format("cannot resume from '{}': {}", path_, std::strerror(errno)));

    std::uint64_t end = first.size() + second.size() + 2;
    const std::uint64_t size = std::filesystem::file_size(path_);
    std::vector<unsigned char> payload;
    for (RecordHead head; read_whole(file_, end, &head, sizeof head);) {
        const std::uint64_t start = end + sizeof head;
        if (head.mark != record_mark || head.size > size - start) break;
        payload.resize(head.size);
        if (!read_whole(file_, start, payload.data(), payload.size()) || checksum(head, payload) != head.checksum)
            break;
        places_[{head.light, head.tile}] = {start, head.size};
        end = start + head.size;
    }
    if (ftruncate(file_, static_cast<off_t>(end)) != 0 || lseek(file_, 0, SEEK_END) < 0)
        fail_to_save(path_, std::strerror(errno));
}

bool TruthState::load(std::uint32_t light, std::size_t tile, std::span<SampleBits> receivers) {
    std::vector<unsigned char> payload;
    {
        const std::lock_guard lock(using_);
        const auto found = places_.find({light, tile});
        if (found == places_.end()) return false;
        payload.resize(found->second.size);
        if (!read_whole(file_, found->second.offset, payload.data(), payload.size()))
            throw InputError(fmt::format("cannot read '{}': {}", path_, std::strerror(errno)));
    }
    std::span<const unsigned char> rest(payload);
    for (SampleBits& bits : receivers)
        if (!bits.read(rest)) throw InputError(fmt::format("cannot resume from '{}': tile {} is broken", path_, tile));
    return true;
}

void TruthState::store(std::uint32_t light, std::size_t tile, std::span<const SampleBits> receivers) {
    std::vector<unsigned char> payload;
    for (const SampleBits& bits : receivers) bits.write(payload);
    RecordHead head{record_mark, light, tile, payload.size(), 0};
    head.checksum = checksum(head, payload);
    const std::lock_guard lock(using_);
    const auto* bytes = reinterpret_cast<const unsigned char*>(&head);
    unsaved_.insert(unsaved_.end(), bytes, bytes + sizeof head);
    unsaved_.insert(unsaved_.end(), payload.begin(), payload.end());
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - saved_;
    if (since.count() >= seconds_between_saves_) save_now();
}

void TruthState::create() {
    write_text_file(path_, header_);
    file_ = open(path_.c_str(), O_RDWR | O_CLOEXEC);
    if (file_ < 0 || lseek(file_, 0, SEEK_END) < 0) fail_to_save(path_, std::strerror(errno));
}

// Saved tiles are not asked for again, so only a new TruthState learns where they are.
void TruthState::save_now() {
    if (!unsaved_.empty()) {
        if (file_ < 0) create();
        write_whole(file_, unsaved_, path_);
        if (fdatasync(file_) != 0 && errno != EINVAL && errno != EROFS) fail_to_save(path_, std::strerror(errno));
        unsaved_.clear();
    }
    saved_ = std::chrono::steady_clock::now();
}

void TruthState::save() {
    const std::lock_guard lock(using_);
    save_now();
}

void TruthState::save_and_stop(int signal) {
    save();
    const std::string how =
        file_ < 0 ? "nothing was done yet"
                  : fmt::format("what was done is in '{}', and the same command with --resume goes on from it", path_);
    throw Error(signal == SIGTERM ? ExitCode::Terminated : ExitCode::Interrupted, "interrupted; " + how);
}

void TruthState::remove() {
    const std::lock_guard lock(using_);
    unsaved_.clear();
    if (file_ >= 0) close(file_);
    file_ = -1;
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
}

} // namespace gnomon
