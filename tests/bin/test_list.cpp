// What the program says about itself, for people and for scripts.

#include <catch2/catch.hpp>

#include <algorithm>
#include <set>

#include <nlohmann/json.hpp>

#include "core/builtin/builtin.h"
#include "eval/metrics.h"
#include "techniques/technique.h"
#include "tests/bin/cli.h"

using namespace gnomon_tests;
using nlohmann::json;

namespace {

std::set<std::string> keys(const json& object) {
    std::set<std::string> names;
    for (const auto& [key, value] : object.items()) names.insert(key);
    return names;
}

} // namespace

TEST_CASE("list techniques --json has the documented keys", "[cli]") {
    const json rows = json::parse(check_success({"list", "techniques", "--json"}));
    REQUIRE(rows.size() == gnomon::techniques().size());
    for (const json& row : rows) {
        INFO(row.dump());
        CHECK(keys(row) == std::set<std::string>{"id", "title", "family", "kind", "lights", "paper", "parameters"});
        CHECK(std::set<std::string>{"hard", "filtered", "soft", "accurate"}.count(row["kind"]) == 1);
        CHECK(row["lights"].is_array());
        CHECK_FALSE(row["lights"].empty());
        for (const json& parameter : row["parameters"]) {
            std::set<std::string> present = keys(parameter);
            CHECK(present.count("choices") == (parameter["type"] == "choice" ? 1 : 0));
            present.erase("choices");
            CHECK(present == std::set<std::string>{"name", "type", "default", "min", "max", "unit", "help", "source"});
        }
    }
}

TEST_CASE("list scenes and metrics as JSON", "[cli]") {
    const json scenes = json::parse(check_success({"list", "scenes", "--json"}));
    REQUIRE(scenes.size() == gnomon::builtin_scenes().size());
    CHECK(keys(scenes[0]) == std::set<std::string>{"name", "title", "parameters"});
    const json metrics = json::parse(check_success({"list", "metrics", "--json"}));
    REQUIRE(metrics.size() == gnomon::metrics().size());
    CHECK(keys(metrics[0]) == std::set<std::string>{"id", "title", "formula", "range", "source", "blind_to",
                                                    "lower_is_better", "applies_to"});
}

TEST_CASE("Lists as text have one line for each entry under a heading", "[cli]") {
    const auto lines = [](const std::string& what) {
        const std::string text = check_success({"list", what});
        return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
    };
    CHECK(lines("techniques") == gnomon::techniques().size() + 1);
    CHECK(lines("scenes") == gnomon::builtin_scenes().size() + 1);
    CHECK(lines("metrics") == gnomon::metrics().size() + 1);
}

TEST_CASE("help explains everything that is listed", "[cli]") {
    std::vector<std::string> topics = {"render", "truth", "compare", "list", "help", "export", "docs", "completion"};
    for (const gnomon::Entry& entry : gnomon::techniques()) topics.push_back(entry.info.id);
    for (const gnomon::BuiltinScene& scene : gnomon::builtin_scenes()) {
        topics.push_back(scene.name);
        topics.push_back("builtin:" + scene.name);
    }
    for (const gnomon::Metric& metric : gnomon::metrics()) topics.push_back(metric.id);
    for (const std::string& topic : topics) CHECK(check_success({"help", topic}).size() > 40);
    // Every parameter of a technique is explained with its default.
    for (const gnomon::Entry& entry : gnomon::techniques()) {
        const std::string text = check_success({"help", entry.info.id});
        for (const gnomon::ParameterInfo& info : entry.parameters)
            CHECK(text.find("  " + info.name + "=" + info.default_text) != std::string::npos);
    }
}

TEST_CASE("Version, help and completion go to standard output", "[cli]") {
    CHECK(check_success({"--version"}).starts_with("gnomon "));
    const std::string usage = check_success({"--help"});
    CHECK(check_success({"help"}) == usage);
    for (const char* command : {"render", "truth", "compare", "list", "help", "export", "docs", "completion"}) {
        CHECK(usage.find(command) != std::string::npos);
        CHECK(check_success({command, "--help"}).find("Usage") != std::string::npos);
    }
    CHECK(check_success({"render", "--help"}).find("1280x720") != std::string::npos);
    CHECK(check_success({"completion"}).find("complete -o default -F _gnomon gnomon") != std::string::npos);
}
