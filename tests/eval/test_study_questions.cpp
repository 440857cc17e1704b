// Tables and claims of a study on results that were made up: every figure here can be worked out by hand.

#include <catch2/catch.hpp>

#include <filesystem>

#include "core/atomic_file.h"
#include "core/error.h"
#include "eval/study/findings.h"
#include "eval/study/pivot.h"
#include "eval/study/verdict.h"

using namespace gnomon;
using nlohmann::json;
using nlohmann::ordered_json;

namespace {

// A row of block "sizes" whose cell is named after what it is.
StudyRecord row(const std::string& scene, const std::string& technique, int size, double rmse, double texels,
                const std::string& block = "sizes") {
    ordered_json head = {{"cell", scene + technique + std::to_string(size)},
                         {"block", block},
                         {"scene", scene},
                         {"size", "640x360"},
                         {"technique", technique},
                         {"parameters", ordered_json::object()},
                         {"reference", {{"technique", "truth"}, {"parameters", {{"samples", 64}}}}}};
    if (size > 0) head["parameters"]["size"] = size;
    const ordered_json result = {{"status", "ok"},
                                 {"metrics", {{"rmse", rmse}, {"psnr", nullptr}}},
                                 {"counters", {{"texels_fetched", texels}}},
                                 {"masked", 100},
                                 {"passes",
                                  {{{"light", "a"}, {"name", "map"}, {"texels_fetched", 0}, {"fragments_shaded", 7}},
                                   {{"light", "a"}, {"name", "look-up"}, {"texels_fetched", texels - 10}},
                                   {{"light", "b"}, {"name", "look-up"}, {"texels_fetched", 10}}}}};
    const ordered_json timing = {
        {"seconds", 0.5}, {"peak_bytes", 1024}, {"passes", {{{"light", "a"}, {"name", "map"}, {"seconds", 0.125}}}}};
    return study_record(head, result, timing);
}

StudyRecord failed(StudyRecord record) {
    record.failed = true, record.values.clear(), record.passes.clear();
    return record;
}

// Errors 8/size and 4/size; fetches 100 and 10·size; a technique without a map; a row of another block that shares a
// cell.
std::vector<StudyRecord> sample() {
    std::vector<StudyRecord> records;
    for (const std::string scene : {"fence", "hall"}) {
        for (const int size : {2, 4, 8}) {
            records.push_back(row(scene, "sm", size, 8.0 / size, 100));
            records.push_back(row(scene, "pcf", size, 4.0 / size, 10.0 * size));
        }
        records.push_back(row(scene, "sv", 0, 0.25, 0));
    }
    records.push_back(row("fence", "sm", 2, 4, 100, "another"));
    return records;
}

StudyVocabulary vocabulary() {
    return {{"rmse", "psnr", "texels_fetched", "fragments_shaded", "masked", "seconds", "peak_bytes"},
            {"sm", "pcf", "sv", "vsm"},
            sample()};
}

StudyQuestions questions(const std::string& text) {
    const json document = json::parse(text);
    const std::string file = "study.json";
    const StudyVocabulary known = vocabulary();
    return read_questions(JsonReader(document, file), &known);
}

StudyPivot pivot(const std::string& keys, const std::vector<StudyRecord>& records = sample()) {
    const StudyQuestions read = questions(R"({"tables": {"name": "t", )" + keys + "}}");
    return make_pivots(read.tables.at(0), records).at(0);
}

std::vector<std::string> texts(const StudyPivot& pivot, size_t line) {
    std::vector<std::string> list;
    for (const StudyPlace& place : pivot.places.at(line)) list.push_back(place_text(pivot.quantity, place));
    return list;
}

ClaimResult claim(const std::string& checks, const std::vector<StudyRecord>& records = sample()) {
    const StudyQuestions read = questions(R"({"claims": {"id": "C", "text": "so it is", "checks": )" + checks + "}}");
    return judge(read.claims.at(0), read.labels, records);
}

using Texts = std::vector<std::string>;

} // namespace

TEST_CASE("aggregates and exponents are their definitions", "[study]") {
    CHECK(aggregate_of("mean", {1, 2, 6}) == 3);
    CHECK(aggregate_of("sum", {1, 2, 6}) == 9);
    CHECK(aggregate_of("min", {2, 1, 6}) == 1);
    CHECK(aggregate_of("max", {2, 1, 6}) == 6);
    CHECK(aggregate_of("median", {6, 1, 2}) == 2);
    CHECK(aggregate_of("median", {6, 1, 2, 4}) == 3);
    CHECK(power_of({{1, 3}, {2, 12}, {4, 48}}).value() == Approx(2));
    CHECK(power_of({{2, 5}, {8, 5}}).value() == Approx(0).margin(1e-15));
    CHECK_FALSE(power_of({{2, 5}}));
    CHECK_FALSE(power_of({{2, 5}, {2, 6}}));
    CHECK_FALSE(power_of({{2, 0}, {4, 6}}));
}

TEST_CASE("a record has the values of its row, its passes and its times", "[study]") {
    const StudyRecord record = row("fence", "pcf", 4, 0.5, 40);
    CHECK(record.keys.at("parameters.size") == "4");
    CHECK(record.keys.at("reference.parameters.samples") == "64");
    CHECK(std::isinf(record.values.at("psnr")));
    CHECK(value_of(record, {"seconds", "", 0}).value() == 0.5);
    CHECK(value_of(record, {"texels_fetched", "masked", '/'}).value() == 0.4);
    CHECK(value_of(record, {"texels_fetched", "masked", '-'}).value() == -60);
    CHECK(value_of(record, {"texels_fetched", "masked", '+'}).value() == 140);
    const Texts lookup = {"look-up"}, map = {"map"}, none = {"blur"};
    CHECK(value_of(record, {"texels_fetched", "", 0}, &lookup).value() == 40); // of both lights
    CHECK(value_of(record, {"texels_fetched", "masked", '/'}, &lookup).value() == 0.4);
    CHECK(value_of(record, {"seconds", "", 0}, &map).value() == 0.125);
    CHECK_FALSE(value_of(record, {"texels_fetched", "", 0}, &none));
    CHECK_FALSE(value_of(record, {"ssim", "", 0}));
    CHECK_FALSE(value_of(row("a", "sv", 0, 1, 0), {"rmse", "texels_fetched", '/'})); // nothing is divided by 0
}

TEST_CASE("a pivot has a row for each technique and a column for each size", "[study]") {
    const StudyPivot table = pivot(R"("rows": ["scene", "technique"], "columns": "parameters.size", "values": "rmse")");
    CHECK(table.columns == Texts{"2", "4", "8"});
    REQUIRE(table.rows.size() == 6);
    CHECK(table.rows[1] == Texts{"fence", "pcf"});
    CHECK(texts(table, 0) == Texts{"4", "2", "1"}); // the row that another block shares counts once
    CHECK(texts(table, 1) == Texts{"2", "1", "0.5"});
    CHECK(texts(table, 2) == Texts{"0.25", "0.25", "0.25"}); // what has no size stands in every column
    CHECK(table.rows[3] == Texts{"hall", "sm"});
}

TEST_CASE("a pivot takes a baseline, labels, aggregates and selections", "[study]") {
    const StudyPivot table =
        pivot(R"("where": {"parameters.size": [2, 8]}, "rows": "technique", "columns": "parameters.size",
        "values": "texels_fetched/masked", "baseline": {"technique": "sm"},
        "labels": {"technique": {"sm": "Map", "pcf": "Filter"}, "parameters.size": {"2": "2²"}})");
    CHECK(table.columns == Texts{"2²", "8"});
    CHECK(table.rows == std::vector<Texts>{{"Map"}, {"Filter"}}); // sv has no size, and is not chosen
    CHECK(texts(table, 0) == Texts{"1", "1"});
    CHECK(texts(table, 1) == Texts{"0.2 (-80.0 %)", "0.8 (-20.0 %)"});
    // Rows of one label come together: the mean, or whatever else is asked for.
    const std::string merged = R"("where": {"technique": ["sm", "pcf"]}, "rows": "scene", "columns": "parameters.size",
        "values": "rmse", "aggregate": )";
    CHECK(texts(pivot(merged + "\"mean\""), 0) == Texts{"3", "1.5", "0.75"});
    CHECK(texts(pivot(merged + "\"max\""), 1) == Texts{"4", "2", "1"});
}

TEST_CASE("a pivot of passes sums those of one label and leaves empty what is not there", "[study]") {
    std::vector<StudyRecord> records = {row("fence", "sm", 2, 4, 100), failed(row("fence", "sm", 4, 4, 100))};
    const StudyPivot table = pivot(R"("where": {"technique": "sm"}, "rows": "pass", "columns": "parameters.size",
        "values": "texels_fetched", "labels": {"pass": {"map": "Map", "look-up": "Filter"}})",
                                   records);
    CHECK(table.rows == std::vector<Texts>{{"Map"}, {"Filter"}});
    CHECK(table.columns == Texts{"2"}); // a cell that failed has no passes
    CHECK(texts(table, 1) == Texts{"100"});
    records.push_back(row("hall", "sm", 8, 4, 100));
    const StudyPivot cells = pivot(R"("rows": "scene", "columns": "parameters.size", "values": "rmse")", records);
    CHECK(texts(cells, 0) == Texts{"4", "failed", ""});
    CHECK(texts(cells, 1) == Texts{"", "", "4"});
    CHECK(texts(pivot(R"("rows": "pass", "columns": "parameters.size", "where": {"pass": "map"}, "values": "seconds")",
                      records),
                0) == Texts{"125 ms", "125 ms"});
}

TEST_CASE("numbers are told as readers want them", "[study]") {
    CHECK(quantity_text({"rmse", "", 0}, 0.053912) == "0.05391");
    CHECK(quantity_text({"rmse", "", 0}, INFINITY) == "∞");
    CHECK(quantity_text({"seconds", "", 0}, 0.0123) == "12.3 ms");
    CHECK(quantity_text({"seconds", "", 0}, 12.34) == "12.3 s");
    CHECK(quantity_text({"texels_fetched", "", 0}, 999) == "999");
    CHECK(quantity_text({"texels_fetched", "", 0}, 12345678) == "12.3 M");
    CHECK(quantity_text({"target_bytes", "", 0}, 4194304) == "4 MiB");
    CHECK(quantity_title({"texels_fetched", "masked", '/'}) == "texels fetched / masked");
    CHECK(quantity_title({"rmse", "", 0}) == "root mean square error");
}

TEST_CASE("a claim holds where all of its groups do", "[study]") {
    // pcf's error is half of sm's in each of six groups.
    const auto against = [&](const char* relation, const char* factor) {
        return claim(R"({"value": "rmse", "where": {"technique": "pcf"}, "is": ")" + std::string(relation) +
                     R"(", "times": )" + factor +
                     R"(, "than": {"where": {"technique": "sm"}}, "per": ["scene", "parameters.size"]})");
    };
    const ClaimResult result = against("<=", "0.5");
    CHECK(result.verdict == Verdict::Holds);
    REQUIRE(result.checks[0].groups.size() == 6);
    CHECK(result.checks[0].groups[4].name == "scene hall, size 4");
    CHECK(result.checks[0].groups[4].left == 1);
    CHECK(result.checks[0].groups[4].right == 2);
    CHECK(result.checks[0].groups[4].bound == 1);
    CHECK(result.checks[0].formula ==
          "rmse of [technique pcf] <= 0.5 × rmse of [technique sm], for each scene and size");
    CHECK(against("<", "0.5").verdict == Verdict::Fails);
    CHECK(against("=", "0.5").verdict == Verdict::Holds);
    CHECK(against(">", "0.25").verdict == Verdict::Holds);
    CHECK(against(">=", "0.75").verdict == Verdict::Fails);
    // A technique without sizes is compared in the group of each.
    CHECK(
        claim(
            R"({"value": "rmse", "where": {"technique": "sm"}, "is": ">", "times": 3, "than": {"where": {"technique": "sv"}},
        "per": ["scene", "parameters.size"]})")
            .checks[0]
            .measured == "6 of 6; closest scene fence, size 8: 1 against 0.25");
    // A key that the right side chooses for itself is not held against it.
    CHECK(
        claim(
            R"({"value": "rmse", "where": {"technique": ["pcf", "sv"]}, "is": "<", "than": {"where": {"technique": "sm"}},
        "per": "technique"})")
            .checks[0]
            .measured == "technique pcf: 1.167 against 2.333; technique sv: 0.25 against 2.333");
}

TEST_CASE("a check aggregates, takes exponents and compares with constants", "[study]") {
    const auto measured = [&](const std::string& check) {
        const CheckResult result = claim("{" + check + "}").checks[0];
        return std::string(verdict_text(result.verdict)) + ": " + result.measured;
    };
    CHECK(
        measured(
            R"("value": "rmse", "where": {"technique": "sm"}, "power_of": "parameters.size", "is": "=", "number": -1, "within": 1e-9)") ==
        "holds: -1.00");
    CHECK(
        measured(
            R"("value": "texels_fetched", "where": {"technique": "pcf"}, "power_of": "parameters.size", "is": ">", "number": 1.5)") ==
        "does not hold: 1.00");
    CHECK(measured(R"("value": "rmse", "where": {"technique": "sm"}, "aggregate": "max", "is": "<=", "number": 4)") ==
          "holds: 4");
    CHECK(measured(R"("value": "rmse", "where": {"technique": "sm"}, "is": "=", "number": 2.3, "within": 0.05)") ==
          "holds: 2.333"); // (4 + 2 + 1)/3, the cell of two blocks once
    CHECK(measured(R"("value": "rmse", "where": {"technique": "pcf"}, "is": "=", "number": 1.1, "within": 0.05)") ==
          "does not hold: 1.167");
    CHECK(
        measured(
            R"("value": "rmse", "where": {"technique": "sv"}, "is": "<", "plus": -2, "than": {"where": {"technique": "sm"}})") ==
        "holds: 0.25 against 2.333");
    CHECK(
        measured(
            R"("value": "texels_fetched/masked", "where": {"technique": "pcf", "pass": "look-up", "parameters.size": 8}, "is": "=", "number": 0.8)") ==
        "holds: 0.8");
}

TEST_CASE("a claim says what it could not measure", "[study]") {
    const std::string check = R"({"value": "rmse", "where": {"scene": "hall"}, "is": "<", "number": 10})";
    std::vector<StudyRecord> records = sample();
    std::erase_if(records, [](const StudyRecord& record) { return record.keys.at("scene") == "hall"; });
    CHECK(claim(check, records).verdict == Verdict::NotMeasured);
    CHECK(claim("[" + check + R"(, {"value": "rmse", "is": "<", "number": 10}])", records).verdict == Verdict::InPart);
    CHECK(claim("[" + check + R"(, {"value": "rmse", "is": ">", "number": 10}])", records).verdict == Verdict::Fails);
    records = sample();
    records[0] = failed(records[0]);
    const ClaimResult result =
        claim(R"({"value": "rmse", "where": {"technique": "sm"}, "is": "<", "number": 10, "per": "scene"})", records);
    CHECK(result.verdict == Verdict::InPart);
    CHECK(result.checks[0].measured == "scene hall: 2.333; besides cells failed");
    const ClaimResult test = claim(R"([{"test": "tests/a.cpp", "case": "it is so", "measured": "0", "holds": true},
                  {"test": "tests/a.cpp", "case": "it is not so", "measured": "1", "holds": false}])");
    CHECK(test.verdict == Verdict::InPart);
    CHECK(test.checks[0].formula == "test 'it is so' (tests/a.cpp)");
    CHECK(test.checks[1].verdict == Verdict::Fails);
}

TEST_CASE("a page of Markdown has tables, claims and notes", "[study]") {
    StudyFindings findings;
    findings.name = "made up";
    findings.questions = questions(R"({"description": "Figures.", "notes": "A | B.",
        "tables": {"name": "Table 1", "title": "errors", "where": {"technique": "sm"}, "rows": "scene", "columns": "parameters.size", "values": "rmse"},
        "claims": {"id": "C1", "text": "It falls.", "source": "p. 1", "checks":
            {"value": "rmse", "where": {"technique": "sm"}, "power_of": "parameters.size", "is": "<", "number": 0}}})");
    findings.records = sample();
    findings.skipped = {{"bunny", "bunny.glb"}};
    CHECK(findings_markdown(findings) == R"(## made up

Figures.

15 rows; the scene 'bunny' was **skipped**, since bunny.glb is not there.

### Table 1: errors

**Root mean square error**

| scene | 2 | 4 | 8 |
|---|---:|---:|---:|
| fence | 4 | 2 | 1 |
| hall | 4 | 2 | 1 |

### Claims

| claim | check | measured | holds |
|---|---|---|---|
| **C1** It falls. (p. 1) | exponent over size of rmse of [technique sm] < 0 | -1.00 | **holds** |

### Notes

* A | B.
)");
    CHECK(tables_csv(findings) ==
          "table,quantity,row,column,value,relative\r\n"
          "Table 1,rmse,fence,2,4.0,\r\nTable 1,rmse,fence,4,2.0,\r\nTable 1,rmse,fence,8,1.0,\r\n"
          "Table 1,rmse,hall,2,4.0,\r\nTable 1,rmse,hall,4,2.0,\r\nTable 1,rmse,hall,8,1.0,\r\n");
}

TEST_CASE("a question that cannot be meant is one line that names the place", "[study]") {
    const auto complaint = [](const std::string& text) -> std::string {
        try {
            questions(text);
        } catch (const InputError& error) {
            return error.what();
        }
        return "no complaint";
    };
    const auto table = [&](const std::string& keys) {
        return complaint(R"({"tables": [{"name": "t", )" + keys + "}]}");
    };
    const auto check = [&](const std::string& keys) {
        return complaint(R"({"claims": {"id": "C", "text": "x", "checks": [{)" + keys + "}]}}");
    };
    const std::string axes = R"("rows": "technique", "columns": "parameters.size", )";
    CHECK(table(R"("rows": "technique", "columns": "sizes", "values": "rmse")") ==
          "study.json: tables[0].columns is 'sizes', which is no key of a row; did you mean 'size'?; parameters are "
          "parameters.NAME");
    CHECK(table(axes + R"("values": ["rmse", "rmsee"])") ==
          "study.json: tables[0].values[1] has 'rmsee', which is neither a metric nor a counter nor a time; did you "
          "mean 'rmse'?");
    CHECK(table(axes + R"("values": "rmse", "where": {"technique": "pfc"})") ==
          "study.json: tables[0].where.technique is 'pfc', which is no technique; did you mean 'pcf'?");
    CHECK(table(axes + R"("values": "rmse", "where": {"technique": "vsm"})") ==
          "study.json: tables[0].where chooses no row of the study: none has technique 'vsm'");
    CHECK(table(axes + R"("values": "rmse", "where": {"technique": "sv", "parameters.size": 2})") ==
          "study.json: tables[0].where chooses no row of the study: no row has all that it asks for");
    CHECK(table(axes + R"("values": "rmse", "baseline": {"scene": "fence"})") ==
          "study.json: tables[0].baseline.scene is not among the keys of the table's rows");
    CHECK(table(axes + R"("values": "rmse", "aggregate": "average")") ==
          "study.json: tables[0].aggregate is 'average', but must be one of mean, min, max, median, sum");
    CHECK(table(axes + R"("vales": "rmse")").find("did you mean 'values'?") != std::string::npos);
    CHECK(table(R"("rows": "technique", "values": "rmse")") == "study.json: tables[0] has no 'columns'");
    CHECK(check(R"("value": "rmse", "is": "<")") ==
          "study.json: claims.checks[0] must have either 'number' or 'than', to compare with");
    CHECK(check(R"("value": "rmse", "is": "!=", "number": 1)") ==
          "study.json: claims.checks[0].is is '!=', but must be one of <, <=, >, >=, =");
    CHECK(check(R"("value": "rmse", "is": "<", "number": 1, "times": 2)").find("times is not a known key") !=
          std::string::npos);
    CHECK(check(R"("value": "rmse", "is": "<", "number": 1, "within": 2)") ==
          "study.json: claims.checks[0].within belongs to '=' alone");
    CHECK(check(R"("value": "rmse", "is": "<", "than": {"where": {"scene": "barn"}})") ==
          "study.json: claims.checks[0].than chooses no row of the study: none has scene 'barn'");
    CHECK(complaint(R"({"claims": {"id": "C", "text": "x", "checks": []}})") ==
          "study.json: claims.checks must not be empty");
    CHECK(complaint(R"({"claims": [{"id": "C", "text": "x", "checks": {"value": "rmse", "is": "<", "number": 1}},
                                   {"id": "C", "text": "x", "checks": {"value": "rmse", "is": "<", "number": 1}}]})") ==
          "study.json: claims[1].id is 'C', as another claim's is");
}

TEST_CASE("the tests that claims refer to are there", "[study]") {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(std::string(GNOMON_SOURCE) + "/data/studies")) {
        const json document = json::parse(read_file(entry.path().string()));
        const std::string file = entry.path().string();
        for (const StudyClaim& claim : read_questions(JsonReader(document, file), nullptr).claims)
            for (const ClaimCheck& check : claim.checks) {
                if (!check.is_test()) continue;
                INFO(claim.id << ": " << check.test_file << ", " << check.test_name);
                const std::string source = read_file(std::string(GNOMON_SOURCE) + "/" + check.test_file);
                CHECK(source.find("TEST_CASE(\"" + check.test_name + "\"") != std::string::npos);
                ++count;
            }
    }
    CHECK(count > 10);
}
