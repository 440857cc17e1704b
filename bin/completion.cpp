// gnomon completion: a script that lets bash complete commands, options, techniques, scenes and metrics.

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/text.h"
#include "core/builtin/builtin.h"
#include "eval/metrics.h"
#include "techniques/technique.h"

namespace gnomon {
namespace {

// Words are fixed when the script is made: completing must not start a program at every key.
constexpr const char* script = R"(_gnomon() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}" previous="${{COMP_WORDS[COMP_CWORD-1]}}" words=""
    case "$previous" in
    -t|--technique|--reference) words="{techniques}" ;;
    --metrics) words="all {metrics}" ;;
    help) words="{commands} {techniques} {scenes} {metrics}" ;;
    list) words="techniques scenes metrics" ;;
    esac
    if [ -z "$words" ]; then
        case "${{COMP_WORDS[1]}}" in
{cases}        esac
        [ "$COMP_CWORD" -eq 1 ] && words="{commands} --help --version"
    fi
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o default -F _gnomon gnomon
)";

// The options of a command, and its sub-commands with theirs, each after a blank.
std::string words_of(const CLI::App& command) {
    std::string words;
    for (const CLI::Option* option : command.get_options())
        for (const std::string& name : option->get_lnames()) words += " --" + name;
    for (const CLI::App* inner : command.get_subcommands([](const CLI::App*) { return true; }))
        words += " " + inner->get_name() + words_of(*inner);
    return words;
}

std::string script_text(const CLI::App& program) {
    std::vector<std::string> commands, ids, scenes, measures;
    std::string cases;
    for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
        commands.push_back(command->get_name());
        const std::string words = words_of(*command);
        cases += fmt::format("        {}) words=\"{}\" ;;\n", command->get_name(), words.substr(words.empty() ? 0 : 1));
    }
    for (const Entry& entry : techniques()) ids.push_back(entry.info.id);
    for (const BuiltinScene& scene : builtin_scenes()) scenes.push_back(scene.name);
    for (const Metric& metric : metrics()) measures.push_back(metric.id);
    return fmt::format(script, fmt::arg("commands", fmt::join(commands, " ")),
                       fmt::arg("techniques", fmt::join(ids, " ")), fmt::arg("scenes", fmt::join(scenes, " ")),
                       fmt::arg("metrics", fmt::join(measures, " ")), fmt::arg("cases", cases));
}

} // namespace

void add_completion_command(CLI::App& program) {
    CLI::App* command =
        program.add_subcommand("completion", "print a bash completion script: source <(gnomon completion)");
    command->callback([&program] { print(script_text(program)); });
}

} // namespace gnomon
