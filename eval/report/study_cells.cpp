#include "eval/report/study_cells.h"

#include <filesystem>
#include <functional>
#include <map>

#include <fmt/format.h>

#include "core/atomic_file.h"
#include "core/json_reader.h"

namespace gnomon {
namespace {

using Json = nlohmann::json;

// Calls `take` with each whole line of a file and its name, "results.jsonl:12".
void for_each_line(const std::string& path, const std::function<void(const JsonReader& line)>& take) {
    const std::string text = read_file(path);
    size_t number = 0;
    for (size_t begin = 0; begin < text.size();) {
        const size_t end = text.find('\n', begin);
        if (end == std::string::npos) return;
        const std::string_view line = std::string_view(text).substr(begin, end - begin);
        begin = end + 1;
        const std::string name = fmt::format("{}:{}", path, ++number);
        if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
        const Json json = parse_json(line, name);
        const JsonReader reader(json, name);
        reader.expect_object();
        take(reader);
    }
}

// Lights and cameras are names, or objects where the study describes them.
std::string words(const JsonReader& line, const std::string& key) {
    if (!line.has(key) || line.at(key).value().is_null()) return "";
    const JsonReader value = line.at(key);
    return value.value().is_string() ? value.text()
                                     : value.value().dump(-1, ' ', false, Json::error_handler_t::replace);
}

nlohmann::ordered_json object(const JsonReader& line, const std::string& key) {
    if (!line.has(key) || line.at(key).value().is_null()) return nlohmann::ordered_json::object();
    const JsonReader value = line.at(key);
    value.expect_object();
    return value.value();
}

// A file inside the folder: what others wrote into a study opens nothing outside it.
std::string inner_path(const JsonReader& object, const std::string& key) {
    if (!object.has(key) || object.at(key).value().is_null()) return "";
    const JsonReader value = object.at(key);
    const std::filesystem::path path = std::filesystem::path(value.text()).lexically_normal();
    if (path.is_absolute() || path.empty() || *path.begin() == "..") value.fail("must name a file inside the folder");
    return path.generic_string();
}

std::vector<std::pair<std::string, double>> metric_values(const JsonReader& line) {
    std::vector<std::pair<std::string, double>> values;
    if (!line.has("metrics")) return values;
    const JsonReader metrics = line.at("metrics");
    metrics.expect_object();
    for (const auto& item : metrics.value().items()) {
        if (!item.value().is_number() && !item.value().is_null())
            metrics.at(item.key()).fail("must be a number or null");
        values.emplace_back(item.key(), item.value().is_null() ? std::numeric_limits<double>::infinity()
                                                               : item.value().get<double>());
    }
    return values;
}

StudyCell read_cell(const JsonReader& line) {
    StudyCell cell;
    cell.cell = line.at("cell").text(), cell.technique = line.at("technique").text();
    cell.block = words(line, "block"), cell.scene = words(line, "scene"), cell.camera = words(line, "camera");
    cell.light = words(line, "light"), cell.size = words(line, "size"), cell.message = words(line, "message");
    cell.status = line.at("status").text();
    if (cell.status != "ok" && cell.status != "failed") line.at("status").fail("must be 'ok' or 'failed'");
    cell.parameters = object(line, "parameters");
    const nlohmann::ordered_json varied = object(line, "varied");
    for (const auto& item : varied.items()) // what the reference varies tells views apart, not techniques
        if (!item.key().starts_with("reference.")) cell.varied[item.key()] = item.value();
    if (line.has("reference") && !line.at("reference").value().is_null()) {
        const JsonReader reference = line.at("reference");
        reference.expect_object();
        cell.reference = {words(reference, "technique"), inner_path(reference, "file"),
                          object(reference, "parameters")};
    }
    cell.metrics = metric_values(line);
    if (line.has("counters")) cell.counters = object(line, "counters");
    if (line.has("files") && !line.at("files").value().is_null()) {
        line.at("files").expect_object();
        cell.visibility = inner_path(line.at("files"), "visibility");
    }
    return cell;
}

// What a row is, whatever came out of it. Rows of several blocks may share a cell.
std::string identity(const StudyCell& cell) {
    const nlohmann::ordered_json parts = {cell.cell,           cell.block,
                                          cell.scene,          cell.camera,
                                          cell.light,          cell.size,
                                          cell.varied,         cell.reference.technique,
                                          cell.reference.file, cell.reference.parameters};
    return parts.dump(-1, ' ', false, Json::error_handler_t::replace);
}

} // namespace

std::vector<StudyCell> read_study_cells(const std::string& folder) {
    std::vector<StudyCell> cells;
    std::map<std::string, size_t> rows;
    for_each_line(folder + "/results.jsonl", [&](const JsonReader& line) {
        StudyCell cell = read_cell(line);
        const auto [row, is_new] = rows.emplace(identity(cell), cells.size());
        if (is_new)
            cells.push_back(std::move(cell));
        else
            cells[row->second] = std::move(cell);
    });
    const std::string timings = folder + "/timings.jsonl";
    std::error_code ignored;
    if (!std::filesystem::exists(timings, ignored)) return cells;
    std::map<std::string, std::pair<double, std::int64_t>> costs;
    for_each_line(timings, [&](const JsonReader& line) {
        std::pair<double, std::int64_t>& cost = costs[line.at("cell").text()];
        if (line.has("seconds")) cost.first = line.at("seconds").number(0.0, 1e12);
        if (line.has("peak_bytes")) cost.second = static_cast<std::int64_t>(line.at("peak_bytes").count());
    });
    for (StudyCell& cell : cells)
        if (const auto cost = costs.find(cell.cell); cost != costs.end())
            cell.seconds = cost->second.first, cell.peak_bytes = cost->second.second;
    return cells;
}

} // namespace gnomon
