#pragma once
// One benchmark: our time and a peer's for the same work, taken in turns (A B A B …) so that what disturbs the machine
// disturbs both, and their medians.

#include <functional>
#include <string>
#include <vector>

namespace gnomon_bench {

inline constexpr int threads = 2; // ours and the peers'

struct Result {
    std::string benchmark, peer;
    double ours_ms, peer_ms;
};

class Bench {
public:
    // Runs only benchmarks whose name contains one of `names`, all where there are none.
    explicit Bench(std::vector<std::string> names) : names_(std::move(names)) {}

    bool wanted(const std::string& benchmark) const;
    // Whether a name with `word` in it chooses the benchmark: for what takes minutes and runs for nothing less.
    bool asked_for(const std::string& benchmark, const std::string& word) const;
    // Each call does the whole work and returns when it is done. Prints one JSON line.
    void run(const std::string& benchmark, const std::function<void()>& ours, const std::string& peer,
             const std::function<void()>& theirs);
    // What has been timed elsewhere.
    void record(const Result& result);
    // What the two have drawn must agree, or the times compare nothing; the difference is relative.
    void agree(const std::string& benchmark, double ours, double theirs, double tolerance);
    // The benchmark has failed where this does not hold.
    void require(bool holds, const std::string& benchmark, const std::string& what);

    double last_ms() const { return results_.back().ours_ms; } // of the benchmark run last

    void print_table() const; // on a terminal
    bool agreed() const { return agreed_; }

private:
    std::vector<std::string> names_;
    std::vector<Result> results_;
    bool agreed_ = true;
};

double milliseconds(const std::function<void()>& work);
double median(std::vector<double> values);

void bench_raster(Bench& bench);
void bench_truth(Bench& bench);
void bench_cycles(Bench& bench); // a part of it
void bench_passes(Bench& bench);
void bench_eval(Bench& bench);

} // namespace gnomon_bench
