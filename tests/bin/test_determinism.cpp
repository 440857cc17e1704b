// The same command gives the same bytes: for any number of threads, and every time.

#include <catch2/catch.hpp>

#include <algorithm>

#include "techniques/technique.h"
#include "tests/bin/cli.h"

using namespace gnomon_tests;

namespace {

// Every technique that supports the light, with maps of 256 texels a side so that the runs stay short.
std::vector<std::string> all_techniques(gnomon::LightType light) {
    std::vector<std::string> arguments;
    for (const gnomon::Entry& entry : gnomon::techniques()) {
        if (!(entry.info.lights & gnomon::bit(light)) || entry.info.id == "truth") continue;
        const bool map = std::any_of(entry.parameters.begin(), entry.parameters.end(),
                                     [](const gnomon::ParameterInfo& parameter) { return parameter.name == "size"; });
        arguments.insert(arguments.end(), {"-t", entry.info.id + (map ? ":size=256" : "")});
    }
    return arguments;
}

// Every file of a run of them, statistics without times.
std::map<std::string, std::string> render_all(const std::string& light, gnomon::LightType type,
                                              const std::string& threads) {
    const std::string folder = temporary_folder(), out = folder + "/out";
    std::vector<std::string> arguments = {"render",
                                          "builtin:default",
                                          "-t",
                                          "truth:samples=16",
                                          "--light",
                                          light,
                                          "--size",
                                          "72x40",
                                          "--aov",
                                          "all",
                                          "--debug-images",
                                          "--quiet",
                                          "--threads",
                                          threads,
                                          "-o",
                                          out,
                                          "--stats",
                                          out + "/stats.json"};
    const std::vector<std::string> techniques = all_techniques(type);
    arguments.insert(arguments.end(), techniques.begin(), techniques.end());
    check_success(arguments);
    std::map<std::string, std::string> files = files_in(out);
    files["stats.json"] = without_times(files["stats.json"]);
    return files;
}

} // namespace

TEST_CASE("Files do not depend on the number of threads or the run", "[cli]") {
    struct Case {
        const char* light;
        gnomon::LightType type;
        std::vector<std::string> threads;
    };
    const Case cases[] = {{"rect:-3,5,2", gnomon::LightType::Rectangle, {"2", "7", "2"}},
                          {"directional:-3,5,2", gnomon::LightType::Directional, {"7"}},
                          {"spot:-3,5,2", gnomon::LightType::Spot, {"7"}}};
    for (const auto& [light, type, thread_counts] : cases) {
        const auto expected = render_all(light, type, "1");
        REQUIRE(expected.size() > 10);
        for (const std::string& threads : thread_counts) {
            const auto files = render_all(light, type, threads);
            REQUIRE(files.size() == expected.size());
            for (const auto& [name, bytes] : expected) {
                INFO(light << ", " << threads << " threads: " << name);
                REQUIRE(files.count(name) == 1);
                CHECK((files.at(name) == bytes));
            }
        }
    }
}

TEST_CASE("The exposure of a run is the same for all techniques", "[cli]") {
    const std::string folder = temporary_folder();
    const auto exposure = [&](const std::string& technique) {
        const std::string json = check_success({"render", "builtin:half-plane", "-t", technique, "--size", "32x24",
                                                "-o", folder + "/out.png", "--stats", "-"});
        const size_t at = json.find("\"exposure\"");
        return json.substr(at, json.find('\n', at) - at);
    };
    CHECK(exposure("raytraced") == exposure("truth:samples=4"));
}
