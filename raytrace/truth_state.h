#pragma once
// The state of a long run in a file: which samples the receivers of each finished tile saw. A run that was stopped, in
// whatever way, goes on from it and ends with the bits of an undisturbed one.
//
// The file is a line of text, a line of JSON that says what the answers belong to, and records, in the byte order of
// the machine: a mark, light, tile, size of the payload, its checksum, the payload (SampleBits of the tile's receivers,
// row by row). Records are only ever added, one write for all that was finished in some seconds, so whenever the
// machine stops all records but perhaps the last are whole; what is not whole is cut off on resuming. Of two records of
// a tile the later one counts.

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/receiver.h"
#include "core/scene.h"
#include "raytrace/sample_bits.h"

namespace gnomon {

// What decides which receiver sees which sample: the shadow casters, the receivers, the lights; one entry each, so that
// a difference can be named. The pattern, its seed and whether pixels may stop early, which decides how rays are
// packed, are the caller's to add.
nlohmann::ordered_json truth_identity(const Scene& scene, const Receivers& receivers, std::span<const Light> lights);

class TruthState {
public:
    // With `resume` the file is read if it is there; throws InputError where it is no such file or belongs to something
    // else than `identity`, naming what differs. Otherwise it is written anew once there is something to save.
    // `seconds_between_saves` may be 0: after every tile.
    TruthState(std::string path, nlohmann::ordered_json identity, bool resume, double seconds_between_saves);
    ~TruthState();
    TruthState(const TruthState&) = delete;
    TruthState& operator=(const TruthState&) = delete;

    // Fills `receivers` with what is known of a tile; false, and nothing filled, where that is nothing. From any
    // thread.
    bool load(std::uint32_t light, std::size_t tile, std::span<SampleBits> receivers);
    // Takes the answers of a finished tile; saves when it is time. From any thread. Throws InputError.
    void store(std::uint32_t light, std::size_t tile, std::span<const SampleBits> receivers);

    void save(); // all that was stored
    // Saves and throws the Error (Interrupted or Terminated) that says how to go on.
    [[noreturn]] void save_and_stop(int signal);
    // Removes the file: the run is complete.
    void remove();

    const std::string& path() const { return path_; }
    std::size_t tiles() const { return places_.size(); }

private:
    void read();
    void create();
    void save_now();

    std::string path_;
    std::string header_;
    nlohmann::ordered_json identity_;
    double seconds_between_saves_;
    std::mutex using_;
    int file_ = -1;
    std::vector<unsigned char> unsaved_; // records
    struct Place {
        std::uint64_t offset = 0; // of the payload
        std::uint64_t size = 0;
    };
    std::map<std::pair<std::uint32_t, std::uint64_t>, Place> places_; // of saved tiles
    std::chrono::steady_clock::time_point saved_;
};

} // namespace gnomon
