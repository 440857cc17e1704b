#pragma once
// What a run of hours needs: a state beside the image from which it can be resumed, and shares of the image for several
// machines.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/image_file.h"
#include "raytrace/truth.h"
#include "raytrace/truth_state.h"

namespace CLI {
class App;
}

namespace gnomon {

// As written by the user; empty where not given.
struct LongRunOptions {
    bool resume = false, keep_state = false;
    std::string save_every = "5", tiles;
};
void add_long_run_options(CLI::App& command, LongRunOptions& options);

struct LongRun {
    bool resume = false, keep_state = false;
    double seconds_between_saves = 5;
    TileShare share;
};
// Throws UsageError.
LongRun read_long_run_options(const LongRunOptions& options);

// The state that lies beside the image at `image_path`, or nothing where that is no regular file. `identity` is all
// that the answers depend on. Throws InputError where --resume finds a state of something else. Says on standard error,
// unless quiet, that a state is there which will be replaced.
std::unique_ptr<TruthState> open_state(const LongRun& run, const std::string& image_path,
                                       const nlohmann::ordered_json& identity, bool quiet);

// Attributes that mark the image of one share: which it is, and what it must have in common with the others.
std::map<std::string, Attribute> share_attributes(const TileShare& share, const std::string& digest);

// Puts the shares of one image together, each pixel from the share that has its tile, as the undivided run would have
// written it. Throws InputError where a file is no share, the shares are of different runs, or one is missing or there
// twice.
void merge_shares(const std::vector<std::string>& paths, const std::string& output);

} // namespace gnomon
