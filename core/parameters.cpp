#include "core/parameters.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace gnomon {

const char* parameter_type_name(ParameterType type) {
    switch (type) {
    case ParameterType::Integer:
        return "integer";
    case ParameterType::Real:
        return "real";
    case ParameterType::Boolean:
        return "boolean";
    case ParameterType::Choice:
        return "choice";
    }
    return "";
}

namespace detail {

ParameterInfo make_info(std::string_view name, ParameterType type, double minimum, double maximum,
                        std::string_view unit, std::string_view help, std::string_view source,
                        std::string_view choices) {
    ParameterInfo info;
    info.name = name;
    info.type = type;
    info.minimum = minimum;
    info.maximum = maximum;
    info.unit = unit;
    info.help = help;
    info.source = source;
    while (!choices.empty()) {
        const size_t bar = std::min(choices.find('|'), choices.size());
        info.choices.emplace_back(choices.substr(0, bar));
        choices.remove_prefix(std::min(bar + 1, choices.size()));
    }
    return info;
}

ParameterInfo make_info(const PresetField& row) {
    ParameterInfo info;
    info.name = "preset";
    info.type = ParameterType::Choice;
    info.choices = {"none", std::string(row.name)};
    info.default_text = info.choices.front();
    info.help = fmt::format("{}: {}; keys given beside it win", row.help, row.values);
    info.source = row.source;
    info.preset = parse_specification(fmt::format("{}:{}", row.name, row.values)).parameters;
    return info;
}

std::string to_text(const ParameterInfo& info, double value) {
    switch (info.type) {
    case ParameterType::Integer:
        return fmt::format("{}", static_cast<long long>(value));
    case ParameterType::Real:
        return fmt::format("{}", static_cast<float>(value)); // shortest text that reads back
    case ParameterType::Boolean:
        return value != 0 ? "true" : "false";
    case ParameterType::Choice:
        return info.choices.at(static_cast<size_t>(value));
    }
    return "";
}

double to_value(const ParameterInfo& info, const std::string& text) {
    if (info.type == ParameterType::Boolean) return text == "true" || text == "on" || text == "yes" || text == "1";
    if (info.type == ParameterType::Choice)
        return static_cast<double>(std::find(info.choices.begin(), info.choices.end(), text) - info.choices.begin());
    double value = std::nan("");
    const char* end = text.data() + text.size();
    if (std::from_chars(text.data(), end, value).ptr != end) return std::nan("");
    return value;
}

} // namespace detail

namespace {

void check_value(const ParameterInfo& info, const std::string& text, const std::string& owner) {
    const auto fail = [&](const std::string& why) {
        throw UsageError(fmt::format("{}: parameter '{}' is '{}', but {}", owner, info.name, text, why));
    };
    const double value = detail::to_value(info, text);
    switch (info.type) {
    case ParameterType::Boolean: {
        static constexpr std::string_view words[] = {"true", "false", "on", "off", "yes", "no", "1", "0"};
        if (std::find(std::begin(words), std::end(words), text) == std::end(words)) fail("must be true or false");
        break;
    }
    case ParameterType::Choice:
        if (static_cast<size_t>(value) >= info.choices.size())
            fail(fmt::format("must be one of {}{}", fmt::join(info.choices, ", "), did_you_mean(text, info.choices)));
        break;
    case ParameterType::Integer:
    case ParameterType::Real:
        if (std::isnan(value)) fail("must be a number");
        if (info.type == ParameterType::Integer && value != std::floor(value)) fail("must be a whole number");
        if (!(value >= info.minimum && value <= info.maximum))
            fail(fmt::format("must be between {} and {}{}{}", info.minimum, info.maximum, info.unit.empty() ? "" : " ",
                             info.unit));
        break;
    }
}

nlohmann::json typed_json(const ParameterInfo& info, const std::string& text) {
    const double value = detail::to_value(info, text);
    switch (info.type) {
    case ParameterType::Integer:
        return static_cast<long long>(value);
    // Through the shortest text, so that 0.1f is written 0.1 and not 0.10000000149.
    case ParameterType::Real:
        return std::stod(fmt::format("{}", static_cast<float>(value)));
    case ParameterType::Boolean:
        return value != 0;
    case ParameterType::Choice:
        return text;
    }
    return nullptr;
}

bool has_range(const ParameterInfo& info) {
    return info.type == ParameterType::Integer || info.type == ParameterType::Real;
}

} // namespace

ParameterText with_preset(std::span<const ParameterInfo> table, const ParameterText& text) {
    ParameterText all = text;
    for (const ParameterInfo& info : table) {
        const auto chosen = text.find(info.name);
        if (!info.preset.empty() && chosen != text.end() && chosen->second == info.choices.back())
            all.insert(info.preset.begin(), info.preset.end()); // which replaces nothing that is there
    }
    return all;
}

void set_parameters(std::span<const BoundParameter> table, void* params, const ParameterText& text,
                    const std::string& owner) {
    std::vector<ParameterInfo> infos;
    for (const BoundParameter& p : table) infos.push_back(p.info);
    for (const auto& [given_name, value] : with_preset(infos, text)) {
        const std::string& name = given_name; // for the lambda: Clang 14 captures no structured bindings
        const auto row = std::find_if(table.begin(), table.end(), [&](const auto& p) { return p.info.name == name; });
        if (row == table.end()) {
            std::vector<std::string> names;
            for (const BoundParameter& p : table) names.push_back(p.info.name);
            throw UsageError(fmt::format("{} has no parameter '{}'{}", owner, name,
                                         names.empty() ? "; it takes none" : did_you_mean(name, names)));
        }
        check_value(row->info, value, owner);
        row->set(params, value);
    }
}

nlohmann::json parameters_json(std::span<const ParameterInfo> table, const ParameterText& text) {
    nlohmann::json json = nlohmann::json::object();
    const ParameterText set = with_preset(table, text);
    for (const ParameterInfo& info : table) {
        const auto given = set.find(info.name);
        json[info.name] = typed_json(info, given == set.end() ? info.default_text : given->second);
    }
    return json;
}

nlohmann::json parameter_table_json(std::span<const ParameterInfo> table) {
    nlohmann::json rows = nlohmann::json::array();
    for (const ParameterInfo& info : table) {
        nlohmann::json row = {{"name", info.name},    {"type", parameter_type_name(info.type)},
                              {"min", nullptr},       {"max", nullptr},
                              {"unit", info.unit},    {"help", info.help},
                              {"source", info.source}};
        row["default"] = typed_json(info, info.default_text);
        if (has_range(info)) row["min"] = info.minimum, row["max"] = info.maximum;
        if (!info.choices.empty()) row["choices"] = info.choices;
        rows.push_back(std::move(row));
    }
    return rows;
}

std::string parameter_table_text(std::span<const ParameterInfo> table) {
    size_t width = 0;
    for (const ParameterInfo& info : table) width = std::max(width, info.name.size() + info.default_text.size() + 1);
    std::string text;
    for (const ParameterInfo& info : table) {
        text += fmt::format("  {:<{}}  {}", info.name + "=" + info.default_text, width, info.help);
        if (!info.choices.empty()) text += fmt::format(" ({})", fmt::join(info.choices, ", "));
        if (has_range(info))
            text += fmt::format(" ({} to {}{}{})", info.minimum, info.maximum, info.unit.empty() ? "" : " ", info.unit);
        if (!info.source.empty()) text += fmt::format(" [{}]", info.source);
        text += '\n';
    }
    return text;
}

Specification parse_specification(const std::string& text) {
    Specification specification;
    const size_t colon = text.find(':');
    specification.name = text.substr(0, colon);
    size_t begin = colon == std::string::npos ? text.size() : colon + 1;
    while (begin < text.size()) {
        const size_t comma = std::min(text.find(',', begin), text.size());
        const std::string part = text.substr(begin, comma - begin);
        const size_t equals = part.find('=');
        if (equals == std::string::npos || equals == 0)
            throw UsageError(fmt::format("'{}' in '{}' is not of the form key=value", part, text));
        if (!specification.parameters.emplace(part.substr(0, equals), part.substr(equals + 1)).second)
            throw UsageError(fmt::format("parameter '{}' is given twice in '{}'", part.substr(0, equals), text));
        begin = comma + 1;
    }
    return specification;
}

} // namespace gnomon
