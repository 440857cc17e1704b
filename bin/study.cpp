// gnomon study: a grid of runs into a paper's tables.

#include <CLI/CLI.hpp>

#include "bin/commands.h"

namespace gnomon {

void add_study_command(CLI::App& program) {
    CLI::App* study = program.add_subcommand("study", "a grid of runs: scenes, techniques and their parameters");
    study->require_subcommand(1);
    add_study_report_command(*study);
}

} // namespace gnomon
