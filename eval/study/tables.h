#pragma once
// The lines of a study as JSON lines and as CSV.

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gnomon {

// A row's head with what its cell came to; docs/studies.md has the form.
nlohmann::ordered_json result_line(const nlohmann::ordered_json& head, const nlohmann::ordered_json& result);
// The same with what it took: {"cell", "block", …, "seconds", "peak_bytes"}, the last two not
// for a cell that failed.
nlohmann::ordered_json timing_line(const nlohmann::ordered_json& head, const nlohmann::ordered_json& timing);

// A field of CSV, in quotes where it must be. [RFC 4180]
std::string csv_text(const std::string& text);

std::string json_lines(const std::vector<nlohmann::ordered_json>& lines);

// A column for every value of the lines, named after the keys that lead to it with dots between them; empty where a
// line has none. Columns of one top-level key stand together, in the order in which lines first have them. [RFC 4180]
std::string csv(const std::vector<nlohmann::ordered_json>& lines);

} // namespace gnomon
