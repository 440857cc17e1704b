#pragma once
// An OpenGL 4.5 core context without a window, through EGL: Mesa's software rasterizer unless hardware is asked for.

#include <memory>
#include <string>

namespace gnomon_gl {

struct ContextOptions {
    bool hardware = false; // whatever device EGL offers, instead of Mesa's software rasterizer
    int threads = 0;       // of the software rasterizer; 0: its own choice
};

// Current on the calling thread for as long as it lives; one at a time.
class Context {
public:
    // Null where there is no EGL or no such context; `reason` then says why, in one sentence.
    static std::unique_ptr<Context> open(const ContextOptions& options, std::string& reason);
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    // "RENDERER, VERSION, N sub-pixel bits": what a comparison was made with.
    std::string description() const;

private:
    Context(void* display, void* context) : display_(display), context_(context) {}
    void* display_;
    void* context_;
};

} // namespace gnomon_gl
