// gnomon study report: the page of a study's folder.

#include <memory>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/outputs.h"
#include "bin/text.h"
#include "core/error.h"
#include "eval/report/study_report.h"
#include "techniques/technique.h"

namespace gnomon {
namespace {

// A study may be older or newer than this program: what it does not know keeps its id.
TechniqueWords describe(const std::string& id) {
    for (const Entry& entry : techniques()) {
        if (entry.info.id != id) continue;
        TechniqueWords words{entry.info.title, technique_kind_name(entry.info.kind), entry.info.paper, {}};
        for (const ParameterInfo& parameter : entry.parameters) words.units[parameter.name] = parameter.unit;
        return words;
    }
    return {id, "", "", {}};
}

struct StudyReportRequest {
    std::string folder, output, title;
    int image_mib = 16;
};

void run(const StudyReportRequest& request) {
    if (extension(request.output) != ".html")
        throw UsageError(fmt::format("-o takes an .html file, not '{}'", request.output));
    check_writable(request.output);
    StudyReportOptions options;
    options.title = request.title, options.describe = describe;
    options.image_budget = static_cast<size_t>(request.image_mib) << 20;
    write_report(request.output, study_report(request.folder, request.output, options));
}

} // namespace

void add_study_report_command(CLI::App& study) {
    auto request = std::make_shared<StudyReportRequest>();
    CLI::App* command = study.add_subcommand("report", "make one page of a study's folder: tables, plots, images");
    command->add_option("DIR", request->folder, "the folder that `gnomon study run` filled")->required();
    command->add_option("-o,--output", request->output, "the page, an .html file")->required();
    command->add_option("--title", request->title, "its title; the folder's name by default");
    command->add_option("--images", request->image_mib, "MiB of the page that images may take")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    command->callback([request] { run(*request); });
}

} // namespace gnomon
