#include "core/parallel.h"

#include <algorithm>
#include <thread>

#include <immintrin.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace gnomon {

FloatModeScope::FloatModeScope(FloatMode mode) : saved_(_mm_getcsr()) {
    constexpr unsigned masked_exceptions_round_nearest = 0x1f80, flush_zero = 0x8000, denormals_are_zero = 0x0040;
    _mm_setcsr(masked_exceptions_round_nearest | (mode == FloatMode::FlushZero ? flush_zero | denormals_are_zero : 0));
}

FloatModeScope::~FloatModeScope() { _mm_setcsr(saved_); }

void parallel_for(size_t count, size_t grain, const std::function<void(size_t, size_t)>& body, FloatMode mode) {
    if (count == 0) return;
    const auto chunk = [&](size_t index) {
        const FloatModeScope scope(mode);
        body(index * grain, std::min(count, (index + 1) * grain));
    };
    const size_t chunks = chunk_count(count, grain);
    if (chunks == 1) return chunk(0);
    tbb::parallel_for(size_t{0}, chunks, chunk);
}

void with_threads(int threads, const std::function<void()>& body) {
    const int count = threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(count));
    tbb::task_arena arena(count);
    arena.execute(body);
}

} // namespace gnomon
