#include "eval/study/records.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace gnomon {
namespace {

using nlohmann::ordered_json;

std::string key_text(const ordered_json& value) {
    return value.is_string() ? value.get<std::string>()
                             : value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

void add_numbers(const ordered_json& object, const std::vector<std::string>& without,
                 std::map<std::string, double>& values) {
    if (!object.is_object()) return;
    for (const auto& item : object.items()) {
        if (std::find(without.begin(), without.end(), item.key()) != without.end()) continue;
        if (item.value().is_number())
            values[item.key()] = item.value().get<double>();
        else if (item.value().is_null()) // as `compare --json` writes infinity
            values[item.key()] = std::numeric_limits<double>::infinity();
    }
}

// Passes of one name are one, whichever light they are of.
StudyPass& pass_named(StudyRecord& record, const std::string& name) {
    const auto found = std::find_if(record.passes.begin(), record.passes.end(),
                                    [&](const StudyPass& pass) { return pass.name == name; });
    return found != record.passes.end() ? *found : record.passes.emplace_back(StudyPass{name, {}});
}

void add_passes(const ordered_json& passes, StudyRecord& record) {
    if (!passes.is_array()) return;
    for (const ordered_json& row : passes) {
        if (!row.is_object() || !row.contains("name")) continue;
        StudyPass& pass = pass_named(record, key_text(row["name"]));
        std::map<std::string, double> values;
        add_numbers(row, {"name", "light"}, values);
        for (const auto& [name, value] : values) pass.values[name] += value;
    }
}

std::optional<double> plain_value(const StudyRecord& record, const std::string& id,
                                  const std::vector<std::string>* passes) {
    if (!passes) {
        const auto found = record.values.find(id);
        return found == record.values.end() ? std::nullopt : std::optional(found->second);
    }
    std::optional<double> sum;
    for (const StudyPass& pass : record.passes) {
        if (std::find(passes->begin(), passes->end(), pass.name) == passes->end()) continue;
        if (const auto found = pass.values.find(id); found != pass.values.end())
            sum = sum.value_or(0.0) + found->second;
    }
    return sum;
}

} // namespace

StudyRecord study_record(const ordered_json& head, const ordered_json& result, const ordered_json& timing) {
    StudyRecord record;
    record.cell = key_text(head.at("cell"));
    for (const char* key : {"block", "scene", "camera", "light", "size", "technique"})
        if (head.contains(key)) record.keys[key] = key_text(head[key]);
    const auto add_parameters = [&](const ordered_json& object, const std::string& prefix) {
        for (const auto& item : object.items()) record.keys[prefix + item.key()] = key_text(item.value());
    };
    if (head.contains("parameters")) add_parameters(head["parameters"], "parameters.");
    if (head.contains("reference")) {
        record.keys["reference.technique"] = key_text(head["reference"].at("technique"));
        add_parameters(head["reference"].at("parameters"), "reference.parameters.");
    }
    if (!result.is_object()) return record;
    record.failed = result.value("status", "") != "ok";
    if (record.failed) return record;
    for (const char* key : {"metrics", "counters"})
        if (result.contains(key)) add_numbers(result[key], {}, record.values);
    for (const char* key : {"pixels", "masked", "missing"})
        if (result.contains(key) && result[key].is_number()) record.values[key] = result[key].get<double>();
    if (result.contains("passes")) add_passes(result["passes"], record);
    if (!timing.is_object()) return record;
    for (const char* key : {"seconds", "peak_bytes"})
        if (timing.contains(key)) record.values[key] = timing[key].get<double>();
    if (timing.contains("passes")) add_passes(timing["passes"], record);
    return record;
}

bool is_selected(const StudyRecord& record, const StudySelection& selection) {
    return std::all_of(selection.begin(), selection.end(), [&](const auto& choice) {
        if (choice.first == "pass") return true;
        const auto found = record.keys.find(choice.first);
        return found != record.keys.end() &&
               std::find(choice.second.begin(), choice.second.end(), found->second) != choice.second.end();
    });
}

std::optional<double> value_of(const StudyRecord& record, const StudyQuantity& quantity,
                               const std::vector<std::string>* passes) {
    const std::optional<double> first = plain_value(record, quantity.first, passes);
    if (!first || !quantity.operation) return first;
    std::optional<double> second = plain_value(record, quantity.second, passes);
    if (!second) second = plain_value(record, quantity.second, nullptr);
    if (!second) return {};
    switch (quantity.operation) {
    case '+':
        return *first + *second;
    case '-':
        return *first - *second;
    default:
        return *second == 0 ? std::nullopt : std::optional(*first / *second);
    }
}

const std::vector<std::string>& aggregate_names() {
    static const std::vector<std::string> names = {"mean", "min", "max", "median", "sum"};
    return names;
}

double aggregate_of(const std::string& how, std::vector<double> values) {
    const double sum = std::accumulate(values.begin(), values.end(), 0.0);
    const auto count = static_cast<double>(values.size());
    if (how == "sum") return sum;
    if (how == "min") return *std::min_element(values.begin(), values.end());
    if (how == "max") return *std::max_element(values.begin(), values.end());
    if (how != "median") return sum / count;
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

std::optional<double> power_of(const std::vector<std::pair<double, double>>& points) {
    double x_sum = 0, y_sum = 0, xx = 0, xy = 0;
    for (const auto& [x, y] : points) {
        if (!(x > 0) || !(y > 0) || !std::isfinite(x) || !std::isfinite(y)) return {};
        x_sum += std::log(x), y_sum += std::log(y);
    }
    const auto count = static_cast<double>(points.size());
    for (const auto& [x, y] : points) {
        const double dx = std::log(x) - x_sum / count;
        xx += dx * dx, xy += dx * (std::log(y) - y_sum / count);
    }
    if (points.size() < 2 || xx < 1e-12) return {};
    return xy / xx;
}

} // namespace gnomon
