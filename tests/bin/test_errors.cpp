// Whatever is wrong with what the user gave: one line that says so, the right exit code, and no file left behind.

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

#include "core/image_file.h"
#include "tests/bin/cli.h"

using namespace gnomon_tests;

namespace {

constexpr int usage = 2, input = 3;

struct Case {
    std::vector<std::string> arguments;
    int exit_code;
    std::string words;
};

// A render of the smallest scene to `output`, with more arguments.
std::vector<std::string> render(const std::string& output, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"render", "builtin:half-plane", "-t", "raytraced", "--size", "8x8", "-o",
                                          output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

void check_all(const std::string& folder, const std::vector<Case>& cases) {
    const auto before = files_in(folder);
    for (const Case& row : cases) check_failure(row.arguments, row.exit_code, row.words);
    CHECK(files_in(folder) == before);
}

} // namespace

TEST_CASE("Wrong usage is one line and exit code 2", "[cli]") {
    const std::string folder = temporary_folder(), out = folder + "/out.exr";
    const auto with = [&](const std::vector<std::string>& more) { return render(out, more); };
    check_all(folder,
              {
                  {{}, usage, "a command is missing"},
                  {{"rendr"}, usage, "did you mean 'render'?"},
                  {{"--sise"}, usage, "there is no option '--sise'"},
                  {{"render", "-t", "raytraced"}, usage, "--output"},
                  {{"render", "-o", out}, usage, "--technique"},
                  {with({"--sise", "8x8"}), usage, "did you mean '--size'?"},
                  {with({"surplus"}), usage, "surplus"},
                  {with({"--threads"}), usage, "--threads"},
                  {with({"--threads", "-1"}), usage, "between 0 and 1024"},
                  {with({"--threads", "two"}), usage, "a whole number"},
                  {with({"--aov", "Z,Q"}), usage, "one of all, Z, P"},
                  {with({"--primary", "rays"}), usage, "did you mean 'ray'?"},
                  {with({"--exposure", "bright"}), usage, "a number"},
                  {with({"--exposure", "nan"}), usage, "a number"},
                  {with({"--ambient", "-1"}), usage, "--ambient"},
                  {with({"--ambient", "1,2"}), usage, "three numbers"},
                  {with({"--progress", "maybe"}), usage, "auto, on, off"},
                  {with({"--reference", "truth"}), usage, "goes with --report"},
                  {with({"--report", folder + "/report.pdf"}), usage, ".html"},
                  {{"list", "technique"}, usage, "did you mean 'techniques'?"},
                  {{"help", "raytracde"}, usage, "did you mean 'raytraced'?"},
                  {{"render", "builtin:defualt", "-t", "raytraced", "-o", out}, usage, "did you mean 'default'?"},
                  {{"render", "builtin:half-plane:slop=1", "-t", "raytraced", "-o", out}, usage, "slop"},
              });
}

TEST_CASE("A size that is no size is refused", "[cli]") {
    const std::string folder = temporary_folder();
    for (const char* size :
         {"0x0", "8x0", "-8x8", "8", "8x8x8", "8X8", "8x8 ", "1e2x8", "40000x8", "99999999999x8", "x", ""})
        check_failure({"render", "-t", "raytraced", "-o", folder + "/out.exr", "--size", size}, usage, "--size");
    CHECK(files_in(folder).empty());
}

TEST_CASE("Techniques and parameters that do not exist are named", "[cli]") {
    const std::string folder = temporary_folder(), out = folder + "/out.exr";
    const auto technique = [&](const std::string& text) {
        return std::vector<std::string>{"render", "-t", text, "-o", out, "--size", "8x8"};
    };
    check_all(folder, {
                          {technique("raytrace"), usage, "did you mean 'raytraced'?"},
                          {technique(""), usage, "there is no technique ''"},
                          {technique("truth:sample=4"), usage, "did you mean 'samples'?"},
                          {technique("truth:samples=0"), usage, "between 1 and 65536"},
                          {technique("truth:samples=1e99"), usage, "samples"},
                          {technique("truth:samples=nan"), usage, "must be a number"},
                          {technique("truth:samples=4.5"), usage, "whole number"},
                          {technique("truth:samples=4,samples=5"), usage, "twice"},
                          {technique("truth:samples"), usage, "key=value"},
                          {technique("truth:pattern=soboll"), usage, "did you mean 'sobol'?"},
                          {technique("raytraced:size=4"), usage, "no parameter 'size'"},
                          {{"truth", "--samples", "0", "-o", out}, usage, "between 1 and 65536"},
                          {{"truth", "--pattern", "hammersley", "-o", out}, usage, "must be one of"},
                      });
}

TEST_CASE("Cameras and lights that make no sense are refused", "[cli]") {
    const std::string folder = temporary_folder(), out = folder + "/out.exr";
    const auto with = [&](const std::vector<std::string>& more) { return render(out, more); };
    check_all(folder, {
                          {with({"--look-from", "1,2,3", "--look-at", "1,2,3"}), usage, "same point"},
                          {with({"--look-from", "1,2"}), usage, "three numbers"},
                          {with({"--look-from", "1,2,nan"}), usage, "three numbers"},
                          {with({"--look-from", "1,2,3x"}), usage, "three numbers"},
                          {with({"--look-from", "1e99,2,3"}), usage, "three numbers"},
                          {with({"--fov", "0"}), usage, "--fov"},
                          {with({"--fov", "180"}), usage, "--fov"},
                          {with({"--fov", "-10"}), usage, "--fov"},
                          {with({"--fov", "inf"}), usage, "--fov"},
                          {with({"--camera", "nobody"}), usage, "no camera 'nobody'"},
                          {with({"--camera", "x", "--look-at", "0,0,0"}), usage, "one or the other"},
                          {with({"--light", "nobody"}), usage, "no light 'nobody'"},
                          {with({"--light", "rct:0,4,0"}), usage, "did you mean 'rect'?"},
                          {with({"--light", "rect:0,4"}), usage, "three numbers"},
                          {with({"--light", "rect:0,4,0", "--light-size", "0x1"}), usage, "above 0"},
                          {with({"--light", "rect:0,4,0", "--light-size", "-1"}), usage, "above 0"},
                          {with({"--light", "disk:0,4,0", "--light-size", "1x2"}), usage, "diameter"},
                          {with({"--light", "point:0,4,0", "--light-size", "1"}), usage, "no size"},
                          {with({"--light", "spot:0,4,0", "--light-aim", "0,4,0"}), usage, "points nowhere"},
                          {with({"--light", "point:0,4,0", "--light-intensity", "-1"}), usage, "--light-intensity"},
                          {with({"--light-size", "1"}), usage, "goes with a light made"},
                      });
}

TEST_CASE("Files that are no scenes are named with what is wrong", "[cli]") {
    const std::string folder = temporary_folder(), out = folder + "/out.exr";
    const std::vector<float> triangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::string good = make_glb(triangle, {0, 1, 2});
    write_bytes(folder + "/truncated.glb", good.substr(0, good.size() - 20));
    write_bytes(folder + "/text.glb", "this is a text, not a model\n");
    write_bytes(folder + "/empty.glb", "");
    write_bytes(folder + "/index.glb", make_glb(triangle, {0, 1, 7}));
    write_bytes(folder + "/nan.glb", make_glb({0, 0, 0, 1, NAN, 0, 0, 1, 0}, {0, 1, 2}));
    write_bytes(folder + "/degenerate.glb", make_glb({0, 0, 0, 1, 0, 0, 2, 0, 0}, {0, 1, 2}));
    write_bytes(folder + "/nothing.gltf", R"({"asset": {"version": "2.0"}})");
    write_bytes(folder + "/broken.gltf", R"({"asset": {"version": )");
    write_bytes(folder + "/broken.json", "{");
    write_bytes(folder + "/model.obj", "v 0 0 0\n");
    std::filesystem::create_directory(folder + "/folder.glb");
    std::vector<Case> cases;
    for (const char* name : {"missing.glb", "truncated.glb", "text.glb", "empty.glb", "index.glb", "nan.glb",
                             "degenerate.glb", "nothing.gltf", "broken.gltf", "broken.json", "model.obj", "folder.glb"})
        cases.push_back(
            {{"render", folder + "/" + name, "-t", "raytraced", "-o", out, "--size", "8x8", "--quiet"}, input, name});
    check_all(folder, cases);
}

TEST_CASE("Places that take no file are found before anything is rendered", "[cli]") {
    const std::string folder = temporary_folder();
    write_bytes(folder + "/file", "in the way");
    std::filesystem::create_directory(folder + "/folder.exr");
    std::filesystem::create_directory(folder + "/folder.json");
    const std::string good = folder + "/out.exr";
    check_all(folder,
              {
                  {render(folder + "/missing/out.exr", {}), input, "there is no folder"},
                  {render(folder + "/file/out.exr", {}), input, "there is no folder"},
                  {render(folder + "/file/out/", {}), input, "is no folder"},
                  {render("/proc/out.exr", {}), input, "/proc"},
                  {render("/proc/out/", {}), input, "/proc"},
                  {render(folder + "/out.jpg", {}), usage, ".exr or .png"},
                  {render("", {}), usage, "--output is empty"},
                  {render(good, {"-t", "truth"}), usage, "{id}"},
                  {render(good, {"--stats", folder + "/missing/stats.json"}), input, "there is no folder"},
                  {render(good, {"--stats", folder + "/folder.json"}), input, "it is a folder"},
                  {render(good, {"--report", folder + "/missing/report.html"}), input, "there is no folder"},
                  {{"export", "builtin:half-plane", "-o", folder + "/missing/scene.glb"}, input, "there is no folder"},
                  {{"export", "builtin:half-plane", "-o", folder + "/scene.obj"}, usage, ".glb"},
              });
}

TEST_CASE("Images that cannot be compared are refused", "[cli]") {
    const std::string folder = temporary_folder();
    const std::string a = folder + "/a.exr", b = folder + "/b.exr";
    check_success(render(a, {}));
    check_success({"render", "builtin:half-plane", "-t", "raytraced", "--size", "8x9", "-o", b});
    write_bytes(folder + "/text.png", "this is a text\n");
    check_all(
        folder,
        {
            {{"compare", a, b}, input, "8x8"},
            {{"compare", a, folder + "/missing.exr"}, input, "missing.exr"},
            {{"compare", folder + "/text.png", a}, input, "text.png"},
            {{"compare", a, a, "--metrics", "rsme"}, usage, "did you mean 'rmse'?"},
            {{"compare", a, a, "--fail-above", "rsme=1"}, usage, "did you mean 'rmse'?"},
            {{"compare", a, a, "--fail-above", "rmse"}, usage, "METRIC=NUMBER"},
            {{"compare", a, a, "--fail-above", "rmse=much"}, usage, "a number"},
            {{"compare", a, a, "--channels", "Q"}, input, "no channel 'Q'"},
            {{"compare", a, a, "--map", folder + "/map.jpg"}, usage, ".png"},
            {{"compare", a, a, "--map", folder + "/map.png", "--map-kind", "sined"}, usage, "did you mean 'signed'?"},
            {{"compare", a, a, "--json", folder + "/missing/c.json"}, input, "there is no folder"},
            {{"compare", a}, usage, "reference"},
        });
}

TEST_CASE("the exact method refuses what it does not have", "[cli][truth]") {
    const std::string folder = temporary_folder(), out = folder + "/out.exr";
    for (const std::vector<std::string>& more : {std::vector<std::string>{"--resume"},
                                                 {"--keep-state"},
                                                 {"--tiles", "1/2"},
                                                 {"--samples", "64"},
                                                 {"--pattern", "grid"},
                                                 {"--seed", "1"},
                                                 {"--target-error", "0.1"},
                                                 {"--radiance", "lambert"}}) {
        std::vector<std::string> arguments = {"truth",    "builtin:fence", "--size", "16x9",
                                              "--method", "exact",         "-o",     out};
        arguments.insert(arguments.end(), more.begin(), more.end());
        check_failure(arguments, usage, "method exact");
    }
    CHECK(files_in(folder).empty());
}
