#include "bench/bench.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>
#include <unistd.h>

#include "core/parallel.h"

namespace gnomon_bench {
namespace {

constexpr double least_seconds = 1.0; // of the whole of a benchmark
constexpr size_t least_rounds = 5, most_rounds = 41;

} // namespace

double milliseconds(const std::function<void()>& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

bool Bench::wanted(const std::string& benchmark) const {
    return names_.empty() || std::any_of(names_.begin(), names_.end(), [&](const std::string& name) {
               return benchmark.find(name) != std::string::npos;
           });
}

bool Bench::asked_for(const std::string& benchmark, const std::string& word) const {
    return std::any_of(names_.begin(), names_.end(), [&](const std::string& name) {
        return name.find(word) != std::string::npos && benchmark.find(name) != std::string::npos;
    });
}

void Bench::run(const std::string& benchmark, const std::function<void()>& ours, const std::string& peer,
                const std::function<void()>& theirs) {
    std::vector<double> ours_ms, peer_ms;
    gnomon::with_threads(threads, [&] {
        for (int warm_up = 0; warm_up < 2; ++warm_up) ours(), theirs();
        double total = 0;
        while (ours_ms.size() < least_rounds || (total < 1e3 * least_seconds && ours_ms.size() < most_rounds)) {
            ours_ms.push_back(milliseconds(ours));
            peer_ms.push_back(milliseconds(theirs));
            total += ours_ms.back() + peer_ms.back();
        }
    });
    record({benchmark, peer, median(ours_ms), median(peer_ms)});
}

void Bench::record(const Result& r) {
    results_.push_back(r);
    fmt::print(
        "{{\"benchmark\": \"{}\", \"ours_ms\": {:.3f}, \"peer\": \"{}\", \"peer_ms\": {:.3f}, \"ratio\": {:.2f}}}\n",
        r.benchmark, r.ours_ms, r.peer, r.peer_ms, r.peer_ms / r.ours_ms);
    std::fflush(stdout);
}

void Bench::agree(const std::string& benchmark, double ours, double theirs, double tolerance) {
    require(std::abs(ours - theirs) <= tolerance * std::max(std::abs(ours), std::abs(theirs)), benchmark,
            fmt::format("the two have not drawn the same: ours {}, theirs {}", ours, theirs));
}

void Bench::require(bool holds, const std::string& benchmark, const std::string& what) {
    if (holds) return;
    agreed_ = false;
    fmt::print(stderr, "gnomon-bench: {}: {}\n", benchmark, what);
}

void Bench::print_table() const {
    if (!isatty(STDOUT_FILENO) || results_.empty()) return;
    fmt::print("\n{:<36} {:>10} {:>10} {:>7}  peer\n", "benchmark", "ours ms", "peer ms", "ratio");
    for (const Result& r : results_)
        fmt::print("{:<36} {:>10.2f} {:>10.2f} {:>7.2f}  {}\n", r.benchmark, r.ours_ms, r.peer_ms,
                   r.peer_ms / r.ours_ms, r.peer);
}

} // namespace gnomon_bench
