#include "eval/study/tables.h"

#include <algorithm>
#include <map>

namespace gnomon {
namespace {

using nlohmann::ordered_json;

std::string dump(const ordered_json& value) {
    return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

using Cells = std::map<std::string, std::string>; // column → text

// The columns that one top-level key has led to so far.
struct Columns {
    std::string key;
    std::vector<std::string> names;
};

void flatten(const std::string& name, const ordered_json& value, Columns& columns, Cells& cells) {
    if (value.is_object()) {
        for (const auto& item : value.items()) flatten(name + "." + item.key(), item.value(), columns, cells);
        return;
    }
    if (std::find(columns.names.begin(), columns.names.end(), name) == columns.names.end())
        columns.names.push_back(name);
    cells[name] = value.is_null() ? "" : value.is_string() ? value.get<std::string>() : dump(value);
}

// Keys that some lines lack stand where they would be in a line that has all of them.
std::vector<Columns> top_level_keys(const std::vector<ordered_json>& lines) {
    std::vector<Columns> keys;
    for (const ordered_json& line : lines) {
        auto place = keys.begin();
        for (const auto& item : line.items()) {
            const auto found = std::find_if(keys.begin(), keys.end(),
                                            [&](const Columns& columns) { return columns.key == item.key(); });
            place = found == keys.end() ? keys.insert(place, {item.key(), {}}) + 1 : found + 1;
        }
    }
    return keys;
}

} // namespace

std::string csv_text(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"') result += c;
        result += c;
    }
    result += '"';
    return result;
}

ordered_json result_line(const ordered_json& head, const ordered_json& result) {
    ordered_json line = head;
    for (const char* key : {"status", "message"})
        if (result.contains(key)) line[key] = result[key];
    for (const char* key : {"metrics", "counters"})
        line[key] = result.contains(key) ? result[key] : ordered_json(ordered_json::object());
    line["files"] = ordered_json::object();
    if (result.contains("visibility_bytes"))
        line["files"]["visibility"] = "cells/" + head["cell"].get<std::string>() + "/visibility.exr";
    for (const char* key : {"pixels", "masked", "missing"})
        if (result.contains(key)) line[key] = result[key];
    return line;
}

ordered_json timing_line(const ordered_json& head, const ordered_json& timing) {
    ordered_json line = head;
    line.erase("reference");
    for (const char* key : {"seconds", "peak_bytes"})
        if (timing.is_object() && timing.contains(key)) line[key] = timing[key];
    return line;
}

std::string json_lines(const std::vector<ordered_json>& lines) {
    std::string text;
    for (const ordered_json& line : lines) text += dump(line) + "\n";
    return text;
}

std::string csv(const std::vector<ordered_json>& lines) {
    std::vector<Columns> keys = top_level_keys(lines);
    std::vector<Cells> rows;
    for (const ordered_json& line : lines) {
        Cells& cells = rows.emplace_back();
        for (Columns& columns : keys)
            if (line.contains(columns.key)) flatten(columns.key, line[columns.key], columns, cells);
    }
    std::vector<std::string> names;
    for (const Columns& columns : keys) names.insert(names.end(), columns.names.begin(), columns.names.end());
    std::string text;
    for (const std::string& name : names) {
        if (&name != names.data()) text += ',';
        text += csv_text(name);
    }
    text += "\r\n";
    for (const Cells& cells : rows) {
        for (const std::string& name : names) {
            if (&name != names.data()) text += ',';
            if (const auto found = cells.find(name); found != cells.end()) text += csv_text(found->second);
        }
        text += "\r\n";
    }
    return text;
}

} // namespace gnomon
