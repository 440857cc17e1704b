#pragma once
// Undoes base64, in which pages hold their images and browsers send theirs.

#include <string>

namespace gnomon_tests {

inline std::string decoded_base64(const std::string& text) {
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string bytes;
    unsigned bits = 0;
    int count = 0;
    for (const char letter : text) {
        if (letter == '=') break;
        bits = bits << 6 | static_cast<unsigned>(letters.find(letter));
        if ((count += 6) >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255);
    }
    return bytes;
}

} // namespace gnomon_tests
