// The program: parses the command line, hands over to a sub-command, and turns whatever goes wrong into one line on
// standard error and an exit code.

#include <csignal>
#include <new>
#include <sstream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/text.h"
#include "core/error.h"

namespace gnomon {
namespace {

constexpr const char* footer = "Exit codes: 0 done, 1 a --fail-above bound was crossed or cells of a study failed, 2 "
                               "wrong usage, 3 bad input, 4 a "
                               "failure of the program, 130 or 143 interrupted (gnomon truth and gnomon study can go "
                               "on).\n`gnomon COMMAND --help` shows a command's "
                               "options, `gnomon list` and `gnomon "
                               "help NAME` the techniques, scenes and metrics.";

std::vector<std::string> command_names(const CLI::App& program) {
    std::vector<std::string> names;
    for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(command->get_name());
    return names;
}

std::vector<std::string> option_names(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    return names;
}

// The innermost command that was named, and how: "", " render", " study run".
std::pair<const CLI::App*, std::string> named_command(const CLI::App& program) {
    const CLI::App* command = &program;
    std::string where;
    for (std::vector<CLI::App*> chosen; !(chosen = command->get_subcommands()).empty(); command = chosen.front())
        where += " " + chosen.front()->get_name();
    return {command, where};
}

// The parser's own sentence, made more helpful where a word was not understood.
std::string explain(const CLI::App& program, const CLI::ParseError& error) {
    const auto& [command, where] = named_command(program);
    const std::vector<std::string> unknown = program.remaining(true), commands = command_names(*command);
    const std::string hint = fmt::format(" (gnomon{} --help shows the usage)", where);
    if (unknown.empty() && !commands.empty()) return "a command is missing" + hint;
    if (unknown.empty()) return error.what() + hint;
    const std::string& word = unknown.front();
    if (word.size() > 1 && word.front() == '-')
        return fmt::format("there is no option '{}'{}{}", word,
                           did_you_mean(word.substr(0, word.find('=')), option_names(*command)), hint);
    if (!commands.empty()) return fmt::format("there is no command '{}'{}{}", word, did_you_mean(word, commands), hint);
    return fmt::format("the argument '{}' was not expected{}", word, hint);
}

// As it would be typed into a shell again.
std::string command_line(int argc, char** argv) {
    std::string line = "gnomon";
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        constexpr const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:=,+@%";
        const bool quoted = word.empty() || word.find_first_not_of(plain) != std::string::npos;
        line += quoted ? " '" + word + "'" : " " + word;
    }
    return line;
}

void add_commands(CLI::App& program, const std::string& line) {
    program.footer(footer);
    program.require_subcommand(1);
    program.set_version_flag("--version", std::string("gnomon " GNOMON_VERSION));
    add_render_command(program, line);
    add_truth_command(program);
    add_compare_command(program);
    add_study_command(program);
    add_list_command(program);
    add_help_command(program);
    add_export_command(program);
    add_docs_command(program);
    add_completion_command(program);
}

int run(int argc, char** argv) {
    CLI::App program("gnomon: the CPU reference for shadow research", "gnomon");
    add_commands(program, command_line(argc, argv));
    try {
        program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() != 0) throw UsageError(explain(program, error));
        std::ostringstream text; // --help and --version
        program.exit(error, text, text);
        print(text.str());
    }
    return static_cast<int>(ExitCode::Done);
}

} // namespace
} // namespace gnomon

int main(int argc, char** argv) {
    using namespace gnomon;
    std::signal(SIGPIPE, SIG_IGN); // a reader that leaves early is its own decision: see print()
    try {
        return run(argc, argv);
    } catch (const Error& error) {
        print_message(error.what());
        return static_cast<int>(error.code);
    } catch (const std::bad_alloc&) {
        print_message("out of memory; a smaller --size or fewer techniques at a time need less");
    } catch (const std::exception& error) {
        print_message(fmt::format("internal error: {}", error.what()));
    }
    return static_cast<int>(ExitCode::Internal);
}
