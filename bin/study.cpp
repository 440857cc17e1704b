// gnomon study: a grid of runs into a paper's tables.

#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/render_options.h"
#include "bin/study_program.h"
#include "bin/text.h"
#include "core/error.h"
#include "core/parallel.h"

namespace gnomon {
namespace {

// As written by the user.
struct StudyOptions {
    std::string file, folder, share = "1/1", threads = "0", progress = "auto";
    bool retry_failed = false, dry_run = false, partial = false, quiet = false;
};

void report_failures(const StudySummary& summary, const std::string& folder) {
    if (summary.failed > 0)
        throw Error(cells_failed, fmt::format("{} of {} cells in '{}' failed; the first: {}", summary.failed,
                                              summary.share, folder, summary.first_failure));
}

std::string tables_text(const StudySummary& summary, const std::string& folder) {
    const std::string table = (std::filesystem::path(folder) / "results.csv").string();
    return summary.missing == 0 ? fmt::format("tables in {}", table)
                                : fmt::format("{} are still missing, so there are no tables yet", summary.missing);
}

void run_run(const StudyOptions& options) {
    const ivec2 share = parse_share(options.share, "--shard");
    StudyRun run{{share.x, share.y}, options.retry_failed, read_progress(options.progress, options.quiet)};
    if (options.folder.empty()) throw UsageError("--output is empty; name a folder");
    const StudyProgram program = make_study_program(options.quiet);
    const StudyPlan plan = read_study(options.file, program);
    if (!options.quiet)
        for (const SkippedScene& scene : plan.skipped)
            print_message(fmt::format("the scene '{}' is skipped: {} is not there", scene.name, scene.missing));
    if (options.dry_run) return print(list_study(plan, options.folder));
    const StudySummary summary = run_study(plan, program, options.folder, run);
    const std::string shard = share.y == 1 ? "" : fmt::format(" of {} in shard {}/{}", summary.cells, share.x, share.y);
    if (!options.quiet)
        print(fmt::format("{} cell{}{}: {} there before, {} computed{}; {}{}\n", summary.share,
                          summary.share == 1 ? "" : "s", shard, summary.there, summary.computed,
                          summary.computed == 0 ? ", nothing to do" : "", tables_text(summary, options.folder),
                          plan.skipped.empty() ? ""
                                               : fmt::format("; {} scene{} skipped", plan.skipped.size(),
                                                             plan.skipped.size() == 1 ? "" : "s")));
    report_failures(summary, options.folder);
}

void run_collect(const StudyOptions& options) {
    StudySummary summary = collect_study(options.folder, options.partial);
    summary.share = summary.cells;
    print(fmt::format("{} of {} cells; tables in {}\n", summary.cells - summary.missing, summary.cells,
                      (std::filesystem::path(options.folder) / "results.csv").string()));
    report_failures(summary, options.folder);
}

void add_run(CLI::App& study, const std::shared_ptr<StudyOptions>& options) {
    CLI::App* command = study.add_subcommand("run", "compute what a folder lacks of a study");
    command->add_option("STUDY", options->file, "what to run; docs/studies.md describes it")
        ->type_name("STUDY.json")
        ->required();
    command->add_option("-o,--output", options->folder, "where cells and tables are kept, made if missing")
        ->type_name("DIR")
        ->required();
    command->add_option("--shard", options->share, "only every n-th cell, from the i-th; folders merge by copying")
        ->type_name("I/N")
        ->capture_default_str();
    command->add_flag("--retry-failed", options->retry_failed, "compute cells again that failed before");
    command->add_flag("--dry-run", options->dry_run, "list rows and what is known of each, and do nothing");
    command->add_option("--threads", options->threads, "0 to 1024; 0 is all cores; results do not depend on it")
        ->type_name("N")
        ->capture_default_str();
    command->add_option("--progress", options->progress, "progress on standard error; auto: where it is a terminal")
        ->type_name("auto|on|off")
        ->capture_default_str();
    command->add_flag("-q,--quiet", options->quiet, "no summary, warnings or progress");
    command->callback(
        [options] { with_threads(parse_integer(options->threads, "--threads", 0, 1024), [&] { run_run(*options); }); });
}

void add_collect(CLI::App& study, const std::shared_ptr<StudyOptions>& options) {
    CLI::App* command = study.add_subcommand("collect", "write the tables of a folder whose cells are there");
    command->add_option("DIR", options->folder, "of gnomon study run")->type_name("DIR")->required();
    command->add_flag("--partial", options->partial, "even where cells are missing, without their rows");
    command->callback([options] { run_collect(*options); });
}

} // namespace

void add_study_command(CLI::App& program) {
    const auto options = std::make_shared<StudyOptions>();
    CLI::App* study = program.add_subcommand("study", "a grid of runs: scenes, techniques and their parameters");
    study->require_subcommand(1);
    add_run(*study, options);
    add_collect(*study, options);
    add_study_tables_command(*study);
    add_study_report_command(*study);
}

} // namespace gnomon
