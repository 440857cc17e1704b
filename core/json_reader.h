#pragma once
// Checked reading of JSON documents: a value that knows the file and the place it came from, so that every complaint is
// one line such as "scene.json: lights[0].size must be a number between 0 and 1e+06".

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/math.h"

namespace gnomon {

// Throws InputError with line and column for what is not JSON, and for nesting deeper than any honest document's.
nlohmann::json parse_json(std::string_view text, const std::string& file);

// `text` with its control characters as spaces and none at its end: names out of files may hold line breaks, messages
// not.
std::string one_line(std::string text);

class JsonReader {
public:
    // `value` and `file` must outlive the reader.
    JsonReader(const nlohmann::json& value, const std::string& file, std::string path = "")
        : value_(&value), file_(&file), path_(std::move(path)) {}

    const nlohmann::json& value() const { return *value_; }
    const std::string& path() const { return path_; }
    const std::string& file() const { return *file_; }
    [[noreturn]] void fail(const std::string& complaint) const; // "file: path complaint"

    // Objects. `at` fails where the key is missing; `only` where there is any other key.
    bool has(const std::string& key) const;
    JsonReader at(const std::string& key) const;
    using Keys = std::vector<std::string>;
    void only(const Keys& known) const;

    // Arrays. `size` fails where the value is not an array.
    size_t size() const;
    JsonReader operator[](size_t i) const;

    // Values, which fail where the type or the range is wrong.
    void expect_object() const;
    double number(double minimum, double maximum) const;
    float real(double minimum, double maximum) const { return static_cast<float>(number(minimum, maximum)); }
    int integer(int minimum, int maximum) const;
    size_t count() const;                             // a whole number from 0 to 2^53
    size_t index(size_t limit, const char* of) const; // a count below limit: "is 7, but the file has 3 accessors"
    bool boolean() const;
    std::string text() const;
    dvec3 vector3(double minimum, double maximum) const; // exactly three numbers

private:
    const nlohmann::json* value_;
    const std::string* file_;
    std::string path_;
};

} // namespace gnomon
