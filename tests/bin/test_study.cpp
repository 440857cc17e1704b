// gnomon study as laboratories see it: killed, repeated, split, merged, failing, and asked for nonsense.

#include <catch2/catch.hpp>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <random>
#include <thread>

#include <nlohmann/json.hpp>

#include "core/image_file.h"
#include "tests/bin/cli.h"

using namespace gnomon_tests;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

// 4 scenes × 7 techniques × 3 sizes.
const char* many_cells = R"({
  "scenes": ["builtin:half-plane", "builtin:fence", "builtin:staircase", "builtin:stacked-plates"],
  "sizes": ["64x36", "32x18", "48x27"],
  "truth": {"samples": 64},
  "techniques": ["sm:size=128", "pcf:size=128,kernel=3", "vsm:size=128", "pcss:size=128", "sv-zpass", "sv-zfail", "raytraced"]
})";

const char* few_cells = R"({
  "scenes": ["builtin:half-plane", "builtin:fence"], "sizes": "48x27", "truth": {"samples": 16},
  "techniques": {"technique": "pcf", "size": [64, 128], "kernel": [3, 5]}
})";

std::string study_file(const std::string& folder, const std::string& text) {
    write_bytes(folder + "/study.json", text);
    return folder + "/study.json";
}

std::vector<std::string> run(const std::string& study, const std::string& folder,
                             const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"study", "run", study, "-o", folder};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

// Everything in the folder of a study that must be the same bytes wherever and however often it is made.
std::map<std::string, std::string> results_in(const std::string& folder) {
    std::map<std::string, std::string> files = files_in(folder);
    std::erase_if(files, [](const auto& file) {
        return file.first.ends_with("timing.json") || file.first.starts_with("timings.");
    });
    return files;
}

std::vector<json> lines_of(const std::string& path) {
    std::istringstream text(read_bytes(path));
    std::vector<json> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line));
    return lines;
}

void check_same(const std::map<std::string, std::string>& results, const std::map<std::string, std::string>& expected) {
    for (const auto& file : expected) {
        INFO(file.first);
        CHECK(results.contains(file.first));
        CHECK((results.contains(file.first) && results.at(file.first) == file.second));
    }
    for (const auto& file : results) {
        INFO(file.first << " is one too many");
        CHECK(expected.contains(file.first));
    }
}

} // namespace

TEST_CASE("a study that is killed again and again ends with the bytes of an undisturbed one", "[bin][study]") {
    const std::string folder = temporary_folder(), study = study_file(folder, many_cells);
    const double duration = milliseconds_of(run(study, folder + "/whole", {"--threads", "1"}));
    const auto whole = results_in(folder + "/whole");
    CHECK(whole.size() == 84 * 2 + 12 + 3);
    const unsigned seed = std::random_device()();
    INFO("seed " << seed << ", undisturbed " << duration << " ms");
    std::mt19937 random(seed);
    int stopped = 0;
    for (int i = 0; i < 8; ++i) {
        const int signal = i % 4 == 1 ? SIGINT : i % 4 == 3 ? SIGTERM : SIGKILL;
        const int limit = int(std::uniform_real_distribution<>(0, 0.4 * duration)(random));
        const int code = run_and_stop(run(study, folder + "/killed", {"--threads", "1"}), limit, signal);
        CHECK((code == 0 || code == 128 + signal));
        stopped += code != 0;
        if (fs::exists(folder + "/killed/results.csv")) fs::remove_all(folder + "/killed");
    }
    CHECK(stopped > 0);
    check_success(run(study, folder + "/killed"));
    check_same(results_in(folder + "/killed"), whole);
}

TEST_CASE("a second run of a study does nothing", "[bin][study]") {
    const std::string folder = temporary_folder(), study = study_file(folder, few_cells), out = folder + "/out";
    CHECK(check_success(run(study, out)).find("8 cells: 0 there before, 8 computed; tables in") == 0);
    const auto before = files_in(out);
    CHECK(check_success(run(study, out)).find("8 cells: 8 there before, 0 computed, nothing to do") == 0);
    CHECK(files_in(out) == before);
    CHECK(check_success({"study", "collect", out}).find("8 of 8 cells") == 0);
    CHECK(files_in(out) == before);
    fs::rename(out, folder + "/moved");
    fs::create_directory(folder + "/elsewhere");
    CHECK(check_success(run(study_file(folder + "/elsewhere", few_cells), folder + "/moved")).find("8 there before") !=
          std::string::npos);
}

TEST_CASE("shards of a study merge by copying", "[bin][study]") {
    const std::string folder = temporary_folder(), study = study_file(folder, many_cells);
    check_success(run(study, folder + "/whole"));
    CHECK(check_success(run(study, folder + "/one", {"--shard", "1/2"})).find("42 cells of 84 in shard 1/2: 0 there") ==
          0);
    check_success(run(study, folder + "/two", {"--shard", "2/2"}));
    CHECK_FALSE(fs::exists(folder + "/one/results.csv"));
    check_failure({"study", "collect", folder + "/one"}, 3, "42 of 84 cells are missing");
    check_success({"study", "collect", folder + "/one", "--partial"});
    CHECK(lines_of(folder + "/one/results.jsonl").size() == 42);
    fs::copy(folder + "/two", folder + "/one", fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    check_success({"study", "collect", folder + "/one"});
    check_same(results_in(folder + "/one"), results_in(folder + "/whole"));
    CHECK(check_success(run(study, folder + "/one")).find("84 there before, 0 computed") != std::string::npos);
    check_failure(run(study, folder + "/one", {"--shard", "3/2"}), 2, "--shard");
}

TEST_CASE("shards can fill one folder at once", "[bin][study]") {
    const std::string folder = temporary_folder(), study = study_file(folder, many_cells);
    check_success(run(study, folder + "/whole"));
    ProgramRun first, second;
    std::thread other([&] {
        first = run_gnomon(run(study, folder + "/shared", {"--shard", "1/2", "--threads", "1"}));
    });
    second = run_gnomon(run(study, folder + "/shared", {"--shard", "2/2", "--threads", "1"}));
    other.join();
    INFO(first.errors << second.errors);
    CHECK(first.exit_code == 0);
    CHECK(second.exit_code == 0);
    check_same(results_in(folder + "/shared"), results_in(folder + "/whole"));
}

TEST_CASE("what a cut copy left of a cell or a truth is made again", "[bin][study]") {
    const std::string folder = temporary_folder(), study = study_file(folder, few_cells), out = folder + "/out";
    check_success(run(study, out));
    const auto whole = results_in(out);
    const std::string cell = lines_of(out + "/results.jsonl")[0]["cell"];
    const std::string truth = lines_of(out + "/results.jsonl")[0]["reference"]["file"];
    fs::resize_file(out + "/cells/" + cell + "/visibility.exr", 300);
    fs::resize_file(out + "/" + truth, 300);
    CHECK(check_success(run(study, out)).find("7 there before, 1 computed") != std::string::npos);
    check_same(results_in(out), whole);
    fs::resize_file(out + "/cells/" + cell + "/result.json", 30);
    CHECK(check_success(run(study, out)).find("7 there before, 1 computed") != std::string::npos);
    check_same(results_in(out), whole);
}

TEST_CASE("a line of results has the documented form", "[bin][study]") {
    const std::string folder = temporary_folder(), out = folder + "/out";
    check_success(run(study_file(folder, few_cells), out));
    const std::vector<json> lines = lines_of(out + "/results.jsonl"), timings = lines_of(out + "/timings.jsonl");
    REQUIRE(lines.size() == 8);
    REQUIRE(timings.size() == 8);
    const json& line = lines[1];
    CHECK(line["block"] == "study");
    CHECK(line["scene"] == "builtin:half-plane");
    CHECK(line["camera"] == "default");
    CHECK(line["light"] == "default");
    CHECK(line["size"] == "48x27");
    CHECK(line["technique"] == "pcf");
    CHECK(line["parameters"]["size"] == 64);
    CHECK(line["parameters"]["kernel"] == 5);
    CHECK(line["parameters"].contains("slope-bias"));
    CHECK(line["varied"] == json{{"size", 64}, {"kernel", 5}});
    CHECK(line["reference"]["technique"] == "truth");
    CHECK(line["reference"]["parameters"]["samples"] == 16);
    CHECK(line["status"] == "ok");
    CHECK_FALSE(line.contains("message"));
    CHECK(line["pixels"] == 48 * 27);
    for (const char* counter : {"draws", "vertices", "triangles", "fragments_covered", "fragments_passed",
                                "fragments_shaded", "texels_fetched", "bytes_read", "bytes_written", "target_bytes"})
        CHECK(line["counters"][counter].get<std::int64_t>() > 0);
    CHECK(timings[1]["cell"] == line["cell"]);
    CHECK(timings[1]["seconds"].get<double>() > 0);
    CHECK(timings[1]["peak_bytes"].get<std::int64_t>() > 1'000'000);
    // The same numbers as gnomon compare on the files.
    const json compared =
        json::parse(check_success({"compare", out + "/" + line["files"]["visibility"].get<std::string>(),
                                   out + "/" + line["reference"]["file"].get<std::string>(), "--json", "-"}));
    CHECK(line["metrics"] == compared["metrics"]);
    // And the image is the one that gnomon render makes.
    check_success({"render", "builtin:half-plane", "-t", "pcf:size=64,kernel=5", "--size", "48x27", "-o",
                   folder + "/render.exr"});
    const gnomon::ChannelImage rendered = gnomon::read_image(folder + "/render.exr");
    const gnomon::ChannelImage cell = gnomon::read_image(out + "/" + line["files"]["visibility"].get<std::string>());
    for (const char* channel : {"V", "M"})
        CHECK(std::ranges::equal(cell.find(channel)->values.values(), rendered.find(channel)->values.values()));
}

TEST_CASE("failed cells are recorded and do not stop the rest", "[bin][study]") {
    const std::string folder = temporary_folder(), out = folder + "/out";
    write_bytes(folder + "/broken.glb", "this is no glTF");
    const std::string study = study_file(folder, R"({
        "scenes": ["broken.glb", "builtin:half-plane"], "sizes": "16x9", "truth": {"samples": 4},
        "lights": [{"name": "lamp", "light": "point:0,4,0"}, {"name": "none", "light": "nobody"}], "techniques": ["sm", "sv-zfail"]
    })");
    check_failure(run(study, out, {"--quiet"}), 1, "6 of 8 cells in '" + out + "' failed; the first: ");
    const std::vector<json> lines = lines_of(out + "/results.jsonl");
    REQUIRE(lines.size() == 8);
    for (size_t i = 0; i < 8; ++i) {
        INFO(lines[i]);
        const bool ok = i == 4 || i == 5; // the good scene under the good light
        CHECK(lines[i]["status"] == (ok ? "ok" : "failed"));
        CHECK(lines[i].contains("message") == !ok);
        CHECK(lines[i]["metrics"].empty() == !ok);
        CHECK(lines[i]["files"].empty() == !ok);
    }
    const std::string message = lines[0]["message"];
    CHECK(message.find("broken.glb") != std::string::npos);
    CHECK(message.find(folder) == std::string::npos);
    CHECK(lines[6]["message"].get<std::string>().find("'nobody'") != std::string::npos);

    const auto before = files_in(out);
    check_failure(run(study, out, {"--quiet"}), 1, "6 of 8 cells");
    CHECK(files_in(out) == before);
    const ProgramRun again = run_gnomon(run(study, out, {"--retry-failed"}));
    CHECK(again.exit_code == 1);
    CHECK(again.output.find("8 cells: 2 there before, 6 computed") == 0);
    CHECK(results_in(out).size() == 8 + 2 + 1 + 3);
}

TEST_CASE("a changed scene file computes only its own cells anew", "[bin][study]") {
    const std::string folder = temporary_folder(), out = folder + "/out";
    const auto triangle = [](float height) {
        return make_glb({-1, 0, -1, 1, 0, -1, 0, 0, 1, -1, height, -1, 1, height, -1, 0, height, 1},
                        {0, 2, 1, 3, 5, 4});
    };
    write_bytes(folder + "/a.glb", triangle(0.5f));
    write_bytes(folder + "/b.glb", triangle(0.25f));
    write_bytes(folder + "/c.json", R"({"objects": [{"gltf": "b.glb"}, {"shape": "plane", "size": 4}]})");
    const std::string study = study_file(folder, R"({
        "scenes": ["a.glb", "b.glb", "c.json"], "sizes": "16x9", "truth": {"samples": 4}, "techniques": ["sm", "raytraced"]
    })");
    check_success(run(study, out));
    write_bytes(folder + "/a.glb", triangle(0.75f));
    CHECK(check_success(run(study, out)).find("6 cells: 4 there before, 2 computed") == 0);
    write_bytes(folder + "/b.glb", triangle(0.75f)); // c.json refers to it
    CHECK(check_success(run(study, out)).find("6 cells: 2 there before, 4 computed") == 0);
    write_bytes(folder + "/b.glb", triangle(0.25f)); // as it was
    CHECK(check_success(run(study, out)).find("6 cells: 6 there before, 0 computed") == 0);
}

TEST_CASE("a dry run lists the rows of a study and writes nothing", "[bin][study]") {
    const std::string folder = temporary_folder(), study = study_file(folder, few_cells), out = folder + "/out";
    const std::string listed = check_success(run(study, out, {"--dry-run"}));
    CHECK(std::count(listed.begin(), listed.end(), '\n') == 8);
    CHECK(listed.find("to do") == 0);
    CHECK(listed.find("pcf:size=64,kernel=5") != std::string::npos);
    CHECK_FALSE(fs::exists(out));
    check_success(run(study, out));
    CHECK(check_success(run(study, out, {"--dry-run"})).find("there") == 0);
}

TEST_CASE("the studies that come with the program are good", "[bin][study]") {
    const std::string folder = std::string(GNOMON_SOURCE) + "/data/studies";
    for (const auto& entry : fs::directory_iterator(folder))
        CHECK_FALSE(check_success(run(entry.path().string(), temporary_folder(), {"--dry-run"})).empty());
}

TEST_CASE("A bad study is one line that names the file and the place", "[bin][study]") {
    const std::string folder = temporary_folder(), out = folder + "/out";
    struct Case {
        std::string text, words;
    };
    const std::vector<Case> cases = {
        {"{", "not valid JSON"},
        {"[]", "the document must be an object"},
        {R"({"scenes": "builtin:fence"})", "has no 'techniques'"},
        {R"({"techniques": "sm"})", "has no 'scenes'"},
        {R"({"scnes": "builtin:fence", "techniques": "sm"})", "scnes is not a known key; did you mean 'scenes'?"},
        {R"({"scenes": [], "techniques": "sm"})", "scenes must not be empty"},
        {R"({"scenes": "builtin:fense", "techniques": "sm"})",
         "scenes: there is no builtin scene 'fense'; did you mean 'fence'?"},
        {R"({"scenes": "builtin:half-plane:slop=1", "techniques": "sm"})", "did you mean 'slope'?"},
        {R"({"scenes": ["builtin:fence", "nowhere.glb"], "techniques": "sm"})",
         "scenes[1] is 'nowhere.glb', but there is no such file"},
        {R"({"scenes": ["builtin:fence", "builtin:fence"], "techniques": "sm"})",
         "scenes[1] is called 'builtin:fence', as another"},
        {R"({"scenes": "builtin:fence", "techniques": "pfc"})",
         "techniques is 'pfc', which is no technique; did you mean 'pcf'?"},
        {R"({"scenes": "builtin:fence", "techniques": ["sm", 5]})", "techniques[1] must be a technique"},
        {R"({"scenes": "builtin:fence", "techniques": {"size": 5}})", "techniques has no 'technique'"},
        {R"({"scenes": "builtin:fence", "techniques": {"technique": "pcf", "kernl": 3}})",
         "techniques.kernl: technique 'pcf' has no parameter 'kernl'; did you mean 'kernel'?"},
        {R"({"scenes": "builtin:fence", "techniques": {"technique": "pcf", "kernel": [3, 99]}})",
         "techniques.kernel[1]: technique 'pcf': parameter 'kernel' is '99', but must be between 1 and 63"},
        {R"({"scenes": "builtin:fence", "techniques": {"technique": "pcf", "kernel": [3, 3]}})",
         "techniques.kernel[1] is 3, which is in the list already"},
        {R"({"scenes": "builtin:fence", "techniques": "pcf:kernel=x"})",
         "techniques: technique 'pcf': parameter 'kernel' is 'x'"},
        {R"({"scenes": "builtin:fence", "techniques": "pcf:kernel"})",
         "techniques: 'kernel' in 'pcf:kernel' is not of the form"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "parameters": {"siz": 5}})",
         "parameters.siz is no parameter of any of the techniques; did you mean 'size'?"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "truth": {"sample": 5}})",
         "truth.sample: technique 'truth' has no parameter 'sample'; did you mean 'samples'?"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "sizes": ["64x36", "64"]})",
         "sizes[1]: the size is '64', but must be WIDTHxHEIGHT"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "sizes": ["64x36", "64x36"]})",
         "sizes[1] is 64x36, which is in the list already"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "primary": "rays"})", "primary: primary is 'rays', but"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "cameras": {"look_from": [1, 2]}})",
         "cameras: --look-from is '1,2', but must be three numbers"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "cameras": {"look_form": [1, 2, 3]}})",
         "did you mean 'look_from'?"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "lights": [{"light": "point:0,1,0", "size": 2}]})",
         "lights[0]: a point light has no size"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "metrics": ["rmsee"]})",
         "metrics[0] is 'rmsee', which is no metric; did you mean 'rmse'?"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "blocks": []})", "blocks must not be empty"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "blocks": [{}]})", "blocks[0] has no 'name'"},
        {R"({"scenes": "builtin:fence", "techniques": "sm", "blocks": [{"name": "a"}, {"name": "a"}]})",
         "blocks[1].name is 'a', as another block"},
        {R"({"scenes": "builtin:fence", "blocks": [{"name": "a", "techniques": "pcf:kernal=3"}]})",
         "blocks[0].techniques"},
    };
    for (const Case& row : cases) {
        const std::string study = study_file(folder, row.text);
        const ProgramRun failed = run_gnomon(run(study, out));
        INFO(row.text << "\n" << failed.errors);
        CHECK(failed.exit_code == 3);
        CHECK(failed.output.empty());
        CHECK(failed.errors.starts_with("gnomon: " + study + ": "));
        CHECK(failed.errors.find(row.words) != std::string::npos);
        CHECK(std::count(failed.errors.begin(), failed.errors.end(), '\n') == 1);
    }
    CHECK_FALSE(fs::exists(out));
    check_failure(run(folder + "/nowhere.json", out), 3, "nowhere.json");
    check_failure({"study"}, 2, "a command is missing (gnomon study --help");
    check_failure({"study", "rnu"}, 2, "there is no command 'rnu'; did you mean 'run'?");
    check_failure(run("x.json", out, {"--shrad", "1/2"}), 2, "did you mean '--shard'? (gnomon study run --help");
    check_failure({"study", "run", study_file(folder, few_cells)}, 2, "--output");
    check_failure(run(study_file(folder, few_cells), folder + "/study.json"), 3, "cannot write");
    check_failure({"study", "collect", folder}, 3, "study.json: the document has no 'format'");
    check_failure({"study", "collect", folder + "/nowhere"}, 3, "holds no study");
}
