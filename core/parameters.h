#pragma once
// One table per technique (or builtin scene): the struct's defaults are the only defaults, and the table is the only
// place that knows names, ranges, units and help. The command line, `gnomon help`, JSON, range errors, EXR metadata and
// study grids are all made from it.
//
//   struct PcfParams : ShadowMapParams { int kernel = 15; };
//   constexpr auto pcf_fields = join(shadow_map_fields, fields(
//       field("kernel", &PcfParams::kernel, 1, 63, "texels", "side of the filter kernel", "Macedo 2018, 4.3.1")));
//
// A preset is a row as well: values for several other rows, which stand in for their defaults where it is chosen.
//
//   preset("published", "size=2048,border=shadow", "as in the author's programs", "…")  adds  preset=none|published

#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace gnomon {

// Values as written by the user: name → text, in order of name.
using ParameterText = std::map<std::string, std::string>;

enum class ParameterType { Integer, Real, Boolean, Choice };
const char* parameter_type_name(ParameterType type); // "integer", "real", "boolean", "choice"

// A parameter without its struct: what help, JSON and error messages need.
struct ParameterInfo {
    std::string name;
    ParameterType type = ParameterType::Real;
    std::string default_text; // as the user would write it
    double minimum = 0;       // integer and real only
    double maximum = 0;
    std::vector<std::string> choices; // choice only; the enumerator's value is the index
    std::string unit, help, source;
    ParameterText preset; // of the row that chooses a preset: the values that its second choice stands for
};

// One row of the table. T is int, float, bool or an enum whose enumerators count from 0 in the order of `choices`.
template <class Params, class T> struct Field {
    std::string_view name;
    T Params::*member;
    double minimum, maximum;
    std::string_view unit, help, source, choices; // choices: "a|b|c", enums only
};

template <class P, class T>
requires std::is_arithmetic_v<T>
constexpr Field<P, T> field(std::string_view name, T P::*member, double minimum, double maximum, std::string_view unit,
                            std::string_view help, std::string_view source = "") {
    return {name, member, minimum, maximum, unit, help, source, ""};
}

template <class P>
constexpr Field<P, bool> field(std::string_view name, bool P::*member, std::string_view help,
                               std::string_view source = "") {
    return {name, member, 0, 1, "", help, source, ""};
}

template <class P, class T>
requires std::is_enum_v<T>
constexpr Field<P, T> field(std::string_view name, T P::*member, std::string_view choices, std::string_view help,
                            std::string_view source = "") {
    return {name, member, 0, 0, "", help, source, choices};
}

// The row "preset", with the choices "none", the default, and `name`. `values` is written as after a technique's colon.
struct PresetField {
    std::string_view name, values, help, source;
};
constexpr PresetField preset(std::string_view name, std::string_view values, std::string_view help,
                             std::string_view source = "") {
    return {name, values, help, source};
}

template <class... Fields> constexpr auto fields(Fields... rows) { return std::make_tuple(rows...); }

template <class... Tables> constexpr auto join(Tables... tables) { return std::tuple_cat(tables...); }

// A table bound to its struct, without its type: name, get and set as text.
struct BoundParameter {
    ParameterInfo info;
    std::function<std::string(const void*)> get;
    std::function<void(void*, const std::string&)> set; // text already validated by `set_parameters`
};

namespace detail {
ParameterInfo make_info(std::string_view name, ParameterType type, double minimum, double maximum,
                        std::string_view unit, std::string_view help, std::string_view source,
                        std::string_view choices);
ParameterInfo make_info(const PresetField& row);
std::string to_text(const ParameterInfo& info, double value);
double to_value(const ParameterInfo& info, const std::string& text);

template <class Params, class P, class T> BoundParameter bind_field(const Field<P, T>& row, const Params& defaults) {
    constexpr ParameterType type = std::is_same_v<T, bool> ? ParameterType::Boolean
                                   : std::is_enum_v<T>     ? ParameterType::Choice
                                   : std::is_integral_v<T> ? ParameterType::Integer
                                                           : ParameterType::Real;
    BoundParameter parameter;
    parameter.info = make_info(row.name, type, row.minimum, row.maximum, row.unit, row.help, row.source, row.choices);
    const auto member = row.member;
    parameter.get = [info = parameter.info, member](const void* params) {
        return to_text(info, static_cast<double>(static_cast<const Params*>(params)->*member));
    };
    parameter.set = [info = parameter.info, member](void* params, const std::string& text) {
        static_cast<Params*>(params)->*member = static_cast<T>(to_value(info, text));
    };
    parameter.info.default_text = parameter.get(&defaults);
    return parameter;
}
} // namespace detail

template <class Params, class Table> std::vector<BoundParameter> bind(const Table& table) {
    std::vector<BoundParameter> bound;
    const Params defaults{};
    const auto add = [&]<class Row>(const Row& row) {
        if constexpr (std::is_same_v<Row, PresetField>) {
            const ParameterInfo info = detail::make_info(row);
            bound.push_back(
                {info, [info](const void*) { return info.default_text; }, [](void*, const std::string&) {}});
        } else {
            bound.push_back(detail::bind_field(row, defaults));
        }
    };
    std::apply([&](const auto&... rows) { (add(rows), ...); }, table);
    return bound;
}

// What is set in all: the values of the preset that `text` chooses, where it does not give them itself, then `text`.
ParameterText with_preset(std::span<const ParameterInfo> table, const ParameterText& text);

// Sets the named members of `params`, and those of the preset; the others keep their values. Throws UsageError naming
// `owner` ("technique 'pcf'"), the parameter and the nearest known name, or the range, or the choices.
void set_parameters(std::span<const BoundParameter> table, void* params, const ParameterText& text,
                    const std::string& owner);

template <class Params, class Table>
Params parse_parameters(const Table& table, const ParameterText& text, const std::string& owner) {
    Params params{};
    const std::vector<BoundParameter> bound = bind<Params>(table);
    set_parameters(bound, &params, text, owner);
    return params;
}

// All parameters with the values that a run with `text` uses, preset and defaults included, typed: {"size": 1024,
// "bias": 0.5, …}.
nlohmann::json parameters_json(std::span<const ParameterInfo> table, const ParameterText& text);
// The rows for `gnomon list --json`: name, type, default, min, max (null where none), choices, unit, help, source.
nlohmann::json parameter_table_json(std::span<const ParameterInfo> table);
// The rows for `gnomon help`, aligned, one or two lines a parameter.
std::string parameter_table_text(std::span<const ParameterInfo> table);

// Splits "name:key=value,key=value" into the name and its parameters. Throws UsageError where a part has no '='.
struct Specification {
    std::string name;
    ParameterText parameters;
};
Specification parse_specification(const std::string& text);

} // namespace gnomon
