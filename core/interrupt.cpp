#include "core/interrupt.h"

#include <atomic>
#include <csignal>

namespace gnomon {
namespace {

// A signal handler has nothing but what is global.
std::atomic<int> pending{0};
static_assert(std::atomic<int>::is_always_lock_free);

void remember(int signal) {
    pending = signal;
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
}

} // namespace

InterruptScope::InterruptScope() {
    pending = 0;
    std::signal(SIGINT, remember);
    std::signal(SIGTERM, remember);
}

InterruptScope::~InterruptScope() {
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
}

int pending_interrupt() { return pending; }

} // namespace gnomon
