// gnomon truth as a run of hours sees it: stopped in every way, continued, split and put together.

#include <catch2/catch.hpp>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <random>
#include <utility>

#include "core/image_file.h"
#include "tests/bin/cli.h"

using namespace gnomon_tests;
namespace fs = std::filesystem;

namespace {

// A truth of a slanted edge, small where `more` does not say otherwise.
std::vector<std::string> truth(const std::string& output, const std::vector<std::string>& more = {},
                               const std::string& scene = "builtin:half-plane:slope=0.25") {
    std::vector<std::string> arguments = {"truth", scene, "--quiet", "-o", output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    for (const auto& [option, value] : {std::pair("--size", "160x120"), std::pair("--samples", "256")})
        if (std::find(more.begin(), more.end(), option) == more.end())
            arguments.insert(arguments.end(), {option, value});
    return arguments;
}

} // namespace

TEST_CASE("a truth that is killed ten times and resumed ends with the bytes of an undisturbed one", "[bin][truth]") {
    const std::string folder = temporary_folder(), whole = folder + "/whole.exr", killed = folder + "/killed.exr";
    const std::vector<std::string> arguments =
        truth(killed, {"--resume", "--save-every", "0", "--threads", "1", "--samples", "1024"}, "builtin:fence");
    const double duration = milliseconds_of(truth(whole, {"--threads", "1", "--samples", "1024"}, "builtin:fence"));
    const unsigned seed = std::random_device()();
    INFO("seed " << seed << ", undisturbed " << duration << " ms");
    std::mt19937 random(seed);
    int stopped = 0;
    for (int i = 0; i < 10; ++i) {
        const int signal = i % 3 == 0 ? SIGINT : i % 3 == 1 ? SIGTERM : SIGKILL;
        const double limit = 0.9 * duration; // a resumed run has less to do, so few of them reach the end
        const int code = run_and_stop(arguments, int(std::uniform_real_distribution<>(0, limit)(random)), signal);
        if (code == 0) {
            fs::remove(killed); // it was done before the signal: all over again
            continue;
        }
        ++stopped;
        if (fs::exists(killed)) { // stopped on its way out: what is there is whole
            CHECK(read_bytes(killed) == read_bytes(whole));
            fs::remove(killed);
        }
        // Before the work begins a signal ends the program as it ends any other.
        CHECK(code == 128 + signal);
    }
    CHECK(stopped > 0);
    check_success(arguments);
    CHECK(read_bytes(killed) == read_bytes(whole));
    CHECK_FALSE(fs::exists(killed + ".partial"));
}

TEST_CASE("an interrupted truth says how to go on", "[bin][truth]") {
    const std::string folder = temporary_folder(), output = folder + "/t.exr";
    const int code = run_and_stop(truth(output, {"--samples", "65536", "--threads", "1"}), 1500, SIGTERM);
    CHECK(code == 143);
    CHECK(fs::exists(output + ".partial"));
    check_failure(truth(output, {"--resume", "--seed", "2"}), 3, "its seed is 0, this run's is 2");
    check_failure(truth(output, {"--resume", "--pattern", "halton"}), 3, "pattern");
    check_failure(truth(output, {"--resume", "--target-error", "0.1"}), 3, "its target error is \"off\"");
    check_failure(truth(output, {"--resume", "--size", "80x60"}), 3,
                  "its size is \"160x120\", this run's is \"80x60\"");
    check_failure(truth(output, {"--resume", "--look-from", "1,2,3"}), 3, "its view is");
    write_bytes(output + ".partial", "something else");
    check_failure(truth(output, {"--resume"}), 3, "it is no state of a run");
}

TEST_CASE("samples can be added to a truth", "[bin][truth]") {
    for (const std::string pattern : {"sobol", "poisson", "grid"}) {
        const std::string folder = temporary_folder(), grown = folder + "/grown.exr", whole = folder + "/whole.exr";
        INFO(pattern);
        const std::vector<std::string> small = {"--pattern", pattern, "--size", "32x24"};
        const auto with = [&](std::vector<std::string> more) {
            more.insert(more.end(), small.begin(), small.end());
            return more;
        };
        check_success(truth(grown, with({"--samples", "256", "--keep-state"})));
        REQUIRE(fs::exists(grown + ".partial"));
        check_success(truth(grown, with({"--samples", "1024", "--resume", "--keep-state"})));
        check_success(truth(whole, with({"--samples", "1024"})));
        CHECK(read_bytes(grown) == read_bytes(whole));
        check_success(truth(grown, with({"--samples", "1500", "--resume", "--keep-state"})));
        check_success(truth(whole, with({"--samples", "1500"})));
        CHECK(read_bytes(grown) == read_bytes(whole));
        // Fewer samples than are there.
        check_success(truth(grown, with({"--samples", "300", "--resume"})));
        check_success(truth(whole, with({"--samples", "300"})));
        CHECK(read_bytes(grown) == read_bytes(whole));
        CHECK_FALSE(fs::exists(grown + ".partial"));
    }
}

TEST_CASE("radiance and a target error are the same after a resume", "[bin][truth]") {
    const std::string folder = temporary_folder(), grown = folder + "/grown.exr", whole = folder + "/whole.exr";
    const std::vector<std::string> settings = {"--radiance", "ggx",  "--target-error", "0.01",
                                               "--samples",  "4096", "--size",         "64x48"};
    check_success(truth(
        grown, {"--samples", "100", "--target-error", "0.5", "--keep-state", "--size", "64x48", "--radiance", "off"}));
    std::vector<std::string> resumed = settings;
    resumed.push_back("--resume");
    check_success(truth(grown, resumed));
    check_success(truth(whole, settings));
    CHECK(read_bytes(grown) == read_bytes(whole));
    const gnomon::ChannelImage image = gnomon::read_image(whole);
    REQUIRE(image.find("samples"));
    REQUIRE(image.find("error"));
    int stopped = 0, above = 0;
    for (size_t i = 0; i < image.find("samples")->values.size(); ++i) {
        const float taken = image.find("samples")->values.values()[i], error = image.find("error")->values.values()[i];
        stopped += taken > 0 && taken < 4096;
        above += taken < 4096 && error > 0.01f;
    }
    CHECK(stopped > 1000);
    CHECK(above == 0);
}

TEST_CASE("shares of an image merge into the bytes of the whole", "[bin][truth]") {
    const std::string folder = temporary_folder(), whole = folder + "/whole.exr", merged = folder + "/merged.exr";
    const auto share = [&](const std::string& part) { return folder + "/share" + part.substr(0, 1) + ".exr"; };
    check_success(truth(whole, {"--aov", "all"}));
    for (const std::string part : {"1/3", "2/3", "3/3"})
        check_success(truth(share(part), {"--tiles", part, "--aov", "all"}));
    check_success({"truth", "--merge", share("2"), share("3"), share("1"), "-o", merged});
    CHECK(read_bytes(merged) == read_bytes(whole));

    check_failure({"truth", "--merge", share("2"), share("3"), "-o", merged}, 3, "share 1 of 3 is missing");
    check_failure({"truth", "--merge", share("2"), share("2"), "-o", merged}, 3, "are the same share");
    check_failure({"truth", "--merge", whole, share("2"), "-o", merged}, 3, "is no share of an image");
    check_success(truth(share("3"), {"--tiles", "3/3", "--aov", "all", "--seed", "5"}));
    check_failure({"truth", "--merge", share("1"), share("2"), share("3"), "-o", merged}, 3, "not shares of one image");
    check_failure(truth(share("1"), {"--tiles", "4/3"}), 2, "--tiles");
    check_failure(truth(folder + "/x.png", {"--tiles", "1/3"}), 2, "is written as one .exr");
}
