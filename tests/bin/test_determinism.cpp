// The same command gives the same bytes: for any number of threads, and every time.

#include <catch2/catch.hpp>

#include "tests/bin/cli.h"

using namespace gnomon_tests;

namespace {

// Every file of a run of all techniques, statistics without times.
std::map<std::string, std::string> render_all(const std::string& light, const std::string& threads) {
    const std::string folder = temporary_folder(), out = folder + "/out";
    check_success({"render",    "builtin:default", "-t",    "all",   "-t",      "truth:samples=16", "--light",
                   light,       "--size",          "72x40", "--aov", "all",     "--debug-images",   "--quiet",
                   "--threads", threads,           "-o",    out,     "--stats", out + "/stats.json"});
    std::map<std::string, std::string> files = files_in(out);
    files["stats.json"] = without_times(files["stats.json"]);
    return files;
}

} // namespace

TEST_CASE("Files do not depend on the number of threads or the run", "[cli]") {
    struct Case {
        const char* light;
        std::vector<std::string> threads;
    };
    const Case cases[] = {{"rect:-3,5,2", {"2", "7", "2"}}, {"directional:-3,5,2", {"7"}}, {"spot:-3,5,2", {"7"}}};
    for (const auto& [light, thread_counts] : cases) {
        const auto expected = render_all(light, "1");
        REQUIRE(expected.size() > 10);
        for (const std::string& threads : thread_counts) {
            const auto files = render_all(light, threads);
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
