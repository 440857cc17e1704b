#pragma once
// What a GPU would pay, counted exactly: repeatable integers, the same for any number of threads and any vector width.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

namespace gnomon {

struct PassCounters {
    std::string name;
    std::int64_t draws = 0;
    std::int64_t vertices = 0;          // vertex program invocations
    std::int64_t triangles = 0;         // submitted
    std::int64_t clipped = 0;           // triangles that met a clip plane and were cut
    std::int64_t culled = 0;            // triangles dropped: facing, zero area, outside, or between sample positions
    std::int64_t fragments_covered = 0; // inside the triangle and the scissor
    std::int64_t fragments_passed = 0;  // passed depth, stencil and discard
    std::int64_t fragments_shaded = 0;  // fragment program invocations, helpers left out
    std::int64_t texels_fetched = 0;    // texels read by programs: 4 for a bilinear tap
    std::int64_t bytes_read = 0;        // of targets: depth and stencil tests, blending, texels
    std::int64_t bytes_written = 0;     // of targets, clears included
    std::int64_t rays = 0;              // traced
    double seconds = 0;

    void add(const PassCounters& other); // all but name
};

// Memory of render targets, as it is now and at its peak.
class MemoryMeter {
public:
    void allocate(std::int64_t bytes) {
        const std::int64_t now = now_ += bytes;
        std::int64_t peak = peak_.load();
        while (now > peak && !peak_.compare_exchange_weak(peak, now)) {
        }
    }
    void release(std::int64_t bytes) { now_ -= bytes; }
    std::int64_t peak() const { return peak_; }

private:
    std::atomic<std::int64_t> now_{0}, peak_{0};
};

namespace detail {
struct DrawScratch;
}

// The passes of one technique on one light, in the order they were begun.
struct PassLog {
    std::deque<PassCounters> passes;
    std::shared_ptr<MemoryMeter> memory = std::make_shared<MemoryMeter>();
    std::shared_ptr<detail::DrawScratch> scratch; // memory that draws leave to the next, made by the first of them
};

// One named pass, open for as long as the object lives: draws and full-screen programs add to its counters.
class Pass {
public:
    Pass(PassLog& log, std::string name) : log_(&log), start_(std::chrono::steady_clock::now()) {
        counters_ = &log.passes.emplace_back();
        counters_->name = std::move(name);
    }
    ~Pass() { counters_->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
    Pass(const Pass&) = delete;
    Pass& operator=(const Pass&) = delete;

    PassCounters& counters() { return *counters_; }
    PassLog& log() { return *log_; }

private:
    PassLog* log_;
    PassCounters* counters_;
    std::chrono::steady_clock::time_point start_;
};

} // namespace gnomon
