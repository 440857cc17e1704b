#include "core/progress.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <unistd.h>

#include <fmt/format.h>

namespace gnomon {
namespace {

constexpr std::int64_t milliseconds_between_draws = 100;

std::string duration_text(double seconds) {
    const auto whole = static_cast<std::int64_t>(seconds + 0.5);
    if (whole >= 3600) return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
    return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

} // namespace

bool standard_error_is_terminal() { return isatty(STDERR_FILENO) == 1; }

Progress::Progress(std::string label, std::int64_t total, bool enabled)
    : label_(std::move(label)), total_(std::max<std::int64_t>(total, 1)),
      enabled_(enabled && standard_error_is_terminal()), start_(std::chrono::steady_clock::now()) {
    if (enabled_) draw(0);
}

Progress::~Progress() {
    if (!enabled_) return;
    draw(done_);
    std::fputc('\n', stderr);
}

void Progress::advance(std::int64_t steps) {
    const std::int64_t done = done_.fetch_add(steps) + steps;
    if (!enabled_) return;
    const auto elapsed = std::chrono::steady_clock::now() - start_;
    const std::int64_t now = std::chrono::duration_cast<std::chrono::milliseconds>(elapsed).count();
    // Whoever moves the next draw's time forward draws; everybody else goes on working.
    std::int64_t due = next_draw_milliseconds_;
    if (now < due || !next_draw_milliseconds_.compare_exchange_strong(due, now + milliseconds_between_draws)) return;
    draw(done);
}

void Progress::skip(std::int64_t steps) {
    skipped_ += steps;
    advance(steps);
}

void Progress::draw(std::int64_t done) {
    const std::lock_guard lock(drawing_);
    const double fraction = std::clamp(static_cast<double>(done) / static_cast<double>(total_), 0.0, 1.0);
    const double elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    std::string line = fmt::format("\r{} {:3.0f} %", label_, 100.0 * fraction);
    if (fraction >= 1.0)
        line += fmt::format(", {}", duration_text(elapsed));
    else if (const std::int64_t worked = done - skipped_; worked > 0)
        line += fmt::format(", {} left",
                            duration_text(elapsed * static_cast<double>(total_ - done) / static_cast<double>(worked)));
    line += "\x1b[K"; // clears what a longer line left behind
    std::fwrite(line.data(), 1, line.size(), stderr);
    std::fflush(stderr);
}

} // namespace gnomon
