#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include "tests/support.h"

int main(int argc, char** argv) {
    const int failures = Catch::Session().run(argc, argv);
    return failures == 0 && gnomon_tests::skipped() ? 77 : failures;
}
