#include "bin/stats.h"

#include <fstream>

#include <sys/resource.h>

#include "bin/text.h"
#include "core/atomic_file.h"

namespace gnomon {
namespace {

using nlohmann::ordered_json;

ordered_json techniques_json(const std::vector<TechniqueStats>& techniques) {
    ordered_json rows = ordered_json::array();
    for (const TechniqueStats& technique : techniques)
        rows.push_back({{"id", technique.id},
                        {"label", technique.label},
                        {"parameters", technique.parameters},
                        {"light", technique.light},
                        {"seconds", technique.seconds},
                        {"peak_bytes", technique.log.memory->peak()},
                        {"passes", passes_json(technique.log)}});
    return rows;
}

} // namespace

ordered_json counters_json(const PassCounters& counters) {
    return {{"draws", counters.draws},
            {"vertices", counters.vertices},
            {"triangles", counters.triangles},
            {"clipped", counters.clipped},
            {"culled", counters.culled},
            {"fragments_covered", counters.fragments_covered},
            {"fragments_passed", counters.fragments_passed},
            {"fragments_shaded", counters.fragments_shaded},
            {"texels_fetched", counters.texels_fetched},
            {"bytes_read", counters.bytes_read},
            {"bytes_written", counters.bytes_written},
            {"rays", counters.rays}};
}

ordered_json passes_json(const PassLog& log) {
    ordered_json passes = ordered_json::array();
    for (const PassCounters& pass : log.passes) {
        ordered_json row = {{"name", pass.name}};
        row.update(counters_json(pass));
        row["seconds"] = pass.seconds;
        passes.push_back(std::move(row));
    }
    return passes;
}

ordered_json stats_json(const RunStats& stats) {
    ordered_json steps = ordered_json::array();
    for (const StepStats& step : stats.steps) steps.push_back({{"name", step.name}, {"seconds", step.seconds}});
    return {
        {"version", GNOMON_VERSION},
        {"scene",
         {{"name", stats.scene},
          {"triangles", stats.triangles},
          {"vertices", stats.vertices},
          {"objects", stats.objects}}},
        {"image",
         {{"width", stats.width}, {"height", stats.height}, {"camera", stats.camera}, {"exposure", stats.exposure}}},
        {"gbuffer",
         {{"seconds", stats.gbuffer_seconds},
          {"peak_bytes", stats.gbuffer.memory->peak()},
          {"passes", passes_json(stats.gbuffer)}}},
        {"techniques", techniques_json(stats.techniques)},
        {"steps", steps},
        {"peak_resident_bytes", peak_resident_bytes()}};
}

void write_json(const std::string& target, const ordered_json& json) {
    // A name from a file may hold bytes that are no UTF-8.
    const std::string text = json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
    if (target == "-")
        print(text);
    else
        write_text_file(target, text);
}

std::int64_t peak_resident_bytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.starts_with("VmHWM:")) return std::stoll(line.substr(6)) * 1024;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return std::int64_t{usage.ru_maxrss} * 1024;
}

void reset_peak_resident_bytes() { std::ofstream("/proc/self/clear_refs") << '5'; }

} // namespace gnomon
