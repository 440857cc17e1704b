#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/parameters.h"

using namespace gnomon;

namespace {

enum class Mode { Near, Far };
struct Base {
    int size = 1024;
};
struct Params : Base {
    float bias = 0.1f;
    bool enabled = true;
    Mode mode = Mode::Far;
};
constexpr auto base_fields = fields(field("size", &Base::size, 1, 16384, "texels", "side"));
constexpr auto all_fields =
    join(base_fields,
         fields(field("bias", &Params::bias, -1, 1, "m", "offset", "Paper 2000, 3"),
                field("enabled", &Params::enabled, "whether"), field("mode", &Params::mode, "near|far", "which")));

std::string error_of(const ParameterText& text) {
    try {
        parse_parameters<Params>(all_fields, text, "technique 'x'");
    } catch (const UsageError& error) {
        return error.what();
    }
    return "";
}

} // namespace

TEST_CASE("a table of fields sets its struct and leaves the defaults alone") {
    const Params params =
        parse_parameters<Params>(all_fields, {{"bias", "-0.25"}, {"mode", "near"}, {"enabled", "off"}}, "x");
    CHECK(params.size == 1024);
    CHECK(params.bias == -0.25f);
    CHECK(params.mode == Mode::Near);
    CHECK_FALSE(params.enabled);
}

TEST_CASE("parameter errors name the owner, the parameter and what would be right") {
    CHECK(error_of({{"sise", "3"}}) == "technique 'x' has no parameter 'sise'; did you mean 'size'?");
    CHECK(error_of({{"size", "0"}}) ==
          "technique 'x': parameter 'size' is '0', but must be between 1 and 16384 texels");
    CHECK(error_of({{"size", "1.5"}}) == "technique 'x': parameter 'size' is '1.5', but must be a whole number");
    CHECK(error_of({{"bias", "nan"}}) == "technique 'x': parameter 'bias' is 'nan', but must be a number");
    CHECK(error_of({{"bias", "1e999"}}) == "technique 'x': parameter 'bias' is '1e999', but must be a number");
    CHECK(error_of({{"bias", ""}}) == "technique 'x': parameter 'bias' is '', but must be a number");
    CHECK(error_of({{"mode", "fra"}}) ==
          "technique 'x': parameter 'mode' is 'fra', but must be one of near, far; did you mean 'far'?");
    CHECK(error_of({{"enabled", "maybe"}}) ==
          "technique 'x': parameter 'enabled' is 'maybe', but must be true or false");
}

TEST_CASE("parameters as JSON carry values as the user wrote them, defaults included") {
    std::vector<ParameterInfo> table;
    for (const BoundParameter& row : bind<Params>(all_fields)) table.push_back(row.info);
    CHECK(parameters_json(table, {{"size", "512"}}).dump() == R"({"bias":0.1,"enabled":true,"mode":"far","size":512})");
    const nlohmann::json rows = parameter_table_json(table);
    CHECK(rows[0]["name"] == "size");
    CHECK(rows[0]["type"] == "integer");
    CHECK(rows[1]["default"] == 0.1);
    CHECK(rows[1]["source"] == "Paper 2000, 3");
    CHECK(rows[3]["choices"] == std::vector<std::string>{"near", "far"});
    CHECK(rows[3]["min"].is_null());
}

TEST_CASE("a preset's values stand in for defaults, and keys given beside it win") {
    constexpr auto table =
        join(all_fields, fields(preset("far", "size=16,bias=0.5", "as far as it goes", "Paper 2001")));
    const auto parse = [&](const ParameterText& text) {
        return parse_parameters<Params>(table, text, "technique 'x'");
    };
    CHECK(parse({{"preset", "far"}}).size == 16);
    CHECK(parse({{"preset", "far"}}).bias == 0.5f);
    CHECK(parse({{"preset", "far"}, {"bias", "0.25"}}).bias == 0.25f);
    CHECK(parse({{"preset", "far"}, {"bias", "0.25"}}).size == 16);
    CHECK(parse({{"preset", "none"}}).size == 1024);
    CHECK(parse({{"size", "512"}}).bias == 0.1f);
    CHECK_THROWS_WITH(parse({{"preset", "fra"}}),
                      "technique 'x': parameter 'preset' is 'fra', but must be one of none, "
                      "far; did you mean 'far'?");

    std::vector<ParameterInfo> infos;
    for (const BoundParameter& row : bind<Params>(table)) infos.push_back(row.info);
    CHECK(parameters_json(infos, {{"preset", "far"}, {"size", "8"}}).dump() ==
          R"({"bias":0.5,"enabled":true,"mode":"far","preset":"far","size":8})");
    CHECK(parameter_table_json(infos).back()["choices"] == std::vector<std::string>{"none", "far"});
    CHECK(parameter_table_text(infos).find("size=16,bias=0.5") != std::string::npos);
}

TEST_CASE("specifications split into a name and its parameters") {
    const Specification s = parse_specification("pcf:size=512,kernel=7");
    CHECK(s.name == "pcf");
    CHECK(s.parameters == ParameterText{{"size", "512"}, {"kernel", "7"}});
    CHECK(parse_specification("sm").parameters.empty());
    CHECK_THROWS_AS(parse_specification("sm:size"), UsageError);
    CHECK_THROWS_AS(parse_specification("sm:size=1,size=2"), UsageError);
}
