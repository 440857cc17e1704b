#include "core/json_reader.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace gnomon {
namespace {

constexpr int max_depth = 200;

// Deep nesting exhausts the stack of recursive consumers long before it means anything.
void check_depth(std::string_view text, const std::string& file) {
    int depth = 0;
    bool quoted = false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted) {
            if (c == '\\')
                ++i;
            else if (c == '"')
                quoted = false;
        } else if (c == '"')
            quoted = true;
        else if (c == '[' || c == '{') {
            if (++depth > max_depth)
                throw InputError(
                    fmt::format("{}: the JSON is nested deeper than {} levels; flatten it", file, max_depth));
        } else if (c == ']' || c == '}')
            --depth;
    }
}

std::string shortest(double value) { return fmt::format("{:g}", value); }

} // namespace

std::string one_line(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
    while (!text.empty() && text.back() == ' ') text.pop_back();
    return text;
}

nlohmann::json parse_json(std::string_view text, const std::string& file) {
    check_depth(text, file);
    try {
        return nlohmann::json::parse(text);
    } catch (const nlohmann::json::exception& error) {
        // "[json.exception.parse_error.101] parse error at line 3, column 5: syntax error while …; expected …"
        std::string message = error.what();
        const size_t place = message.find(" at line ");
        if (place != std::string::npos) message = message.substr(place + 4);
        throw InputError(fmt::format("{}: not valid JSON: {}", file, one_line(message)));
    }
}

void JsonReader::fail(const std::string& complaint) const {
    throw InputError(one_line(fmt::format("{}: {} {}", *file_, path_.empty() ? "the document" : path_, complaint)));
}

void JsonReader::expect_object() const {
    if (!value_->is_object()) fail("must be an object");
}

bool JsonReader::has(const std::string& key) const { return value_->is_object() && value_->contains(key); }

JsonReader JsonReader::at(const std::string& key) const {
    expect_object();
    const auto found = value_->find(key);
    if (found == value_->end()) fail("has no '" + key + "'");
    return {*found, *file_, path_.empty() ? key : path_ + "." + key};
}

void JsonReader::only(const Keys& known) const {
    expect_object();
    for (const auto& item : value_->items()) {
        if (std::find(known.begin(), known.end(), item.key()) != known.end()) continue;
        const JsonReader place(item.value(), *file_, path_.empty() ? item.key() : path_ + "." + item.key());
        place.fail("is not a known key" + did_you_mean(item.key(), known));
    }
}

size_t JsonReader::size() const {
    if (!value_->is_array()) fail("must be an array");
    return value_->size();
}

JsonReader JsonReader::operator[](size_t i) const {
    if (i >= size()) fail("must have more than " + std::to_string(i) + " elements");
    return {(*value_)[i], *file_, path_ + "[" + std::to_string(i) + "]"};
}

double JsonReader::number(double minimum, double maximum) const {
    const double number = value_->is_number() ? value_->get<double>() : NAN;
    if (number >= minimum && number <= maximum) return number;
    fail("must be a number between " + shortest(minimum) + " and " + shortest(maximum));
}

int JsonReader::integer(int minimum, int maximum) const {
    const double value = value_->is_number() ? value_->get<double>() : NAN;
    if (value >= minimum && value <= maximum && value == std::floor(value)) return static_cast<int>(value);
    fail(fmt::format("must be a whole number between {} and {}", minimum, maximum));
}

size_t JsonReader::count() const {
    const double value = value_->is_number() ? value_->get<double>() : NAN;
    if (value >= 0 && value <= 0x1p53 && value == std::floor(value)) return static_cast<size_t>(value);
    fail("must be a whole number that is not negative");
}

size_t JsonReader::index(size_t limit, const char* of) const {
    const size_t value = count();
    if (value >= limit) fail(fmt::format("is {}, but there are only {} {}", value, limit, of));
    return value;
}

bool JsonReader::boolean() const {
    if (!value_->is_boolean()) fail("must be true or false");
    return value_->get<bool>();
}

std::string JsonReader::text() const {
    if (!value_->is_string()) fail("must be a string");
    return value_->get<std::string>();
}

dvec3 JsonReader::vector3(double minimum, double maximum) const {
    if (!value_->is_array() || value_->size() != 3) fail("must be an array of three numbers");
    return {(*this)[0].number(minimum, maximum), (*this)[1].number(minimum, maximum),
            (*this)[2].number(minimum, maximum)};
}

} // namespace gnomon
