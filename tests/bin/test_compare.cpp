// gnomon compare as other people's gate: bounds, files of bounds, masks, maps and sequences.

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "core/image_file.h"
#include "tests/bin/cli.h"

using namespace gnomon_tests;
using gnomon::ChannelImage;
using gnomon::Image;
using nlohmann::json;

namespace {

constexpr int usage = 2, input = 3, width = 40, height = 30;

// Umbra left of `at`.
void write_edge(const std::string& path, int at, int broken_pixels = 0) {
    Image<float> visibility(width, height, 1.0f), ids(width, height, 1.0f);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (x < at) visibility(x, y) = 0.0f;
            if (y >= 20) ids(x, y) = 2.0f; // the upper ten rows
        }
    for (int x = 0; x < broken_pixels; ++x) visibility(x, 0) = std::nanf("");
    ChannelImage image;
    image.add("V", visibility);
    image.add("id", ids);
    write_exr(path, image);
}

json compared(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "compare");
    arguments.insert(arguments.end(), {"--json", "-"});
    return json::parse(check_success(arguments));
}

} // namespace

TEST_CASE("bounds come from the command line and from a file", "[cli]") {
    const std::string folder = temporary_folder(), test = folder + "/test.exr", truth = folder + "/truth.exr",
                      file = folder + "/bounds.json";
    write_edge(test, 23), write_edge(truth, 20);
    const json metrics = compared({test, truth})["metrics"];
    CHECK(metrics["silhouette_max"] == 3.0);
    CHECK(metrics["mae"].get<double>() == Approx(3.0 / width));
    check_success({"compare", test, truth, "--fail-above", "silhouette_max=3", "--fail-below", "ssim=0.1"});

    write_bytes(file,
                R"({"fail_above": {"silhouette_max": 3, "mae": 0.08, "missing": 0}, "fail_below": {"ssim": 0.1}})");
    check_success({"compare", test, truth, "--thresholds", file});
    write_bytes(file, R"({"fail_above": {"silhouette_max": 2.5}, "fail_below": {"ssim": 0.9999}})");
    const ProgramRun run = run_gnomon({"compare", test, truth, "--thresholds", file, "--metrics", "mae"});
    CHECK(run.exit_code == 1);
    CHECK(run.errors.find("silhouette_max is 3, above the bound 2.5; ssim is ") != std::string::npos);
    CHECK(run.output.find("mae") != std::string::npos);

    for (const auto& [text, words] :
         std::vector<std::pair<std::string, std::string>>{{R"({"fail_abov": {}})", "fail_abov"},
                                                          {R"({"fail_above": {"rsme": 1}})", "did you mean 'rmse'?"},
                                                          {R"({"fail_above": {"rmse": "low"}})", "fail_above.rmse"},
                                                          {R"([1])", "bounds.json"},
                                                          {R"({)", "bounds.json"}}) {
        write_bytes(file, text);
        check_failure({"compare", test, truth, "--thresholds", file}, input, words);
    }
    check_failure({"compare", test, truth, "--thresholds", folder + "/none.json"}, input, "none.json");
    const ProgramRun absent = run_gnomon({"compare", test, truth, "--fail-above", "ms_ssim=1"});
    CHECK(absent.exit_code == input);
    CHECK(absent.errors.find("'ms_ssim' cannot be tested: it does not apply") != std::string::npos);
}

TEST_CASE("missing pixels are counted, and can have a bound", "[cli]") {
    const std::string folder = temporary_folder(), test = folder + "/test.exr", truth = folder + "/truth.exr";
    write_edge(test, 20, 5), write_edge(truth, 20);
    const json comparison = compared({test, truth});
    CHECK(comparison["missing"] == 5);
    CHECK(comparison["masked"] == width * height - 5);
    CHECK(comparison["metrics"]["mae"] == 0.0);
    const ProgramRun run = run_gnomon({"compare", test, truth, "--fail-above", "missing=4"});
    CHECK(run.exit_code == 1);
    CHECK(run.errors.find("missing is 5, above the bound 4") != std::string::npos);
    check_success({"compare", test, truth, "--fail-above", "missing=5"});
}

TEST_CASE("masks choose pixels by rectangle, id, file and penumbra", "[cli]") {
    const std::string folder = temporary_folder(), test = folder + "/test.exr", truth = folder + "/truth.exr";
    write_edge(test, 23), write_edge(truth, 20);
    CHECK(compared({test, truth, "--mask", "rect:20,0,3,5"})["metrics"]["mae"] == 1.0);
    CHECK(compared({test, truth, "--mask", "rect:20,0,3,5"})["masked"] == 15);
    CHECK(compared({test, truth, "--mask", "id:2"})["masked"] == 10 * width);
    CHECK(compared({test, truth, "--mask", "id:id=1,2"})["masked"] == width * height);
    // The rectangle is counted from the top, where id 2 is.
    CHECK(compared({test, truth, "--mask", "rect:0,0,40,12", "--mask", "id:1"})["masked"] == 2 * width);
    CHECK(compared({test, truth, "--mask", "penumbra"})["masked"] == 0);
    check_success({"compare", test, truth, "--map", folder + "/map.png"});
    ChannelImage mask;
    mask.add("Y", Image<float>(width, height, 0.0f));
    mask.channels[0].values(21, 7) = 1.0f;
    write_exr(folder + "/mask.exr", mask);
    CHECK(compared({test, truth, "--mask", "file:" + folder + "/mask.exr"})["masked"] == 1);

    for (const char* wrong : {"penumbr", "penumbra:1", "rect", "rect:1,2,3", "rect:1,2,3,x", "id:", "id:x", "file:"})
        check_failure({"compare", test, truth, "--mask", wrong}, usage, "--mask");
    check_failure({"compare", test, truth, "--mask", "rect:30,0,11,1"}, input, "does not lie inside");
    check_failure({"compare", test, truth, "--mask", "id:object=1"}, input, "no layer 'object'");
    check_failure({"compare", test, truth, "--mask", "file:" + folder + "/none.png"}, input, "none.png");
}

TEST_CASE("an EXR map holds the numbers of every kind", "[cli]") {
    const std::string folder = temporary_folder(), test = folder + "/test.exr", truth = folder + "/truth.exr",
                      map = folder + "/map.exr";
    write_edge(test, 23), write_edge(truth, 20);
    const auto error_at_21 = [&](const char* kind, const char* channel) {
        check_success({"compare", test, truth, "--map", map, "--map-kind", kind});
        const ChannelImage image = gnomon::read_image(map);
        REQUIRE(image.find(channel));
        CHECK(image.find("M")->values(21, 10) == 1.0f);
        CHECK(image.find(channel)->values(35, 10) < 0.5f);
        return image.find(channel)->values(21, 10);
    };
    CHECK(error_at_21("signed", "error") == -1.0f);
    CHECK(error_at_21("magnitude", "error") == 1.0f);
    CHECK(error_at_21("overlay", "error") == -1.0f);
    CHECK(error_at_21("false-color", "error") == 1.0f);
    CHECK(error_at_21("flip", "flip") > 0.5f);
    check_success({"compare", test, truth, "--map", folder + "/map.png", "--map-kind", "flip", "--map-range", "0.5"});
    check_failure({"compare", test, truth, "--map", map, "--map-range", "0"}, usage, "--map-range");
}

TEST_CASE("sequences are folders or numbered names, frame by frame", "[cli]") {
    const std::string folder = temporary_folder();
    std::filesystem::create_directories(folder + "/a"), std::filesystem::create_directories(folder + "/b");
    for (const int frame : {8, 9, 10, 11}) {
        char name[16];
        std::snprintf(name, sizeof name, "/f.%04d.exr", frame);
        write_edge(folder + "/a" + name, 20 + frame % 2); // to and fro
        write_edge(folder + "/b" + name, 20);
    }
    const json numbered = compared({folder + "/a/f.####.exr", folder + "/b/f.####.exr"});
    REQUIRE(numbered["frames"].size() == 4);
    CHECK(numbered["frames"][0]["frame"] == "8");
    CHECK(numbered["frames"][2]["frame"] == "10"); // by number, not by letter
    CHECK(numbered["metrics"]["mae"].get<double>() == Approx(0.5 / width));
    CHECK(numbered["metrics"]["temporal_mean"].get<double>() == Approx(1.0 / width));
    CHECK(numbered["metrics"]["temporal_rms"].get<double>() == Approx(std::sqrt(1.0 / width)));
    const json folders = compared({folder + "/a", folder + "/b"});
    CHECK(folders["metrics"] == numbered["metrics"]);
    const ProgramRun run = run_gnomon({"compare", folder + "/a", folder + "/b", "--fail-above", "temporal_mean=0.02"});
    CHECK(run.exit_code == 1);
    check_success({"compare", folder + "/b", folder + "/b", "--fail-above", "temporal_mean=0"});

    check_failure({"compare", folder + "/a", folder + "/b/f.####.exr"}, usage, "both");
    check_failure({"compare", folder + "/a", folder + "/b", "--map", folder + "/m.png"}, usage, "--map");
    check_failure({"compare", folder + "/a/g.#.exr", folder + "/b/g.#.exr"}, input, "no frames");
    std::filesystem::remove(folder + "/a/f.0009.exr");
    check_failure({"compare", folder + "/a", folder + "/b"}, input, "f.0009.exr");
}

TEST_CASE("channels of other names are compared, and any channel as visibility", "[cli]") {
    const std::string folder = temporary_folder(), test = folder + "/test.exr", truth = folder + "/truth.exr",
                      picture = folder + "/shadow.png";
    write_edge(truth, 20);
    ChannelImage foreign;
    foreign.add("shadow", Image<float>(width, height, 1.0f));
    write_exr(test, foreign);
    const json comparison = compared({test, truth, "--channels", "shadow=V", "--visibility"});
    CHECK(comparison["metrics"]["leak"] == 1.0);
    CHECK(comparison["confusion"]["pixels"][0][2] == 20 * height);
    check_failure({"compare", test, truth}, input, "no visibility and no colour in common");
    check_failure({"compare", test, truth, "--channels", "shadow=W"}, input, "no channel 'W'");
    write_png(picture, Image<gnomon::vec3>(width, height, gnomon::vec3(1.0f)));
    CHECK(compared({picture, truth, "--channels", "R=V", "--visibility"})["metrics"]["leak"] == 1.0);
}
