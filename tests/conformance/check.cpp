#include "tests/conformance/check.h"

#include <cstdio>

#include <fmt/format.h>

namespace gnomon_conformance {

void Verdict::figure(const std::string& text) { fmt::print("       {}: {}\n", check_, text); }

void Verdict::require(bool holds, const std::string& text) {
    fmt::print("{} {}: {}\n", holds ? "      " : "  FAIL", check_, text);
    std::fflush(stdout);
    held_ &= holds;
}

void Verdict::skip(const std::string& text) { fmt::print("  SKIP {}: {}\n", check_, text); }

} // namespace gnomon_conformance
