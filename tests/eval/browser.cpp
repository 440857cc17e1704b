#include "tests/eval/browser.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <stdexcept>

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/eval/base64.h"
#include "tests/support.h"

namespace gnomon_tests {
namespace {

using nlohmann::json;
constexpr int patience_ms = 60'000; // a loaded machine is slow

// Becomes the browser, which reads commands from descriptor 3 and answers on 4.
[[noreturn]] void become_chromium(const std::string& program, const std::string& home, int commands, int answers,
                                  int width, int height) {
    const std::string size = "--window-size=" + std::to_string(width) + "," + std::to_string(height);
    const std::string profile = "--user-data-dir=" + home;
    setpgid(0, 0); // its many processes end together
    setenv("HOME", home.c_str(), 1);
    // Neither pipe may stand in the other's place.
    const int in = fcntl(commands, F_DUPFD, 10), out = fcntl(answers, F_DUPFD, 10), null = ::open("/dev/null", O_RDWR);
    for (const int standard : {0, 1, 2}) dup2(null, standard);
    dup2(in, 3), dup2(out, 4);
    execl(program.c_str(), program.c_str(), "--headless=new", "--no-sandbox", "--disable-gpu",
          "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking", "--disable-component-update",
          "--disable-crash-reporter", "--hide-scrollbars", "--remote-debugging-pipe", profile.c_str(), size.c_str(),
          "about:blank", nullptr);
    _exit(127);
}

} // namespace

std::string chromium_path() {
    for (const char* path : {"/usr/bin/chromium", "/usr/bin/chromium-headless-shell"})
        if (access(path, X_OK) == 0) return path;
    skip("no Chromium here (bin/setup installs Debian's chromium-headless-shell)");
    return "";
}

Browser::Browser(const std::string& program, int width, int height) {
    int commands[2], answers[2];
    if (pipe2(commands, O_CLOEXEC) != 0 || pipe2(answers, O_CLOEXEC) != 0) throw std::runtime_error("no pipes");
    const std::string home = temporary_folder();
    child_ = fork();
    if (child_ == 0) become_chromium(program, home, commands[0], answers[1], width, height);
    close(commands[0]), close(answers[1]);
    to_ = commands[1], from_ = answers[0];
    std::signal(SIGPIPE, SIG_IGN);
    const json target = call("Target.createTarget", {{"url", "about:blank"}});
    session_ = call("Target.attachToTarget", {{"targetId", target["targetId"]}, {"flatten", true}})["sessionId"];
    for (const char* domain : {"Page.enable", "Runtime.enable", "Log.enable"}) call(domain);
    resize(width, height);
}

Browser::~Browser() {
    session_.clear();
    try {
        call("Browser.close");
    } catch (const std::exception&) { // it is ended below
    }
    close(to_), close(from_);
    for (int wait = 0; wait < 100; ++wait) {
        if (waitpid(child_, nullptr, WNOHANG) == child_) {
            child_ = -1;
            break;
        }
        usleep(50'000);
    }
    if (child_ < 0) return;
    kill(-child_, SIGKILL);
    waitpid(child_, nullptr, 0);
}

json Browser::receive() {
    const auto start = std::chrono::steady_clock::now();
    for (;;) {
        const size_t end = buffer_.find('\0');
        if (end != std::string::npos) {
            const json message = json::parse(buffer_.substr(0, end));
            buffer_.erase(0, end + 1);
            return message;
        }
        const auto waited =
            std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - start);
        pollfd ready{from_, POLLIN, 0};
        if (waited.count() > patience_ms || poll(&ready, 1, patience_ms) <= 0)
            throw std::runtime_error("the browser does not answer");
        char bytes[1 << 16];
        const ssize_t count = read(from_, bytes, sizeof bytes);
        if (count <= 0) throw std::runtime_error("the browser has ended");
        buffer_.append(bytes, static_cast<size_t>(count));
    }
}

void Browser::take_event(const json& event) {
    const std::string method = event.value("method", "");
    if (method == "Page.loadEventFired") loaded_ = true;
    if (method == "Runtime.exceptionThrown") complaints_.push_back(event["params"]["exceptionDetails"].dump());
    if (method == "Log.entryAdded" && event["params"]["entry"]["level"] != "verbose")
        complaints_.push_back(event["params"]["entry"].dump());
    if (method == "Runtime.consoleAPICalled" &&
        (event["params"]["type"] == "error" || event["params"]["type"] == "warning"))
        complaints_.push_back(event["params"]["args"].dump());
}

json Browser::call(const std::string& method, const json& parameters) {
    json message = {{"id", ++last_id_}, {"method", method}, {"params", parameters}};
    if (!session_.empty()) message["sessionId"] = session_;
    const std::string text = message.dump() + '\0';
    for (size_t sent = 0; sent < text.size();) {
        const ssize_t count = write(to_, text.data() + sent, text.size() - sent);
        if (count <= 0) throw std::runtime_error("the browser has ended");
        sent += static_cast<size_t>(count);
    }
    for (;;) {
        const json answer = receive();
        if (answer.value("id", 0) != last_id_) {
            take_event(answer);
            continue;
        }
        if (answer.contains("error")) throw std::runtime_error(method + ": " + answer["error"].dump());
        return answer.value("result", json::object());
    }
}

void Browser::open(const std::string& path, const std::string& ready) {
    loaded_ = false;
    complaints_.clear();
    call("Page.navigate", {{"url", "file://" + std::filesystem::absolute(path).string()}});
    while (!loaded_) take_event(receive());
    wait_for(ready);
}

json Browser::evaluate(const std::string& expression) {
    const json answer =
        call("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
    if (answer.contains("exceptionDetails"))
        throw std::runtime_error(expression + ": " + answer["exceptionDetails"].dump());
    return answer["result"].value("value", json());
}

void Browser::wait_for(const std::string& condition) {
    const auto start = std::chrono::steady_clock::now();
    while (evaluate("Boolean(" + condition + ")") != true) {
        if (std::chrono::steady_clock::now() - start > std::chrono::milliseconds(patience_ms))
            throw std::runtime_error("waited in vain for " + condition);
        usleep(20'000);
    }
}

void Browser::mouse(const std::string& type, double x, double y, const json& more) {
    json event = {{"type", type}, {"x", x}, {"y", y}};
    event.update(more);
    call("Input.dispatchMouseEvent", event);
}

void Browser::move(double x, double y) {
    mouse("mouseMoved", x, y, {{"button", pressed_ ? "left" : "none"}, {"buttons", pressed_ ? 1 : 0}});
}

void Browser::press(double x, double y) {
    pressed_ = true;
    mouse("mousePressed", x, y, {{"button", "left"}, {"buttons", 1}, {"clickCount", 1}});
}

void Browser::release(double x, double y) {
    pressed_ = false;
    mouse("mouseReleased", x, y, {{"button", "left"}, {"clickCount", 1}});
}

void Browser::wheel(double x, double y, double delta) { mouse("mouseWheel", x, y, {{"deltaX", 0}, {"deltaY", delta}}); }

void Browser::click(double x, double y) {
    move(x, y);
    press(x, y);
    release(x, y);
}

void Browser::key(const std::string& key, const std::string& code, int key_code, int modifiers) {
    const std::string text = key == "Enter" ? "\r" : key.size() == 1 ? key : "";
    json event = {{"type", text.empty() ? "rawKeyDown" : "keyDown"},
                  {"key", key},
                  {"code", code},
                  {"windowsVirtualKeyCode", key_code},
                  {"modifiers", modifiers}};
    if (!text.empty()) event["text"] = text;
    call("Input.dispatchKeyEvent", event);
    event["type"] = "keyUp";
    event.erase("text");
    call("Input.dispatchKeyEvent", event);
}

void Browser::emulate(const std::string& media, const std::string& scheme) {
    call("Emulation.setEmulatedMedia",
         {{"media", media}, {"features", {{{"name", "prefers-color-scheme"}, {"value", scheme}}}}});
}

void Browser::resize(int width, int height, double scale) {
    call("Emulation.setDeviceMetricsOverride",
         {{"width", width}, {"height", height}, {"deviceScaleFactor", scale}, {"mobile", false}});
}

std::string Browser::screenshot() {
    return decoded_base64(call("Page.captureScreenshot", {{"format", "png"}})["data"]);
}

std::string Browser::print() {
    return decoded_base64(call("Page.printToPDF", {{"preferCSSPageSize", true}, {"printBackground", true}})["data"]);
}

} // namespace gnomon_tests
