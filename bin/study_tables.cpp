// gnomon study tables: a study's results in a paper's arrangement, and what becomes of its claims.

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/outputs.h"
#include "bin/text.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "eval/study/findings.h"

namespace gnomon {
namespace {

struct StudyTablesRequest {
    std::vector<std::string> folders;
    std::string output = "-", format, title;
};

std::string format_of(const StudyTablesRequest& request) {
    if (!request.format.empty())
        return std::vector<std::string>{"md", "csv"}[parse_choice(request.format, "--format", {"md", "csv"})];
    if (request.output == "-") return "md";
    if (extension(request.output) == ".md" || extension(request.output) == ".csv")
        return extension(request.output).substr(1);
    throw UsageError(fmt::format("-o takes an .md or .csv file, not '{}', unless --format says which", request.output));
}

std::string markdown(const StudyTablesRequest& request, const std::vector<StudyFindings>& studies) {
    std::string text = "# " + (request.title.empty() ? "Results" : request.title) + "\n\n";
    for (const StudyFindings& findings : studies)
        text += (&findings == studies.data() ? "" : "\n") + findings_markdown(findings);
    return text;
}

void run(const StudyTablesRequest& request) {
    const std::string format = format_of(request);
    if (request.output != "-") check_writable(request.output);
    std::vector<StudyFindings> studies;
    for (const std::string& folder : request.folders) {
        const StudyStore store(folder);
        studies.push_back(read_findings(store, read_study_plan(store)));
    }
    if (format == "csv" && studies.size() != 1) throw UsageError("CSV holds the tables of one study; name one folder");
    const std::string text = format == "csv" ? tables_csv(studies[0]) : markdown(request, studies);
    if (request.output == "-")
        print(text);
    else
        write_text_file(request.output, text);
}

} // namespace

void add_study_tables_command(CLI::App& study) {
    auto request = std::make_shared<StudyTablesRequest>();
    CLI::App* command =
        study.add_subcommand("tables", "print the tables and claims that a study's file describes, from its folder");
    command->add_option("DIR", request->folders, "folders that `gnomon study run` filled")->required();
    command->add_option("-o,--output", request->output, "an .md or .csv file; - is standard output")
        ->type_name("FILE")
        ->capture_default_str();
    command->add_option("--format", request->format, "by default as the file's name says, else md")
        ->type_name("md|csv");
    command->add_option("--title", request->title, "of the Markdown page; 'Results' by default");
    command->callback([request] { run(*request); });
}

} // namespace gnomon
