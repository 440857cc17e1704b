// gnomon-bench GROUP [NAME...]: see bin/bench.

#include <cstdio>
#include <cstring>
#include <exception>

#include <fmt/format.h>

#include "bench/bench.h"

namespace {

struct Group {
    const char* name;
    void (*run)(gnomon_bench::Bench&);
};
constexpr Group groups[] = {{"raster", gnomon_bench::bench_raster},
                            {"truth", gnomon_bench::bench_truth},
                            {"passes", gnomon_bench::bench_passes}};

} // namespace

int main(int argc, char** argv) try {
    const char* chosen = argc > 1 ? argv[1] : "all";
    gnomon_bench::Bench bench(std::vector<std::string>(argv + std::min(argc, 2), argv + argc));
    bool found = false;
    for (const Group& group : groups) {
        if (std::strcmp(chosen, "all") != 0 && std::strcmp(chosen, group.name) != 0) continue;
        found = true;
        group.run(bench);
    }
    if (!found) {
        fmt::print(stderr, "gnomon-bench: there are no benchmarks of '{}' yet; there are:", chosen);
        for (const Group& group : groups) fmt::print(stderr, " {}", group.name);
        fmt::print(stderr, "\n");
        return 2;
    }
    bench.print_table();
    return bench.agreed() ? 0 : 1;
} catch (const std::exception& error) {
    fmt::print(stderr, "gnomon-bench: {}\n", error.what());
    return 1;
}
