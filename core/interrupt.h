#pragma once
// Being asked to stop. While an object of this class lives, SIGINT and SIGTERM do not end the program but are
// remembered, so that a long run can save what it has; the second one ends it after all.

namespace gnomon {

class InterruptScope {
public:
    InterruptScope();
    ~InterruptScope();
    InterruptScope(const InterruptScope&) = delete;
    InterruptScope& operator=(const InterruptScope&) = delete;
};

// SIGINT or SIGTERM where one has come while a scope was alive, else 0. From any thread.
int pending_interrupt();

} // namespace gnomon
