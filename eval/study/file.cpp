#include "eval/study/file.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include <fmt/format.h>

#include "core/atomic_file.h"
#include "core/builtin/builtin.h"
#include "core/json_reader.h"
#include "core/scene_files.h"
#include "eval/metrics.h"
#include "eval/study/grid.h"
#include "eval/study/identity.h"
#include "eval/study/questions.h"

namespace gnomon {
namespace {

namespace fs = std::filesystem;

// A key of a block, and how it is called on the command line.
struct OptionKey {
    const char *key, *option;
    char separator; // between the numbers of an array
};
constexpr OptionKey camera_keys[] = {
    {"camera", "camera", 0}, {"look_from", "look-from", ','}, {"look_at", "look-at", ','}, {"fov", "fov", 0}};
constexpr OptionKey light_keys[] = {{"light", "light", 0},
                                    {"aim", "light-aim", ','},
                                    {"size", "light-size", 'x'},
                                    {"intensity", "light-intensity", ','}};

const JsonReader::Keys block_keys = {"scenes",     "cameras", "lights",  "sizes",  "techniques",
                                     "parameters", "truth",   "metrics", "primary"};

JsonReader::Keys with(JsonReader::Keys keys, const JsonReader::Keys& more) {
    keys.insert(keys.end(), more.begin(), more.end());
    return keys;
}

std::string joined(const JsonReader& value, char separator) {
    if (!separator || !value.value().is_array()) return text_of(value);
    std::string text;
    for (std::size_t i = 0; i < value.size(); ++i)
        text += (text.empty() ? "" : std::string(1, separator)) + text_of(value[i]);
    return text;
}

// "lamp", or {"name": "above", "light": "rect:0,4,0", "size": [2, 2]}. Without a name it is called what it says.
NamedOptions read_options(const JsonReader& value, std::span<const OptionKey> keys) {
    if (value.value().is_string()) return {value.text(), {{keys[0].option, value.text()}}};
    JsonReader::Keys known = {"name"};
    for (const OptionKey& row : keys) known.emplace_back(row.key);
    value.only(known);
    NamedOptions named;
    for (const OptionKey& row : keys) {
        if (!value.has(row.key)) continue;
        const std::string text = joined(value.at(row.key), row.separator);
        named.options[row.option] = text;
        named.name += fmt::format("{}{}", named.name.empty() ? "" : " ",
                                  &row == keys.data() ? text : fmt::format("{} {}", row.key, text));
    }
    if (named.options.empty()) named.name = "default";
    if (value.has("name")) named.name = value.at("name").text();
    return named;
}

class FileReader {
public:
    FileReader(const JsonReader& document, const fs::path& folder, const StudyProgram& program)
        : document_(document), folder_(folder), program_(program) {}

    StudyFile read() {
        document_.only(with(with({"name", "blocks"}, question_keys()), block_keys));
        StudyFile file;
        file.questions = nlohmann::json::object();
        for (const std::string& key : question_keys())
            if (document_.has(key)) file.questions[key] = document_.at(key).value();
        file.name = document_.has("name") ? document_.at("name").text() : "study";
        if (!document_.has("blocks")) {
            file.blocks.push_back(read_block(document_, file.name));
            return file;
        }
        std::vector<JsonReader> blocks = one_or_many(document_.at("blocks"));
        std::set<std::string> names;
        for (const JsonReader& block : blocks) {
            block.only(with({"name", "description"}, block_keys));
            const std::string name = block.at("name").text();
            if (!names.insert(name).second) block.at("name").fail("is '" + name + "', as another block is called");
            file.blocks.push_back(read_block(block, name));
        }
        return file;
    }

private:
    // What a block does not say holds for all blocks, or is the default.
    bool has(const JsonReader& block, const std::string& key) const { return block.has(key) || document_.has(key); }
    JsonReader at(const JsonReader& block, const std::string& key) const {
        return block.has(key) || !document_.has(key) ? block.at(key) : document_.at(key);
    }

    StudyBlock read_block(const JsonReader& place, const std::string& name) {
        StudyBlock block;
        block.name = name;
        for (const JsonReader& scene : one_or_many(at(place, "scenes")))
            add_named(scene, read_scene(scene), block.scenes);
        block.cameras = read_options_list(place, "cameras", camera_keys);
        block.lights = read_options_list(place, "lights", light_keys);
        read_sizes(place, block);
        block.primary = has(place, "primary") ? at(place, "primary").text() : "raster";
        check_views(place, block);
        if (has(place, "parameters")) {
            const JsonReader shared = at(place, "parameters");
            block.techniques = read_variants(at(place, "techniques"), &shared, "", program_);
        } else {
            block.techniques = read_variants(at(place, "techniques"), nullptr, "", program_);
        }
        const nlohmann::json plain = nlohmann::json::object();
        block.truths = read_variants(has(place, "truth") ? at(place, "truth")
                                                         : JsonReader(plain, place.file(), place.path() + ".truth"),
                                     nullptr, "truth", program_);
        read_metrics(place, block);
        return block;
    }

    template <class Named> static void add_named(const JsonReader& place, Named named, std::vector<Named>& list) {
        if (std::any_of(list.begin(), list.end(), [&](const Named& other) { return other.name == named.name; }))
            place.fail(
                fmt::format("is called '{}', as another in the list is; give it a 'name' of its own", named.name));
        list.push_back(std::move(named));
    }

    // Scenes stand in several blocks; each is read once.
    const nlohmann::ordered_json& identify(const std::string& scene) {
        const auto found = identities_.find(scene);
        return found != identities_.end() ? found->second
                                          : identities_.emplace(scene, scene_identity(scene)).first->second;
    }

    NamedScene read_scene(const JsonReader& value) {
        std::string name;
        if (value.value().is_object()) value.only({"name", "scene", "optional"});
        const JsonReader scene = value.value().is_object() ? value.at("scene") : value;
        const std::string text = scene.text();
        if (value.value().is_object() && value.has("name")) name = value.at("name").text();
        if (text.starts_with(builtin_prefix)) {
            check_at(scene, [&] { identify(text); });
            return {name.empty() ? text : name, text, identify(text), ""};
        }
        const fs::path path = folder_ / text;
        if (name.empty()) name = path.filename().string();
        const bool optional = value.has("optional") && value.at("optional").boolean();
        std::error_code ignored;
        if (!fs::is_regular_file(path, ignored)) {
            if (optional) return {name, path.string(), {}, text};
            scene.fail(fmt::format("is '{}', but there is no such file beside the study; check the path", text));
        }
        return {name, path.string(), identify(path.string()), optional ? missing_file(path.string()) : ""};
    }

    // The first file that the scene refers to and that is not there, or "".
    static std::string missing_file(const std::string& path) {
        std::error_code ignored;
        for (const SceneFile& file : scene_files(path))
            if (!fs::is_regular_file(file.path, ignored)) return file.name;
        return "";
    }

    std::vector<NamedOptions> read_options_list(const JsonReader& place, const std::string& key,
                                                std::span<const OptionKey> keys) const {
        std::vector<NamedOptions> list;
        if (!has(place, key)) return {{"default", {}}};
        for (const JsonReader& value : one_or_many(at(place, key))) add_named(value, read_options(value, keys), list);
        return list;
    }

    void read_sizes(const JsonReader& place, StudyBlock& block) const {
        if (!has(place, "sizes")) {
            block.sizes = {StudyView().size};
            return;
        }
        for (const JsonReader& size : one_or_many(at(place, "sizes"))) {
            check_view(size, {"", {}, {}, size.text(), "raster"});
            if (std::find(block.sizes.begin(), block.sizes.end(), size.text()) != block.sizes.end())
                size.fail(fmt::format("is {}, which is in the list already", size.text()));
            block.sizes.push_back(size.text());
        }
    }

    void check_view(const JsonReader& place, const StudyView& view) const {
        check_at(place, [&] { program_.check_view(view); });
    }

    void check_views(const JsonReader& place, const StudyBlock& block) const {
        for (std::size_t i = 0; i < block.cameras.size(); ++i)
            if (has(place, "cameras"))
                check_view(one_or_many(at(place, "cameras"))[i],
                           {"", block.cameras[i].options, {}, block.sizes[0], "raster"});
        for (std::size_t i = 0; i < block.lights.size(); ++i)
            if (has(place, "lights"))
                check_view(one_or_many(at(place, "lights"))[i],
                           {"", {}, block.lights[i].options, block.sizes[0], "raster"});
        if (has(place, "primary")) check_view(at(place, "primary"), {"", {}, {}, block.sizes[0], block.primary});
    }

    void read_metrics(const JsonReader& place, StudyBlock& block) const {
        std::vector<std::string> wanted, known = {"all"};
        for (const Metric& metric : metrics()) known.push_back(metric.id);
        if (has(place, "metrics"))
            for (const JsonReader& value : one_or_many(at(place, "metrics"))) {
                if (std::find(known.begin(), known.end(), value.text()) == known.end())
                    value.fail(fmt::format("is '{}', which is no metric{} (gnomon list metrics shows them)",
                                           value.text(), did_you_mean(value.text(), known)));
                wanted.push_back(value.text());
            }
        const auto asked_for = [&](const std::string& id) {
            return wanted.empty() || std::find(wanted.begin(), wanted.end(), id) != wanted.end();
        };
        for (const Metric& metric : metrics())
            if (asked_for(metric.id) || asked_for("all")) block.metrics.push_back(metric.id);
    }

    const JsonReader& document_;
    const fs::path folder_;
    const StudyProgram& program_;
    std::map<std::string, nlohmann::ordered_json> identities_;
};

} // namespace

StudyFile read_study_file(const std::string& path, const StudyProgram& program) {
    const nlohmann::json parsed = parse_json(read_file(path), path);
    const JsonReader document(parsed, path);
    return FileReader(document, fs::path(path).parent_path(), program).read();
}

} // namespace gnomon
