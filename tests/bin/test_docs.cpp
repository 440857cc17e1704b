// What `gnomon help` and the pages of techniques tell is complete, and the pages in docs/ are of today.

#include <catch2/catch.hpp>

#include <filesystem>

#include "core/atomic_file.h"
#include "core/image_file.h"
#include "techniques/technique.h"
#include "tests/bin/cli.h"

using namespace gnomon_tests;
using gnomon::Entry;
using gnomon::ParameterInfo;

namespace {

const std::string committed = GNOMON_SOURCE "/docs/techniques";

} // namespace

TEST_CASE("help tells paper, section, equations, strengths and artifacts of every technique", "[cli]") {
    for (const Entry& entry : gnomon::techniques()) {
        INFO(entry.info.id);
        const std::string text = check_success({"help", entry.info.id});
        const std::pair<const char*, std::string> told[] = {{"paper", entry.info.paper},
                                                            {"section", entry.info.section},
                                                            {"equations", entry.info.equations},
                                                            {"strengths", entry.info.strengths},
                                                            {"artifacts", entry.info.artifacts}};
        for (const ParameterInfo& info : entry.parameters)
            CHECK(text.find("[" + info.source + "]") != std::string::npos);
        for (const auto& [name, value] : told) {
            INFO(name);
            CHECK(value.size() >= 5);
            CHECK(text.find("  " + std::string(name) + std::string(11 - std::string(name).size(), ' ') + value) !=
                  std::string::npos);
        }
    }
}

TEST_CASE("every parameter of a technique says what it does, what it may be and where it comes from", "[cli]") {
    for (const Entry& entry : gnomon::techniques())
        for (const ParameterInfo& info : entry.parameters) {
            INFO(entry.info.id << ":" << info.name);
            CHECK(info.help.size() >= 5);
            CHECK_FALSE(info.source.empty());
            const bool number = info.type == gnomon::ParameterType::Integer || info.type == gnomon::ParameterType::Real;
            if (number) CHECK(info.minimum < info.maximum);
            if (info.type == gnomon::ParameterType::Choice) CHECK(info.choices.size() >= 2);
        }
}

TEST_CASE("a source that names a section of a thesis names one that it has", "[cli]") {
    // Its chapters, and how many sections each has.
    const std::map<std::string, std::vector<int>> sections = {{"Macedo 2018, ", {4, 8, 4, 4, 6, 3, 2}},
                                                              {"Forest 2008, ", {4, 4, 5, 7, 5, 4}},
                                                              {"Navratil 2015, ", {1, 3, 3, 2, 4}},
                                                              {"Hasselgren 2003, ", {1, 5, 4}}};
    const auto check = [&](const std::string& text) {
        INFO(text);
        for (const auto& [thesis, chapters] : sections)
            for (size_t at = 0; (at = text.find(thesis, at)) != std::string::npos;) {
                at += thesis.size();
                size_t read = 0;
                if (!std::isdigit(static_cast<unsigned char>(text[at]))) continue; // an equation, figure or listing
                const int chapter = std::stoi(text.substr(at), &read);
                CHECK(chapter >= 1);
                REQUIRE(static_cast<size_t>(chapter) <= chapters.size());
                if (at + read < text.size() && text[at + read] == '.')
                    CHECK(std::stoi(text.substr(at + read + 1)) <= chapters[static_cast<size_t>(chapter - 1)]);
            }
    };
    for (const Entry& entry : gnomon::techniques()) {
        for (const std::string& text : {entry.info.paper, entry.info.section, entry.info.equations}) check(text);
        for (const ParameterInfo& info : entry.parameters) check(info.source);
    }
}

TEST_CASE("the pages of techniques in docs are those that the program writes, each with its picture", "[cli]") {
    const std::string folder = temporary_folder() + "/pages";
    check_success({"docs", "-o", folder, "--no-pictures"});
    const std::map<std::string, std::string> made = files_in(folder);
    CHECK(made.size() == gnomon::techniques().size() + 1);
    for (const auto& [name, text] : made) {
        INFO(name << ": `gnomon docs -o docs/techniques` writes it anew");
        CHECK(std::filesystem::exists(committed + "/" + name));
        if (std::filesystem::exists(committed + "/" + name)) CHECK(read_bytes(committed + "/" + name) == text);
    }
    size_t bytes = 0;
    for (const Entry& entry : gnomon::techniques()) {
        INFO(entry.info.id);
        const std::string path = committed + "/" + entry.info.id + ".png";
        REQUIRE(std::filesystem::exists(path));
        CHECK(made.at(entry.info.id + ".md").find("(" + entry.info.id + ".png)") != std::string::npos);
        const gnomon::ChannelImage picture = gnomon::read_image(path);
        CHECK(picture.width == 600);
        CHECK(picture.height == 225);
        CHECK(std::filesystem::file_size(path) < 60 * 1024);
        bytes += std::filesystem::file_size(path);
    }
    CHECK(bytes < size_t{5} << 20);
    for (const auto& file : std::filesystem::directory_iterator(committed)) { // and none of what is gone
        INFO(file.path().string());
        const std::string id = file.path().stem().string();
        CHECK((id == "README" || made.count(id + ".md") == 1));
    }
}

TEST_CASE("pictures of techniques are the same bytes for any number of threads", "[cli]") {
    const std::string folder = temporary_folder();
    check_success({"docs", "-o", folder + "/one", "-t", "sv-zfail", "--threads", "1"});
    check_success({"docs", "-o", folder + "/three", "-t", "sv-zfail", "--threads", "3"});
    const auto one = files_in(folder + "/one");
    CHECK(one.size() == 3);
    CHECK(one == files_in(folder + "/three"));
    check_failure({"docs", "-o", folder + "/x", "-t", "sv-zfial"}, 2, "did you mean 'sv-zfail'");
    check_failure({"docs", "-o", "/proc/nowhere/x"}, 3, "/proc/nowhere/x");
}
