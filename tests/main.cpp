#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include "tests/support.h"

namespace {

// CMake lists tests as one list with semicolons, in which brackets group, and a name is an argument of the program. A
// name with any of these would swallow the tests after it without a word; so discovery itself fails on it.
bool names_are_listable() {
    for (const Catch::TestCase& test : Catch::getAllTestCasesSorted(*Catch::getCurrentContext().getConfig()))
        if (test.name.find_first_of("[];\\\"") != std::string::npos || test.name[0] == '-') {
            std::fprintf(stderr, "test case '%s' has a name that CTest cannot list\n", test.name.c_str());
            return false;
        }
    return true;
}

} // namespace

int main(int argc, char** argv) {
    Catch::Session session;
    const int failures = session.run(argc, argv);
    if (!names_are_listable()) return 3;
    return failures == 0 && gnomon_tests::skipped() ? 77 : failures;
}
