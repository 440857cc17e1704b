#include "eval/study/grid.h"

#include <algorithm>

#include <fmt/format.h>

namespace gnomon {
namespace {

constexpr std::size_t most_variants = 100'000;

const StudyTechnique& find_study_technique(const JsonReader& place, const std::string& id,
                                           const StudyProgram& program) {
    std::vector<std::string> ids;
    for (const StudyTechnique& technique : program.techniques) {
        if (technique.id == id) return technique;
        ids.push_back(technique.id);
    }
    place.fail(
        fmt::format("is '{}', which is no technique{} (gnomon list techniques shows them)", id, did_you_mean(id, ids)));
}

// One parameter and the values that it takes.
struct Axis {
    std::string name;
    std::vector<std::string> values;
};

Axis read_axis(const JsonReader& values, const std::string& name, const StudyTechnique& technique) {
    Axis axis{name, {}};
    for (const JsonReader& value : one_or_many(values)) {
        const std::string text = text_of(value);
        check_at(value, [&] { technique.check({{name, text}}); });
        if (std::find(axis.values.begin(), axis.values.end(), text) != axis.values.end())
            value.fail(fmt::format("is {}, which is in the list already", text));
        axis.values.push_back(text);
    }
    return axis;
}

bool has_parameter(const StudyTechnique& technique, const std::string& name) {
    return std::any_of(technique.parameters.begin(), technique.parameters.end(),
                       [&](const ParameterInfo& info) { return info.name == name; });
}

std::vector<Axis> read_axes(const JsonReader& own, const JsonReader* shared, const StudyTechnique& technique) {
    for (const auto& item : own.value().items())
        if (item.key() != "technique" && !has_parameter(technique, item.key()))
            check_at(own.at(item.key()), [&] { technique.check({{item.key(), ""}}); });
    std::vector<Axis> axes;
    for (const ParameterInfo& info : technique.parameters)
        if (own.has(info.name))
            axes.push_back(read_axis(own.at(info.name), info.name, technique));
        else if (shared && shared->has(info.name))
            axes.push_back(read_axis(shared->at(info.name), info.name, technique));
    return axes;
}

StudyVariant make_variant(const StudyTechnique& technique, const std::vector<Axis>& axes, std::size_t index) {
    StudyVariant variant;
    variant.choice.id = technique.id, variant.choice.version = technique.version;
    for (std::size_t i = axes.size(); i-- > 0;) {
        variant.choice.text[axes[i].name] = axes[i].values[index % axes[i].values.size()];
        index /= axes[i].values.size();
    }
    variant.choice.parameters = parameters_json(technique.parameters, variant.choice.text);
    for (const Axis& axis : axes)
        if (axis.values.size() > 1) variant.varied[axis.name] = variant.choice.parameters[axis.name];
    return variant;
}

void add_grid(const JsonReader& place, const std::vector<Axis>& axes, const StudyTechnique& technique,
              std::vector<StudyVariant>& variants) {
    std::size_t count = 1;
    for (const Axis& axis : axes) {
        count *= axis.values.size();
        if (variants.size() + count > most_variants)
            place.fail(fmt::format("asks for more than {} combinations of parameters", most_variants));
    }
    for (std::size_t i = 0; i < count; ++i) {
        variants.push_back(make_variant(technique, axes, i));
        check_at(place, [&] { technique.check(variants.back().choice.text); });
    }
}

// "pcf:size=512,kernel=7"
void read_specification(const JsonReader& place, const JsonReader* shared, const StudyProgram& program,
                        std::vector<StudyVariant>& variants) {
    Specification parsed;
    check_at(place, [&] { parsed = parse_specification(place.text()); });
    const StudyTechnique& technique = find_study_technique(place, parsed.name, program);
    nlohmann::json own = nlohmann::json::object();
    for (const auto& [name, value] : parsed.parameters) own[name] = value;
    std::vector<Axis> axes;
    check_at(place, [&] { technique.check(parsed.parameters); });
    axes = read_axes(JsonReader(own, place.file(), place.path()), shared, technique);
    add_grid(place, axes, technique, variants);
}

void read_object(const JsonReader& object, const JsonReader* shared, const std::string& id, const StudyProgram& program,
                 std::vector<StudyVariant>& variants) {
    if (!object.has("technique") && !id.empty())
        return add_grid(object, read_axes(object, shared, find_study_technique(object, id, program)),
                        find_study_technique(object, id, program), variants);
    for (const JsonReader& place : one_or_many(object.at("technique"))) {
        const StudyTechnique& technique = find_study_technique(place, place.text(), program);
        add_grid(object, read_axes(object, shared, technique), technique, variants);
    }
}

// A shared parameter that no technique has is a misspelt one.
void check_shared(const JsonReader& shared, const std::vector<StudyVariant>& variants, const StudyProgram& program) {
    shared.expect_object();
    for (const auto& item : shared.value().items()) {
        std::vector<std::string> names;
        bool known = false;
        for (const StudyTechnique& technique : program.techniques) {
            if (std::none_of(variants.begin(), variants.end(),
                             [&](const StudyVariant& variant) { return variant.choice.id == technique.id; }))
                continue;
            known = known || has_parameter(technique, item.key());
            for (const ParameterInfo& info : technique.parameters) names.push_back(info.name);
        }
        if (!known)
            shared.at(item.key()).fail("is no parameter of any of the techniques" + did_you_mean(item.key(), names));
    }
}

} // namespace

std::vector<JsonReader> one_or_many(const JsonReader& value) {
    if (!value.value().is_array()) return {value};
    std::vector<JsonReader> elements;
    for (std::size_t i = 0; i < value.size(); ++i) elements.push_back(value[i]);
    if (elements.empty()) value.fail("must not be empty");
    return elements;
}

std::string text_of(const JsonReader& value) {
    if (value.value().is_string()) return value.text();
    if (value.value().is_boolean() || value.value().is_number()) return value.value().dump();
    value.fail("must be a number, a string, true or false");
}

void check_at(const JsonReader& place, const std::function<void()>& check) {
    try {
        check();
    } catch (const UsageError& error) {
        throw InputError(one_line(fmt::format("{}: {}: {}", place.file(), place.path(), error.what())));
    }
}

std::vector<StudyVariant> read_variants(const JsonReader& list, const JsonReader* shared, const std::string& id,
                                        const StudyProgram& program) {
    std::vector<StudyVariant> variants;
    for (const JsonReader& element : one_or_many(list))
        if (element.value().is_string())
            read_specification(element, shared, program, variants);
        else if (element.value().is_object())
            read_object(element, shared, id, program, variants);
        else
            element.fail("must be a technique such as \"pcf:kernel=7\", or an object of one and its parameters");
    if (shared) check_shared(*shared, variants, program);
    return variants;
}

} // namespace gnomon
