// gnomon docs: the pages about techniques, one a technique with its picture, and the page that lists them.

#include <filesystem>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "bin/commands.h"
#include "bin/outputs.h"
#include "bin/render_options.h"
#include "bin/technique_pages.h"
#include "bin/technique_picture.h"
#include "bin/text.h"
#include "core/atomic_file.h"
#include "core/image_file.h"
#include "core/parallel.h"
#include "core/progress.h"

namespace gnomon {
namespace {

struct DocsOptions {
    std::string folder, threads = "0";
    std::vector<std::string> techniques; // none: all
    bool no_pictures = false, quiet = false;
};

void write_docs(const DocsOptions& options, std::span<const Entry* const> entries) {
    std::optional<TechniquePictures> pictures;
    if (!options.no_pictures) pictures.emplace();
    Progress progress("techniques", static_cast<std::int64_t>(entries.size()), read_progress("auto", options.quiet));
    for (const Entry* entry : entries) {
        const std::string path = options.folder + "/" + entry->info.id;
        write_text_file(path + ".md", technique_page(*entry));
        if (pictures) write_png(path + ".png", pictures->draw(*entry));
        progress.advance(1);
    }
    write_text_file(options.folder + "/README.md", technique_index());
}

void make_docs(const DocsOptions& options) {
    std::vector<const Entry*> entries;
    for (const std::string& id : options.techniques) entries.push_back(&find_technique(id));
    if (entries.empty())
        for (const Entry& entry : techniques()) entries.push_back(&entry);
    const int threads = parse_integer(options.threads, "--threads", 0, 1024);
    std::error_code ignored;
    std::filesystem::create_directories(options.folder, ignored);
    check_writable(options.folder + "/README.md");
    with_threads(threads, [&] { write_docs(options, entries); });
}

} // namespace

void add_docs_command(CLI::App& program) {
    const auto options = std::make_shared<DocsOptions>();
    CLI::App* command =
        program.add_subcommand("docs", "write the pages about techniques, with a picture of each, as Markdown");
    command->add_option("-o,--output", options->folder, "the folder, made where it is missing")
        ->type_name("DIR")
        ->required();
    command->add_option("-t,--technique", options->techniques, "only this one; may be repeated (default: all)")
        ->type_name("ID");
    command->add_flag("--no-pictures", options->no_pictures, "the text alone");
    command->add_option("--threads", options->threads, "0 to 1024; 0 is all cores; results do not depend on it")
        ->type_name("N")
        ->capture_default_str();
    command->add_flag("-q,--quiet", options->quiet, "no progress on standard error");
    command->callback([options] { make_docs(*options); });
}

} // namespace gnomon
