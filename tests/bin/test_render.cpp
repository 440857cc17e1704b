// From a scene to images, numbers, a report and back to a scene.

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "core/image_file.h"
#include "tests/bin/cli.h"

using namespace gnomon_tests;
using gnomon::ChannelImage;
using nlohmann::json;

namespace {

bool exists(const std::string& path) { return std::filesystem::exists(path); }

std::string text_attribute(const ChannelImage& image, const std::string& name) {
    const auto found = image.attributes.find(name);
    return found == image.attributes.end() ? "" : std::get<std::string>(found->second);
}

} // namespace

TEST_CASE("render, compare, report and export belong together", "[cli]") {
    const std::string folder = temporary_folder(), out = folder + "/run";
    const std::vector<std::string> scene = {"builtin:half-plane", "--size", "48x32"};
    check_success({"render", scene[0], scene[1], scene[2], "-t", "raytraced", "-t", "truth:samples=64", "-o", out,
                   "--report", out + "/report.html", "--reference", "truth:samples=64", "--stats",
                   out + "/stats.json"});
    for (const char* name : {"raytraced.exr", "raytraced.png", "truth.exr", "truth.png", "report.html", "stats.json"})
        CHECK(exists(out + "/" + name));
    CHECK(files_in(out).size() == 6);

    // The truth command is the technique.
    check_success({"truth", scene[0], scene[1], scene[2], "--samples", "64", "-o", folder + "/truth.exr"});
    CHECK((read_bytes(folder + "/truth.exr") == read_bytes(out + "/truth.exr")));

    const json same = json::parse(check_success({"compare", folder + "/truth.exr", out + "/truth.exr", "--json", "-"}));
    CHECK(same["pixels"] == 48 * 32);
    CHECK(same["metrics"]["max"] == 0);
    CHECK(same["metrics"]["ssim"] == 1);
    const std::string hard = out + "/raytraced.exr", truth = out + "/truth.exr";
    const json different = json::parse(check_success({"compare", hard, truth, "--json", "-"}));
    CHECK(different["metrics"]["rmse"] > 0.01);
    CHECK(different["masked"] > 0);

    // Bounds.
    check_success({"compare", hard, truth, "--fail-above", "rmse=0.9", "--fail-below", "ssim=0.01"});
    const ProgramRun crossed = run_gnomon({"compare", hard, truth, "--fail-above", "rmse=0.001"});
    CHECK(crossed.exit_code == 1);
    CHECK(std::count(crossed.errors.begin(), crossed.errors.end(), '\n') == 1);
    CHECK(crossed.errors.find("rmse is") != std::string::npos);

    // Only what was asked for.
    const json few = json::parse(check_success({"compare", hard, truth, "--metrics", "mae,max", "--json", "-"}));
    CHECK(few["metrics"].size() == 2);
    check_success({"compare", hard, truth, "--map", folder + "/map.png", "--map-kind", "magnitude"});
    CHECK(gnomon::read_image(folder + "/map.png").width >= 48);

    // An exported scene renders to the same pixels.
    check_success({"export", "builtin:half-plane", "-o", folder + "/scene.glb"});
    check_success(
        {"render", folder + "/scene.glb", scene[1], scene[2], "-t", "raytraced", "-o", folder + "/again.exr"});
    check_success({"compare", folder + "/again.exr", hard, "--fail-above", "max=0"});
}

TEST_CASE("The EXR has the documented channels and attributes", "[cli]") {
    const std::string folder = temporary_folder(), path = folder + "/out.exr";
    check_success({"render", "builtin:half-plane", "-t", "truth:samples=9,pattern=grid", "--size", "16x12", "--aov",
                   "all", "-o", path});
    const ChannelImage image = gnomon::read_image(path);
    for (const char* name : {"R", "G", "B", "V", "M", "Z", "P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "Ns.X", "Ns.Y",
                             "Ns.Z", "albedo.R", "albedo.G", "albedo.B", "id"})
        CHECK(image.find(name));
    CHECK(text_attribute(image, "gnomon:scene") == "builtin:half-plane");
    CHECK(text_attribute(image, "gnomon:technique") == "truth");
    CHECK(json::parse(text_attribute(image, "gnomon:parameters")) == json({{"samples", 9},
                                                                           {"pattern", "grid"},
                                                                           {"seed", 0},
                                                                           {"target-error", 0.0},
                                                                           {"radiance", "off"},
                                                                           {"method", "samples"},
                                                                           {"shortcuts", "on"}}));
    CHECK_FALSE(text_attribute(image, "gnomon:version").empty());
    CHECK(image.attributes.count("worldToCamera") == 1);
    CHECK(image.attributes.count("worldToNDC") == 1);
    CHECK(std::get<int>(image.attributes.at("samplesPerPixel")) == 9);
}

TEST_CASE("The EXR of the exact method names no samples", "[cli][truth]") {
    const std::string folder = temporary_folder(), path = folder + "/out.exr";
    check_success({"truth", "builtin:half-plane", "--method", "exact", "--size", "16x12", "-o", path});
    const ChannelImage image = gnomon::read_image(path);
    const json parameters = json::parse(text_attribute(image, "gnomon:parameters"));
    CHECK(parameters.at("method") == "exact");
    for (const char* name : {"samples", "pattern", "seed"}) CHECK_FALSE(parameters.contains(name));
    CHECK(std::get<int>(image.attributes.at("samplesPerPixel")) == 1);
}

TEST_CASE("Statistics have the documented keys", "[cli]") {
    const std::string folder = temporary_folder();
    const json stats = json::parse(check_success({"render", "builtin:half-plane", "-t", "raytraced", "--size", "8x8",
                                                  "-o", folder + "/out.exr", "--stats", "-"}));
    for (const char* key : {"version", "scene", "image", "gbuffer", "techniques", "steps", "peak_resident_bytes"})
        CHECK(stats.contains(key));
    REQUIRE(stats["techniques"].size() == 1);
    for (const char* key : {"id", "parameters", "light", "seconds", "peak_bytes", "passes"})
        CHECK(stats["techniques"][0].contains(key));
    for (const char* key :
         {"name", "draws", "vertices", "triangles", "clipped", "culled", "fragments_covered", "fragments_passed",
          "fragments_shaded", "texels_fetched", "bytes_read", "bytes_written", "rays", "seconds"})
        CHECK(stats["techniques"][0]["passes"][0].contains(key));
    CHECK(stats["techniques"][0]["passes"][0]["rays"] > 0);
    CHECK(stats["image"]["width"] == 8);
}

TEST_CASE("A model without light and camera renders", "[cli]") {
    const std::string folder = temporary_folder(), model = folder + "/model.glb", out = folder + "/out.exr";
    write_bytes(model, make_glb({0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2}, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}));
    check_success({"render", model, "-t", "raytraced", "--size", "24x24", "-o", out});
    const ChannelImage image = gnomon::read_image(out);
    const auto masked = image.find("M")->values.values();
    CHECK(std::count(masked.begin(), masked.end(), 1.0f) > 20);
}

TEST_CASE("Lights and cameras can be made on the command line", "[cli]") {
    const std::string folder = temporary_folder(), out = folder + "/out.exr";
    for (const char* light : {"point:0,4,0", "spot:0,4,0", "directional:1,4,0", "rect:0,4,0", "rectangle:0,4,0",
                              "disk:0,4,0", "sphere:0,4,0"}) {
        check_success({"render", "builtin:default", "-t", "truth:samples=4", "--size", "24x16", "--light", light,
                       "--light-aim", "0,0,0", "--look-from", "-3,4,5", "--look-at", "0,0,0", "--fov", "50", "-o",
                       out});
        double sum = 0;
        const ChannelImage image = gnomon::read_image(out);
        for (const float value : image.find("R")->values.values()) {
            REQUIRE(std::isfinite(value));
            sum += static_cast<double>(value);
        }
        INFO(light);
        CHECK(sum > 1);
    }
}

TEST_CASE("Names of outputs for several techniques", "[cli]") {
    const std::string folder = temporary_folder();
    check_success({"render", "builtin:half-plane", "-t", "truth:samples=4", "-t", "truth:samples=9", "-t", "raytraced",
                   "--size", "8x8", "-o", folder + "/a-{id}.exr"});
    CHECK(exists(folder + "/a-truth.exr"));
    CHECK(exists(folder + "/a-truth-2.exr"));
    CHECK(exists(folder + "/a-raytraced.exr"));
    CHECK(files_in(folder).size() == 3);
}

TEST_CASE("the option --primary ray sees what the rasterizer sees", "[cli]") {
    const std::string folder = temporary_folder();
    for (const char* primary : {"raster", "ray"})
        check_success({"render", "builtin:default", "-t", "raytraced", "--size", "96x54", "--aov", "id", "--primary",
                       primary, "-o", folder + "/" + primary + ".exr"});
    const ChannelImage raster = gnomon::read_image(folder + "/raster.exr"),
                       ray = gnomon::read_image(folder + "/ray.exr");
    size_t different = 0;
    for (size_t i = 0; i < raster.find("id")->values.size(); ++i)
        different += raster.find("id")->values.values()[i] != ray.find("id")->values.values()[i];
    CHECK(different < 96 * 54 / 50); // pixels whose centre lies within 1/256 of an edge
}

TEST_CASE("Several lights have channels and statistics of their own", "[cli]") {
    const std::string folder = temporary_folder(), scene = folder + "/two.json", out = folder + "/out.exr";
    write_bytes(scene, R"({"objects": [{"shape": "box", "size": [1, 1, 1]}, {"shape": "plane", "size": [8, 8]}],
        "lights": [{"name": "a", "type": "point", "position": [2, 4, 2]},
                   {"name": "b", "type": "disk", "position": [-2, 4, 2], "target": [0, 0, 0], "diameter": 1}]})");
    const json stats =
        json::parse(check_success({"render", scene, "-t", "raytraced", "--size", "24x16", "-o", out, "--stats", "-"}));
    REQUIRE(stats["techniques"].size() == 2);
    CHECK(stats["techniques"][1]["light"] == "b");
    const ChannelImage image = gnomon::read_image(out);
    for (const char* name : {"a.V", "a.M", "b.V", "b.M"}) CHECK(image.find(name));
    CHECK_FALSE(image.find("V"));
    check_success({"render", scene, "-t", "raytraced", "--size", "24x16", "--light", "b", "-o", out});
    CHECK(gnomon::read_image(out).find("V"));
}
