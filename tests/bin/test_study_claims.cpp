// Tables and claims of a study from its file to its pages: run, split, merged, printed, with scenes that are not there.

#include <catch2/catch.hpp>

#include <filesystem>

#include <nlohmann/json.hpp>

#include "tests/bin/cli.h"

using namespace gnomon_tests;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

const char* asking = R"({
  "name": "asking", "scenes": ["builtin:fence", {"name": "ghost", "scene": "ghost.json", "optional": true}], "sizes": "64x36",
  "truth": "raytraced", "metrics": ["rmse", "over", "under"],
  "blocks": [
    {"name": "maps", "techniques": [{"technique": ["sm", "pcf"], "size": [64, 256]}, "sv-zfail"]},
    {"name": "steps", "scenes": "builtin:fence", "techniques": "sm:size=64"}],
  "tables": [
    {"name": "Table 1", "where": {"block": "maps"}, "rows": "technique", "columns": "parameters.size", "values": ["rmse", "texels_fetched"], "baseline": {"technique": "sm"}},
    {"name": "Table 2", "where": {"block": "steps"}, "rows": "pass", "columns": "size", "values": "fragments_shaded"}],
  "claims": [
    {"id": "A", "text": "Volumes are nearest.", "checks": {"value": "rmse", "where": {"technique": "sv-zfail"}, "is": "<", "than": {"where": {"technique": "sm"}}, "per": ["scene", "parameters.size"]}},
    {"id": "B", "text": "Larger maps are better.", "checks": {"value": "rmse", "where": {"technique": "sm"}, "power_of": "parameters.size", "is": "<", "number": 0}},
    {"id": "C", "text": "PCF fetches less.", "note": "It does not.", "checks": {"value": "texels_fetched", "where": {"technique": "pcf"}, "is": "<", "than": {"where": {"technique": "sm"}}}},
    {"id": "D", "text": "Ghosts cast shadows.", "checks": {"value": "under", "where": {"scene": "ghost"}, "is": ">", "number": 0}}]
})";

std::vector<std::string> run(const std::string& study, const std::string& folder, const std::string& share = "1/1") {
    return {"study", "run", study, "-o", folder, "--shard", share, "--quiet"};
}

} // namespace

TEST_CASE("a study answers its claims and prints its tables, whichever shards made it", "[bin][study]") {
    const std::string folder = temporary_folder(), study = folder + "/study.json", whole = folder + "/whole";
    write_bytes(study, asking);
    const ProgramRun first = run_gnomon({"study", "run", study, "-o", whole});
    CHECK(first.exit_code == 0);
    CHECK(first.errors == "gnomon: the scene 'ghost' is skipped: ghost.json is not there\n");
    CHECK(first.output.find("5 cells: 0 there before, 5 computed") == 0);
    CHECK(first.output.ends_with("; 1 scene skipped\n"));

    const json claims = json::parse(read_bytes(whole + "/claims.json"))["claims"];
    REQUIRE(claims.size() == 4);
    CHECK(claims[0]["verdict"] == "holds");
    CHECK(claims[0]["checks"][0]["groups"].size() == 1); // of sv-zfail, whose cell has no size
    CHECK(claims[1]["verdict"] == "holds");
    CHECK(claims[2]["verdict"] == "does not hold");
    CHECK(claims[2]["note"] == "It does not.");
    CHECK(claims[3]["verdict"] == "not measured");
    CHECK(claims[3]["checks"][0]["measured"] == "no rows: scenes were skipped or cells are missing");

    const std::string page = check_success({"study", "tables", whole, "--title", "Asked"});
    CHECK(page.find("# Asked\n\n## asking\n\n") == 0);
    CHECK(page.find("the scene 'ghost' was **skipped**, since ghost.json is not there") != std::string::npos);
    CHECK(page.find("| technique | 64 | 256 |\n") != std::string::npos);
    CHECK(page.find("| pass | 64x36 |\n|---|---:|\n| G-buffer | ") != std::string::npos);
    CHECK(page.find("| look-up | ") != std::string::npos);
    CHECK(page.find("**C** PCF fetches less.<br>*It does not.*") != std::string::npos);
    check_success({"study", "tables", whole, "-o", folder + "/tables.csv"});
    const std::string csv = read_bytes(folder + "/tables.csv");
    CHECK(csv.find("table,quantity,row,column,value,relative\r\nTable 1,rmse,sm,64,0.") == 0);
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 12 + 3);

    check_success(run(study, folder + "/one", "1/2"));
    check_success(run(study, folder + "/two", "2/2"));
    CHECK_FALSE(fs::exists(folder + "/one/claims.json"));
    fs::copy(folder + "/two", folder + "/one", fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    check_success({"study", "collect", folder + "/one"});
    CHECK(read_bytes(folder + "/one/claims.json") == read_bytes(whole + "/claims.json"));
    check_success({"study", "report", whole, "-o", folder + "/report.html"});
    const std::string report = read_bytes(folder + "/report.html");
    CHECK(report.find("Ghosts cast shadows.") != std::string::npos);
    CHECK(report.find("Table 2") != std::string::npos);
}

TEST_CASE("a scene that lacks a file is skipped where it may be, and an error where not", "[bin][study]") {
    const std::string folder = temporary_folder(), study = folder + "/study.json";
    write_bytes(folder + "/half.json", R"({"objects": [{"shape": "plane"}, {"gltf": "gone.glb"}]})");
    write_bytes(study,
                R"({"scenes": ["builtin:half-plane", {"scene": "half.json", "optional": true}], "techniques": "sm",
        "sizes": "16x9", "truth": "raytraced"})");
    const ProgramRun skipped = run_gnomon({"study", "run", study, "-o", folder + "/out"});
    CHECK(skipped.exit_code == 0);
    CHECK(skipped.errors == "gnomon: the scene 'half.json' is skipped: gone.glb is not there\n");
    write_bytes(study, R"({"scenes": {"scene": "half.json", "optional": true}, "techniques": "sm"})");
    check_failure(run(study, folder + "/out"), 3, "none of its scenes is there; the first that is missing: 'gone.glb'");
    write_bytes(study, R"({"scenes": {"scene": "none.json", "optional": false}, "techniques": "sm"})");
    check_failure(run(study, folder + "/out"), 3, "is 'none.json', but there is no such file");
}

TEST_CASE("a question that no cell can answer stops a study before it begins", "[bin][study]") {
    const std::string folder = temporary_folder(), study = folder + "/study.json", out = folder + "/out";
    const auto fails = [&](const std::string& claim, const std::string& words) {
        write_bytes(
            study,
            R"({"scenes": "builtin:fence", "techniques": ["sm", "pcf:kernel=3"], "claims": {"id": "A", "text": "x", "checks": )" +
                claim + "}}");
        check_failure(run(study, out), 3, words);
        CHECK_FALSE(fs::exists(out));
    };
    fails(R"({"value": "rmsee", "is": "<", "number": 1})",
          "claims.checks.value has 'rmsee', which is neither a metric nor a counter nor a time; did you mean 'rmse'?");
    fails(R"({"value": "texels_fetch", "is": "<", "number": 1})", "did you mean 'texels_fetched'?");
    fails(R"({"value": "rmse", "where": {"technique": "pfc"}, "is": "<", "number": 1})", "did you mean 'pcf'?");
    fails(R"({"value": "rmse", "where": {"technique": "vsm"}, "is": "<", "number": 1})",
          "claims.checks.where chooses no row of the study: none has technique 'vsm'");
    fails(R"({"value": "rmse", "where": {"technique": "pcf", "parameters.kernel": 5}, "is": "<", "number": 1})",
          "none has parameters.kernel '5'");
    check_failure({"study", "tables", folder + "/nowhere"}, 3, "holds no study");
    check_failure({"study", "tables", out, "-o", folder + "/x.txt"}, 2, "-o takes an .md or .csv file");
    check_failure({"study", "tables", out, "--format", "html"}, 2, "--format");
}
