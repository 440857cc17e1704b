#include "bin/long_run.h"

#include <filesystem>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/text.h"
#include "core/error.h"

namespace gnomon {
namespace {

constexpr const char* share_key = "gnomon:tiles";
constexpr const char* run_key = "gnomon:run";

TileShare parse_tiles(const std::string& text, const std::string& what) {
    const ivec2 share = parse_share(text, what);
    return {share.x, share.y};
}

// What this program wrote into the header; the rest is the file format's.
std::map<std::string, Attribute> own_attributes(const ChannelImage& image) {
    std::map<std::string, Attribute> own;
    for (const auto& [name, value] : image.attributes)
        if (name.starts_with("gnomon:") || name == "samplesPerPixel" || name == "worldToCamera" || name == "worldToNDC")
            own[name] = value;
    return own;
}

struct Share {
    std::string path;
    TileShare tiles;
    ChannelImage image;
};

Share read_share(const std::string& path) {
    Share share{path, {}, read_image(path)};
    share.image.attributes = own_attributes(share.image);
    const auto found = share.image.attributes.find(share_key);
    const auto* text = found == share.image.attributes.end() ? nullptr : std::get_if<std::string>(&found->second);
    if (!text || !share.image.attributes.contains(run_key))
        throw InputError(fmt::format("'{}' is no share of an image: gnomon truth --tiles makes them", path));
    try {
        share.tiles = parse_tiles(*text, share_key);
    } catch (const UsageError& error) {
        throw InputError(fmt::format("cannot use '{}': {}", path, error.what()));
    }
    share.image.attributes.erase(found);
    return share;
}

void check_same_run(const Share& first, const Share& other) {
    const auto differ = [&](const std::string& what) {
        throw InputError(fmt::format("'{}' and '{}' are not shares of one image: {}", first.path, other.path, what));
    };
    if (first.image.width != other.image.width || first.image.height != other.image.height)
        differ("their sizes differ");
    if (first.tiles.parts != other.tiles.parts) differ("they were split into different numbers of parts");
    for (const auto& [name, value] : first.image.attributes) {
        const auto found = other.image.attributes.find(name);
        if (found == other.image.attributes.end() || found->second != value) differ(name + " differs");
    }
    const auto& channels = first.image.channels;
    bool same = channels.size() == other.image.channels.size();
    for (size_t i = 0; same && i < channels.size(); ++i) same = channels[i].name == other.image.channels[i].name;
    if (!same) differ("their channels differ");
}

// Copies the pixels of the share's tiles.
void take_tiles(ChannelImage& merged, const Share& share) {
    const int across = truth_tiles_across(merged.width);
    for (size_t c = 0; c < merged.channels.size(); ++c)
        for (int y = 0; y < merged.height; ++y)
            for (int x = 0; x < merged.width; ++x) {
                const int tile = y / truth_tile_side * across + x / truth_tile_side;
                if (share.tiles.has(static_cast<size_t>(tile)))
                    merged.channels[c].values(x, y) = share.image.channels[c].values(x, y);
            }
}

} // namespace

void add_long_run_options(CLI::App& command, LongRunOptions& options) {
    const char* group = "Long runs";
    command.add_flag("--resume", options.resume, "go on from OUT.partial, which an interrupted run leaves behind")
        ->group(group);
    command
        .add_flag("--keep-state", options.keep_state,
                  "leave OUT.partial there at the end, so that --resume can add samples later")
        ->group(group);
    command
        .add_option("--save-every", options.save_every, "between writing the state, 0 to 86400; 0: after every tile")
        ->type_name("SECONDS")
        ->capture_default_str()
        ->group(group);
    command
        .add_option("--tiles", options.tiles, "only every n-th tile, from the i-th; --merge puts the n images together")
        ->type_name("I/N")
        ->group(group);
}

LongRun read_long_run_options(const LongRunOptions& options) {
    LongRun run;
    run.resume = options.resume;
    run.keep_state = options.keep_state;
    run.seconds_between_saves = parse_real(options.save_every, "--save-every", 0, 86400);
    if (!options.tiles.empty()) run.share = parse_tiles(options.tiles, "--tiles");
    return run;
}

std::unique_ptr<TruthState> open_state(const LongRun& run, const std::string& image_path,
                                       const nlohmann::ordered_json& identity, bool quiet) {
    std::error_code ignored;
    if (std::filesystem::exists(image_path, ignored) && !std::filesystem::is_regular_file(image_path, ignored))
        return nullptr; // a device or a pipe
    const std::string path = image_path + ".partial";
    if (!run.resume && !quiet && std::filesystem::exists(path, ignored))
        print_message(fmt::format("note: starting over; --resume would go on from '{}'", path));
    return std::make_unique<TruthState>(path, identity, run.resume, run.seconds_between_saves);
}

std::map<std::string, Attribute> share_attributes(const TileShare& share, const std::string& digest) {
    if (share.parts == 1) return {};
    return {{share_key, fmt::format("{}/{}", share.part, share.parts)}, {run_key, digest}};
}

void merge_shares(const std::vector<std::string>& paths, const std::string& output) {
    ChannelImage merged;
    Share first;
    std::vector<std::string> have;
    for (const std::string& path : paths) {
        Share share = read_share(path);
        if (have.empty()) {
            have.resize(static_cast<size_t>(share.tiles.parts));
            merged = share.image;
            merged.attributes.erase(run_key);
            first = {share.path, share.tiles, {}};
            first.image.width = share.image.width, first.image.height = share.image.height;
            first.image.attributes = share.image.attributes;
            for (const Channel& channel : share.image.channels)
                first.image.channels.push_back({channel.name, {}, false});
        }
        check_same_run(first, share);
        std::string& taken = have[static_cast<size_t>(share.tiles.part - 1)];
        if (!taken.empty())
            throw InputError(fmt::format("'{}' and '{}' are the same share of the image, {} of {}", taken, path,
                                         share.tiles.part, share.tiles.parts));
        taken = path;
        take_tiles(merged, share);
    }
    for (size_t i = 0; i < have.size(); ++i)
        if (have[i].empty())
            throw InputError(fmt::format("share {} of {} is missing: gnomon truth --tiles {}/{} makes it", i + 1,
                                         have.size(), i + 1, have.size()));
    write_exr(output, merged);
}

} // namespace gnomon
