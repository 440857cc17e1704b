#pragma once
// The sub-commands: each adds itself to the parser with its options and does its work in the parser's callback. Errors
// leave as exceptions (core/error.h); gnomon.cpp turns them into one line and an exit code.

#include <string>

namespace CLI {
class App;
}

namespace gnomon {

void add_render_command(CLI::App& program, const std::string& command_line); // the line goes into reports
void add_truth_command(CLI::App& program);
void add_compare_command(CLI::App& program);
void add_study_command(CLI::App& program);
void add_list_command(CLI::App& program);
void add_help_command(CLI::App& program);
void add_export_command(CLI::App& program);
void add_docs_command(CLI::App& program);
void add_completion_command(CLI::App& program);

// Sub-commands of `gnomon study`.
void add_study_report_command(CLI::App& study);
void add_study_tables_command(CLI::App& study);

} // namespace gnomon
