#pragma once
// A headless Chromium under remote control, for tests of pages: the DevTools protocol over a pair of pipes, so that
// nothing else need be installed, no port is opened and no other browser is met. Input events are the browser's own, as
// if a person's. Functions throw std::runtime_error where the browser answers with an error or not in time.

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace gnomon_tests {

// The path of Chromium, or "" after skip() where there is none.
std::string chromium_path();

class Browser {
public:
    explicit Browser(const std::string& program, int width = 1440, int height = 900);
    ~Browser();
    Browser(const Browser&) = delete;
    Browser& operator=(const Browser&) = delete;

    // Loads a file and waits until `ready`, an expression, is true.
    void open(const std::string& path, const std::string& ready);
    // The value of an expression, which may be a promise.
    nlohmann::json evaluate(const std::string& expression);
    void wait_for(const std::string& condition);

    // In CSS pixels of the window. `modifiers`: 8 for Shift.
    void move(double x, double y);
    void press(double x, double y);
    void release(double x, double y);
    void click(double x, double y);
    void wheel(double x, double y, double delta);
    void key(const std::string& key, const std::string& code, int key_code, int modifiers = 0);

    // media: "print" or "screen"; scheme: "dark" or "light".
    void emulate(const std::string& media, const std::string& scheme);
    void resize(int width, int height, double scale = 1.0);
    std::string screenshot(); // the bytes of a PNG
    std::string print();      // the bytes of a PDF

    // Console errors and warnings, uncaught exceptions and failed loads since the page was opened.
    const std::vector<std::string>& complaints() const { return complaints_; }

private:
    nlohmann::json call(const std::string& method, const nlohmann::json& parameters = nlohmann::json::object());
    nlohmann::json receive();
    void take_event(const nlohmann::json& event);
    void mouse(const std::string& type, double x, double y, const nlohmann::json& more);

    int child_ = -1, to_ = -1, from_ = -1, last_id_ = 0;
    std::string session_, buffer_;
    bool loaded_ = false, pressed_ = false;
    std::vector<std::string> complaints_;
};

} // namespace gnomon_tests
