#pragma once
// A progress bar for long runs: drawn on standard error, only where that is a terminal, at most ten times a second.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace gnomon {

class Progress {
public:
    // `total` steps of work under a label; a disabled bar counts but draws nothing.
    Progress(std::string label, std::int64_t total, bool enabled);
    ~Progress(); // ends the line
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void advance(std::int64_t steps = 1); // from any thread
    // Steps that cost nothing, because an earlier run did them: they count as done, not for how long the rest takes.
    void skip(std::int64_t steps);

private:
    void draw(std::int64_t done);

    std::string label_;
    std::int64_t total_;
    bool enabled_;
    std::atomic<std::int64_t> done_{0}, skipped_{0};
    std::chrono::steady_clock::time_point start_;
    std::atomic<std::int64_t> next_draw_milliseconds_{0};
    std::mutex drawing_;
};

// Whether standard error is a terminal.
bool standard_error_is_terminal();

} // namespace gnomon
