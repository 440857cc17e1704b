// gnomon list: what there is, as a table or as JSON; every line comes from the tables that the program itself runs on.

#include <algorithm>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bin/commands.h"
#include "bin/text.h"
#include "core/builtin/builtin.h"
#include "eval/metrics.h"
#include "techniques/technique.h"

namespace gnomon {
namespace {

using nlohmann::ordered_json;

ordered_json techniques_json() {
    ordered_json rows = ordered_json::array();
    for (const Entry& entry : techniques())
        rows.push_back({{"id", entry.info.id},
                        {"title", entry.info.title},
                        {"family", entry.info.family},
                        {"kind", technique_kind_name(entry.info.kind)},
                        {"lights", light_type_names(entry.info.lights)},
                        {"paper", entry.info.paper},
                        {"parameters", parameter_table_json(entry.parameters)}});
    return rows;
}

ordered_json scenes_json() {
    ordered_json rows = ordered_json::array();
    for (const BuiltinScene& scene : builtin_scenes())
        rows.push_back(
            {{"name", scene.name}, {"title", scene.title}, {"parameters", parameter_table_json(scene.parameters)}});
    return rows;
}

ordered_json metrics_json() {
    ordered_json rows = ordered_json::array();
    for (const Metric& metric : metrics())
        rows.push_back({{"id", metric.id},
                        {"title", metric.title},
                        {"formula", metric.formula},
                        {"range", metric.range},
                        {"source", metric.source},
                        {"blind_to", metric.blind_to},
                        {"lower_is_better", metric.lower_is_better},
                        {"applies_to", domain_name(metric.domain)}});
    return rows;
}

void print_techniques() {
    std::vector<std::vector<std::string>> rows = {{"ID", "KIND", "FAMILY", "LIGHTS", "TITLE"}};
    for (const Entry& entry : techniques())
        rows.push_back({entry.info.id, technique_kind_name(entry.info.kind), entry.info.family,
                        entry.info.lights == all_lights
                            ? "all"
                            : fmt::format("{}", fmt::join(light_type_names(entry.info.lights), ",")),
                        entry.info.title});
    print(aligned(rows));
}

void print_scenes() {
    std::vector<std::vector<std::string>> rows = {{"SCENE", "TITLE"}};
    for (const BuiltinScene& scene : builtin_scenes()) rows.push_back({"builtin:" + scene.name, scene.title});
    print(aligned(rows));
}

void print_metrics() {
    std::vector<std::vector<std::string>> rows = {{"ID", "BETTER", "OF", "TITLE"}};
    for (const Metric& metric : metrics())
        rows.push_back(
            {metric.id, metric.lower_is_better ? "lower" : "higher", domain_name(metric.domain), metric.title});
    print(aligned(rows));
}

struct Listing {
    const char* name;
    const char* help;
    ordered_json (*json)();
    void (*text)();
};
constexpr Listing listings[] = {
    {"techniques", "every shadow technique", techniques_json, print_techniques},
    {"scenes", "the builtin scenes", scenes_json, print_scenes},
    {"metrics", "every measure of `gnomon compare`", metrics_json, print_metrics},
};

} // namespace

void add_list_command(CLI::App& program) {
    struct ListOptions {
        std::string what;
        bool json = false;
    };
    const auto options = std::make_shared<ListOptions>();
    CLI::App* command = program.add_subcommand("list", "list techniques, builtin scenes or metrics");
    command->add_option("what", options->what, "what to list")->type_name("techniques|scenes|metrics")->required();
    command->add_flag("--json", options->json, "as JSON, with parameters");
    command->callback([options] {
        std::vector<std::string> names;
        for (const Listing& listing : listings) names.emplace_back(listing.name);
        const Listing& listing = listings[parse_choice(options->what, "the list", names)];
        if (options->json)
            print(listing.json().dump(2) + "\n");
        else
            listing.text();
    });
}

} // namespace gnomon
