// Grids, blocks and tables, with a program that renders nothing.

#include <catch2/catch.hpp>

#include <array>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "core/parameters.h"
#include "eval/study/store.h"
#include "eval/study/study.h"
#include "eval/study/tables.h"
#include "tests/support.h"

using namespace gnomon;
using namespace gnomon_tests;
using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

struct MapParams {
    int size = 1024;
};
struct FilterParams : MapParams {
    int kernel = 15;
    float bias = 0.1f;
};
struct NoParams {};
constexpr auto map_rows = fields(field("size", &MapParams::size, 1, 4096, "texels", "side"));
constexpr auto filter_rows = join(map_rows, fields(field("kernel", &FilterParams::kernel, 1, 63, "taps", "side"),
                                                   field("bias", &FilterParams::bias, 0, 1, "", "offset")));

template <class Params, class Table> StudyTechnique technique(const std::string& id, const Table& table) {
    StudyTechnique row{id, 1, {}, [table, id](const ParameterText& text) {
                           parse_parameters<Params>(table, text, "technique '" + id + "'");
                       }};
    for (const BoundParameter& parameter : bind<Params>(table)) row.parameters.push_back(parameter.info);
    return row;
}

StudyProgram program() {
    StudyProgram program;
    program.version = "test";
    program.techniques = {technique<MapParams>("map", map_rows), technique<FilterParams>("filter", filter_rows),
                          technique<NoParams>("volume", fields()), technique<MapParams>("truth", map_rows)};
    program.check_view = [](const StudyView&) {};
    return program;
}

StudyPlan plan_of(const std::string& text, const StudyProgram& lent = program()) {
    const std::string path = temporary_folder() + "/study.json";
    std::ofstream(path) << text;
    return read_study(path, lent);
}

std::string summary(const PlannedRow& row) {
    return row.head["block"].get<std::string>() + " " + row.head["size"].get<std::string>() + " " +
           row.head["technique"].get<std::string>() + " " + row.head["varied"].dump();
}

} // namespace

TEST_CASE("shared parameters go to every technique that has them", "[study]") {
    // Macedo 2018, tables 4.1 and 4.3: sizes for all, a kernel of its own for one; kernels for those that have one.
    const StudyPlan plan = plan_of(R"({
        "scenes": "builtin:half-plane", "sizes": "1280x720",
        "blocks": [
            {"name": "sizes", "parameters": {"size": [512, 1024]},
             "techniques": ["volume", "map", {"technique": "filter", "kernel": 7}]},
            {"name": "kernels", "parameters": {"kernel": [7, 15]},
             "techniques": [{"technique": ["map", "filter"], "size": 1024}]},
            {"name": "output", "sizes": ["854x480", "1280x720"], "techniques": "filter:kernel=7"}]
    })");
    std::vector<std::string> rows;
    for (const PlannedRow& row : plan.rows) rows.push_back(summary(row));
    CHECK(rows == std::vector<std::string>{
                      R"(sizes 1280x720 volume {})", R"(sizes 1280x720 map {"size":512})",
                      R"(sizes 1280x720 map {"size":1024})", R"(sizes 1280x720 filter {"size":512})",
                      R"(sizes 1280x720 filter {"size":1024})", R"(kernels 1280x720 map {})",
                      R"(kernels 1280x720 filter {"kernel":7})", R"(kernels 1280x720 filter {"kernel":15})",
                      R"(output 854x480 filter {})", R"(output 1280x720 filter {})"});
    // The filter with size 1024 and kernel 7 at 720p stands in all three blocks, the map with 1024 in two.
    CHECK(plan.rows[4].cell == plan.rows[6].cell);
    CHECK(plan.rows[4].cell == plan.rows[9].cell);
    CHECK(plan.rows[2].cell == plan.rows[5].cell);
    CHECK(plan.cells.size() == 7);
    CHECK(plan.truths.size() == 2);
}

TEST_CASE("parameters multiply in the order of the technique's table", "[study]") {
    const StudyPlan plan = plan_of(R"({"scenes": "builtin:half-plane", "truth": {"size": [1, 2]},
        "techniques": {"technique": "filter", "kernel": [3, 5], "bias": [0.5, 0.25], "size": [64, 32]}})");
    REQUIRE(plan.rows.size() == 16);
    CHECK(plan.rows[0].head["varied"].dump() == R"({"size":64,"kernel":3,"bias":0.5,"reference.size":1})");
    CHECK(plan.rows[1].head["varied"].dump() == R"({"size":64,"kernel":3,"bias":0.25,"reference.size":1})");
    CHECK(plan.rows[2].head["varied"].dump() == R"({"size":64,"kernel":5,"bias":0.5,"reference.size":1})");
    CHECK(plan.rows[4].head["varied"].dump() == R"({"size":32,"kernel":3,"bias":0.5,"reference.size":1})");
    CHECK(plan.rows[15].head["varied"].dump() == R"({"size":32,"kernel":5,"bias":0.25,"reference.size":2})");
    CHECK(plan.truths.size() == 2);
    CHECK(plan.rows[15].head["reference"]["file"] == "truths/" + plan.truths[1].hash + ".exr");
}

TEST_CASE("a cell's hash depends on all that its result does", "[study]") {
    const auto hash_of = [](const std::string& scene, const std::string& technique, const std::string& more = "",
                            const StudyProgram& lent = program()) {
        const StudyPlan plan =
            plan_of(R"({"scenes": ")" + scene + R"(", "techniques": ")" + technique + "\"" + more + "}", lent);
        REQUIRE(plan.cells.size() == 1);
        CHECK(plan.cells[0].hash.size() == 16);
        return plan.cells[0].hash;
    };
    const std::string hash = hash_of("builtin:half-plane", "map");
    CHECK(hash_of("builtin:half-plane", "map:size=1024") == hash); // the default, said aloud
    std::vector<std::string> others = {
        hash_of("builtin:half-plane:slope=0.5", "map"),
        hash_of("builtin:fence", "map"),
        hash_of("builtin:half-plane", "map:size=512"),
        hash_of("builtin:half-plane", "truth"),
        hash_of("builtin:half-plane", "map", R"(, "sizes": "64x36")"),
        hash_of("builtin:half-plane", "map", R"(, "truth": "truth:size=7")"),
        hash_of("builtin:half-plane", "map", R"(, "metrics": "rmse")"),
        hash_of("builtin:half-plane", "map", R"(, "primary": "ray")"),
        hash_of("builtin:half-plane", "map", R"(, "cameras": {"fov": 30})"),
        hash_of("builtin:half-plane", "map", R"(, "lights": "lamp")"),
    };
    StudyProgram newer = program();
    newer.techniques[0].version = 2;
    others.push_back(hash_of("builtin:half-plane", "map", "", newer));
    newer = program();
    newer.version = "test 2";
    others.push_back(hash_of("builtin:half-plane", "map", "", newer));
    others.push_back(hash);
    std::sort(others.begin(), others.end());
    CHECK(std::adjacent_find(others.begin(), others.end()) == others.end());
}

TEST_CASE("a study too large to be meant is refused", "[study]") {
    std::string values;
    for (int i = 1; i < 400; ++i) values += std::to_string(i) + ",";
    values += "400";
    CHECK_THROWS_WITH(plan_of(R"({"scenes": "builtin:half-plane", "techniques":
        {"technique": "filter", "size": [)" +
                              values +
                              R"(], "bias": [0, 0.1], "kernel": [1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20,
        21,22,23,24,25,26,27,28,29,30,31,32,33,34,35,36,37,38,39,40,41,42,43,44,45,46,47,48,49,50,51,52,53,54,55,56,57,58,59,60,61,62,63]},
        "truth": {"size": [)" +
                              values + "]}}"),
                      Catch::Contains("the study has 20160000 rows"));
}

TEST_CASE("tables flatten their lines", "[study]") {
    const std::vector<ordered_json> lines = {
        ordered_json::parse(R"({"a": "x", "p": {"size": 1}, "m": {"rmse": 0.5}})"),
        ordered_json::parse(
            R"({"a": "say \"no\", twice", "p": {"size": 2, "kernel": true}, "why": "so", "m": {}, "z": null})")};
    CHECK(csv(lines) == "a,p.size,p.kernel,why,m.rmse,z\r\n"
                        "x,1,,,0.5,\r\n"
                        "\"say \"\"no\"\", twice\",2,true,so,,\r\n");
    CHECK(json_lines({lines[0]}) == R"({"a":"x","p":{"size":1},"m":{"rmse":0.5}})"
                                    "\n");
}

TEST_CASE("a store replaces what is broken and clears up after the dead", "[study]") {
    const std::string folder = temporary_folder();
    ChannelImage image;
    image.width = image.height = 2;
    image.add("V", Image<float>(2, 2, 0.5f));
    const ordered_json result = {{"identity", {{"a", 1}}}, {"status", "ok"}};
    {
        StudyStore store(folder);
        CHECK_FALSE(store.result("cell"));
        store.put_cell("cell", result, {{"seconds", 1}}, &image);
        REQUIRE(store.result("cell"));
        CHECK(store.timing("cell")["seconds"] == 1);
        fs::resize_file(folder + "/cells/cell/visibility.exr", 10);
        CHECK_FALSE(store.result("cell"));
        store.put_cell("cell", result, {{"seconds", 2}}, &image);
        CHECK(store.timing("cell")["seconds"] == 2);

        const TruthClaim first = store.claim_truth("truth", false);
        CHECK(first.held());
        CHECK_FALSE(store.claim_truth("truth", false).held());
    }
    CHECK_FALSE(fs::exists(folder + "/scratch"));
    CHECK_FALSE(fs::exists(folder + "/claims"));
    // A run that died: its lock is nobody's.
    fs::create_directories(folder + "/scratch/run-000000");
    std::ofstream(folder + "/scratch/run-000000/lock") << "";
    std::ofstream(folder + "/scratch/run-000000/half.exr") << "half";
    StudyStore(folder).remove_abandoned();
    CHECK_FALSE(fs::exists(folder + "/scratch"));
}

TEST_CASE("runs that share a study's folder make and remove what is in it at once", "[study]") {
    const std::string folder = temporary_folder() + "/study";
    ChannelImage image;
    image.width = image.height = 2;
    image.add("V", Image<float>(2, 2, 0.5f));
    std::array<std::atomic<int>, 200> holders{};
    std::atomic<int> truths{0};
    std::vector<std::string> failures(6);
    std::vector<std::thread> runs;
    for (std::string& failure : failures)
        runs.emplace_back([&] {
            try {
                for (std::size_t round = 0; round < holders.size(); ++round) {
                    StudyStore store(folder);
                    store.remove_abandoned();
                    store.put_cell("cell", {{"identity", {{"a", 1}}}, {"status", "ok"}}, {{"seconds", 1}}, nullptr);
                    const std::string truth = "truth" + std::to_string(round);
                    const TruthClaim claim = store.claim_truth(truth, true);
                    if (!claim.held() || ++holders[round] > 1) throw InputError("a claim has two holders, or none");
                    if (!store.truth(truth)) store.put_truth(truth, image), ++truths;
                    --holders[round];
                }
            } catch (const std::exception& error) {
                failure = error.what();
            }
        });
    for (std::thread& run : runs) run.join();
    for (const std::string& failure : failures) CHECK(failure == "");
    CHECK(truths == 200);
    CHECK(StudyStore(folder).result("cell"));
    CHECK_FALSE(fs::exists(folder + "/scratch"));
    CHECK_FALSE(fs::exists(folder + "/claims"));
}
