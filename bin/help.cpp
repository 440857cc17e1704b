// gnomon help NAME: a technique, a builtin scene, a metric or a command, whichever bears the name; all of them where
// several do.

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/text.h"
#include "core/builtin/builtin.h"
#include "core/error.h"
#include "eval/metrics.h"
#include "techniques/technique.h"

namespace gnomon {
namespace {

std::string parameters_text(std::span<const ParameterInfo> parameters) {
    if (parameters.empty()) return "\nNo parameters.\n";
    return "\nParameters (name=default):\n" + parameter_table_text(parameters);
}

std::string technique_text(const Entry& entry) {
    const TechniqueInfo& info = entry.info;
    std::string text = fmt::format("technique {}: {}\n\n", info.id, info.title);
    const auto line = [&](const char* name, const std::string& value) {
        if (!value.empty()) text += fmt::format("  {:<10} {}\n", name, value);
    };
    line("family", info.family);
    line("kind", technique_kind_name(info.kind));
    line("lights", fmt::format("{}", fmt::join(light_type_names(info.lights), ", ")));
    line("paper", info.paper);
    line("section", info.section);
    line("equations", info.equations);
    line("strengths", info.strengths);
    line("artifacts", info.artifacts);
    return text + parameters_text(entry.parameters) +
           fmt::format("\n  gnomon render -t {} -o {}.png\n", info.id, info.id);
}

std::string scene_text(const BuiltinScene& scene) {
    return fmt::format("scene builtin:{}: {}\n", scene.name, scene.title) + parameters_text(scene.parameters) +
           fmt::format("\n  gnomon render builtin:{} -t raytraced -o {}.png\n", scene.name, scene.name);
}

std::string metric_text(const Metric& metric) {
    return fmt::format(
        "metric {}: {}\n\n  formula   {}\n  range     {}\n  better    {}\n  blind to  {}\n  source    {}\n", metric.id,
        metric.title, metric.formula, metric.range, metric.lower_is_better ? "lower" : "higher", metric.blind_to,
        metric.source);
}

struct Topics {
    std::vector<std::string> names;
    std::string found; // texts of those that bear the name

    void add(const std::string& topic, const std::string& wanted, const std::function<std::string()>& text) {
        names.push_back(topic);
        if (topic == wanted) found += (found.empty() ? "" : "\n") + text();
    }
};

void print_help(const CLI::App& program, const std::string& name) {
    Topics topics;
    for (const Entry& entry : techniques()) topics.add(entry.info.id, name, [&] { return technique_text(entry); });
    for (const BuiltinScene& scene : builtin_scenes()) {
        topics.add(scene.name, name, [&] { return scene_text(scene); });
        topics.add("builtin:" + scene.name, name, [&] { return scene_text(scene); });
    }
    for (const Metric& metric : metrics()) topics.add(metric.id, name, [&] { return metric_text(metric); });
    for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
        topics.add(command->get_name(), name, [&] { return command->help("gnomon"); });
    if (topics.found.empty())
        throw UsageError(fmt::format("there is no technique, scene, metric or command '{}'{}", name,
                                     did_you_mean(name, topics.names)));
    print(topics.found);
}

} // namespace

void add_help_command(CLI::App& program) {
    const auto name = std::make_shared<std::string>();
    CLI::App* command = program.add_subcommand("help", "explain a technique, builtin scene, metric or command");
    command->add_option("name", *name, "what to explain")->type_name("NAME");
    command->callback([&program, name] {
        if (name->empty())
            // help() of a program would delegate to the command that was given, this one
            print(program.get_formatter()->make_help(&program, program.get_name(), CLI::AppFormatMode::Normal));
        else
            print_help(program, *name);
    });
}

} // namespace gnomon
