#pragma once
// Text of the command line into values. Every function takes what the value is for ("--size"), which starts its error
// message, and throws UsageError. Numbers are read strictly: no locale, no blanks, nothing behind them, finite.

#include <string>
#include <string_view>
#include <vector>

#include "core/math.h"

namespace gnomon {

double parse_real(std::string_view text, const std::string& what, double minimum, double maximum);
int parse_integer(std::string_view text, const std::string& what, int minimum, int maximum);
vec3 parse_vec3(std::string_view text, const std::string& what);   // "x,y,z"
ivec2 parse_size(std::string_view text, const std::string& what);  // "1280x720", each 1 to max_image_side
vec2 parse_extent(std::string_view text, const std::string& what); // "2x1.5" or "2" (both), each above 0

ivec2 parse_share(std::string_view text, const std::string& what); // "1/4": part and parts, from 1

std::vector<std::string> split(std::string_view text, char separator);

// The index of `word` in `choices`; the error lists them.
size_t parse_choice(const std::string& word, const std::string& what, const std::vector<std::string>& choices);

// Columns as wide as their widest cell; the last is not padded.
std::string aligned(const std::vector<std::vector<std::string>>& rows);

// The whole text to standard output. A reader that has left (a closed pipe) is no error.
void print(std::string_view text);

// One line on standard error: "gnomon: …". Line breaks inside become blanks.
void print_message(std::string_view sentence);

} // namespace gnomon
