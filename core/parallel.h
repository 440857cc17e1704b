#pragma once
// Parallel loops for deterministic work: the body writes disjoint memory, and nothing depends on which thread runs
// what. Every body runs under a stated floating-point mode, because the mode is a property of the thread.

#include <cstddef>
#include <functional>

namespace gnomon {

enum class FloatMode {
    Ieee,      // denormals kept: the rasterizer and everything else
    FlushZero, // denormals flushed to zero: what Embree asks for
};

// Sets the floating-point control word for this scope, rounding to nearest.
class FloatModeScope {
public:
    explicit FloatModeScope(FloatMode mode);
    ~FloatModeScope();
    FloatModeScope(const FloatModeScope&) = delete;
    FloatModeScope& operator=(const FloatModeScope&) = delete;

private:
    unsigned saved_;
};

// body(begin, end) over chunks of [0, count) of at most `grain` items; chunk boundaries depend on count and grain only.
void parallel_for(size_t count, size_t grain, const std::function<void(size_t begin, size_t end)>& body,
                  FloatMode mode = FloatMode::Ieee);

// Number of chunks of such a loop, and which one `begin` belongs to: for per-chunk results that are combined in order.
constexpr size_t chunk_count(size_t count, size_t grain) { return (count + grain - 1) / grain; }

// Runs `body` with at most `threads` worker threads in every loop under it; 0 means all cores. More threads than cores
// are allowed (a test that nothing depends on their number).
void with_threads(int threads, const std::function<void()>& body);

} // namespace gnomon
