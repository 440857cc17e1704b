#include "bin/text.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "core/error.h"
#include "core/image.h"

namespace gnomon {
namespace {

[[noreturn]] void fail(const std::string& what, std::string_view text, const std::string& must) {
    throw UsageError(fmt::format("{} is '{}', but must be {}", what, text, must));
}

// False where `text` is no finite number from beginning to end.
bool read_number(std::string_view text, double& value) {
    if (text.starts_with('+')) text.remove_prefix(1);
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    return error == std::errc() && stop == end && std::isfinite(value);
}

// Read numbers become float32: one that is too large for it would turn into infinity.
bool read_float(std::string_view text, float& value) {
    double wide = 0;
    if (!read_number(text, wide) || std::abs(wide) > static_cast<double>(std::numeric_limits<float>::max()))
        return false;
    value = static_cast<float>(wide);
    return true;
}

} // namespace

double parse_real(std::string_view text, const std::string& what, double minimum, double maximum) {
    double value = 0;
    if (!read_number(text, value)) fail(what, text, "a number");
    if (value < minimum || value > maximum) fail(what, text, fmt::format("between {} and {}", minimum, maximum));
    return value;
}

int parse_integer(std::string_view text, const std::string& what, int minimum, int maximum) {
    int value = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc::invalid_argument || stop != end) fail(what, text, "a whole number");
    if (error != std::errc() || value < minimum || value > maximum)
        fail(what, text, fmt::format("between {} and {}", minimum, maximum));
    return value;
}

vec3 parse_vec3(std::string_view text, const std::string& what) {
    const std::vector<std::string> parts = split(text, ',');
    vec3 value(0.0f);
    if (parts.size() != 3 || !read_float(parts[0], value.x) || !read_float(parts[1], value.y) ||
        !read_float(parts[2], value.z))
        fail(what, text, "three numbers x,y,z");
    return value;
}

ivec2 parse_size(std::string_view text, const std::string& what) {
    const std::vector<std::string> parts = split(text, 'x');
    if (parts.size() != 2) fail(what, text, "WIDTHxHEIGHT, such as 1280x720");
    return {parse_integer(parts[0], what + " width", 1, max_image_side),
            parse_integer(parts[1], what + " height", 1, max_image_side)};
}

vec2 parse_extent(std::string_view text, const std::string& what) {
    const std::vector<std::string> parts = split(text, 'x');
    vec2 value(0.0f);
    const bool read = parts.size() == 1   ? read_float(parts[0], value.x) && read_float(parts[0], value.y)
                      : parts.size() == 2 ? read_float(parts[0], value.x) && read_float(parts[1], value.y)
                                          : false;
    if (!read || value.x <= 0 || value.y <= 0) fail(what, text, "WIDTHxHEIGHT or one number, in metres, above 0");
    return value;
}

ivec2 parse_share(std::string_view text, const std::string& what) {
    const size_t slash = text.find('/');
    if (slash == std::string::npos) fail(what, text, "PART/PARTS such as 1/4");
    const int parts = parse_integer(text.substr(slash + 1), what, 1, 1 << 20);
    return {parse_integer(text.substr(0, slash), what, 1, parts), parts};
}

std::vector<std::string> split(std::string_view text, char separator) {
    std::vector<std::string> parts;
    for (size_t begin = 0;;) {
        const size_t end = std::min(text.find(separator, begin), text.size());
        parts.emplace_back(text.substr(begin, end - begin));
        if (end == text.size()) return parts;
        begin = end + 1;
    }
}

size_t parse_choice(const std::string& word, const std::string& what, const std::vector<std::string>& choices) {
    const auto found = std::find(choices.begin(), choices.end(), word);
    if (found == choices.end())
        fail(what, word, fmt::format("one of {}{}", fmt::join(choices, ", "), did_you_mean(word, choices)));
    return static_cast<size_t>(found - choices.begin());
}

std::string aligned(const std::vector<std::vector<std::string>>& rows) {
    std::vector<size_t> widths;
    for (const auto& row : rows)
        for (size_t i = 0; i < row.size(); ++i) {
            if (widths.size() <= i) widths.push_back(0);
            widths[i] = std::max(widths[i], row[i].size());
        }
    std::string text;
    for (const auto& row : rows) {
        for (size_t i = 0; i + 1 < row.size(); ++i) text += fmt::format("{:<{}}  ", row[i], widths[i]);
        text += row.back() + "\n";
    }
    return text;
}

void print(std::string_view text) {
    const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
    if (!written && errno != EPIPE) throw InputError("cannot write to standard output");
}

void print_message(std::string_view sentence) {
    std::string line(sentence);
    std::replace(line.begin(), line.end(), '\n', ' ');
    while (!line.empty() && line.back() == ' ') line.pop_back();
    std::fprintf(stderr, "gnomon: %s\n", line.c_str());
}

} // namespace gnomon
