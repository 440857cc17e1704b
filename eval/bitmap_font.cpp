#include "eval/bitmap_font.h"

#include <array>
#include <cstdint>

namespace gnomon {
namespace {

// Rows from the top, five bits each, the leftmost the highest.
struct Glyph {
    char letter;
    std::array<std::uint8_t, glyph_height> rows;
};

// clang-format off
constexpr Glyph glyphs[] = {
    {'A', {14, 17, 17, 31, 17, 17, 17}},     {'B', {30, 17, 17, 30, 17, 17, 30}},
    {'C', {14, 17, 16, 16, 16, 17, 14}},     {'D', {30, 17, 17, 17, 17, 17, 30}},
    {'E', {31, 16, 16, 30, 16, 16, 31}},     {'F', {31, 16, 16, 30, 16, 16, 16}},
    {'G', {14, 17, 16, 23, 17, 17, 15}},     {'H', {17, 17, 17, 31, 17, 17, 17}},
    {'I', {14, 4, 4, 4, 4, 4, 14}},     {'J', {7, 2, 2, 2, 2, 18, 12}},
    {'K', {17, 18, 20, 24, 20, 18, 17}},     {'L', {16, 16, 16, 16, 16, 16, 31}},
    {'M', {17, 27, 21, 21, 17, 17, 17}},     {'N', {17, 25, 21, 21, 19, 17, 17}},
    {'O', {14, 17, 17, 17, 17, 17, 14}},     {'P', {30, 17, 17, 30, 16, 16, 16}},
    {'Q', {14, 17, 17, 17, 21, 18, 13}},     {'R', {30, 17, 17, 30, 20, 18, 17}},
    {'S', {15, 16, 16, 14, 1, 1, 30}},     {'T', {31, 4, 4, 4, 4, 4, 4}},
    {'U', {17, 17, 17, 17, 17, 17, 14}},     {'V', {17, 17, 17, 17, 17, 10, 4}},
    {'W', {17, 17, 17, 21, 21, 27, 17}},     {'X', {17, 17, 10, 4, 10, 17, 17}},
    {'Y', {17, 17, 10, 4, 4, 4, 4}},     {'Z', {31, 1, 2, 4, 8, 16, 31}},
    {'0', {14, 17, 19, 21, 25, 17, 14}},     {'1', {4, 12, 4, 4, 4, 4, 14}},
    {'2', {14, 17, 1, 6, 8, 16, 31}},     {'3', {30, 1, 1, 14, 1, 1, 30}},
    {'4', {2, 6, 10, 18, 31, 2, 2}},     {'5', {31, 16, 30, 1, 1, 17, 14}},
    {'6', {6, 8, 16, 30, 17, 17, 14}},     {'7', {31, 1, 2, 4, 8, 8, 8}},
    {'8', {14, 17, 17, 14, 17, 17, 14}},     {'9', {14, 17, 17, 15, 1, 2, 12}},
    {' ', {0, 0, 0, 0, 0, 0, 0}},     {'.', {0, 0, 0, 0, 0, 12, 12}},
    {',', {0, 0, 0, 0, 12, 4, 8}},     {'-', {0, 0, 0, 31, 0, 0, 0}},
    {'+', {0, 4, 4, 31, 4, 4, 0}},     {':', {0, 12, 12, 0, 12, 12, 0}},
    {'%', {24, 25, 2, 4, 8, 19, 3}},     {'/', {0, 1, 2, 4, 8, 16, 0}},
    {'(', {2, 4, 8, 8, 8, 4, 2}},     {')', {8, 4, 2, 2, 2, 4, 8}},
    {'=', {0, 0, 31, 0, 31, 0, 0}},     {'_', {0, 0, 0, 0, 0, 0, 31}},
    {'<', {2, 4, 8, 16, 8, 4, 2}},     {'>', {8, 4, 2, 1, 2, 4, 8}},
    {'|', {4, 4, 4, 4, 4, 4, 4}},
};
// clang-format on

constexpr Glyph box = {'?', {31, 17, 17, 17, 17, 17, 31}};

const Glyph& glyph_of(char letter) {
    const char capital = letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 'a' + 'A') : letter;
    for (const Glyph& glyph : glyphs)
        if (glyph.letter == capital) return glyph;
    return box;
}

} // namespace

int text_width(std::string_view text, int scale) {
    return text.empty() ? 0 : (static_cast<int>(text.size()) * glyph_advance - 1) * scale;
}

void draw_text(Image<vec3>& image, int x, int y, std::string_view text, vec3 color, int scale) {
    const auto dot = [&](int left, int bottom) {
        for (int j = bottom; j < bottom + scale; ++j)
            for (int i = left; i < left + scale; ++i)
                if (i >= 0 && j >= 0 && i < image.width() && j < image.height()) image(i, j) = color;
    };
    for (const char letter : text) {
        const Glyph& glyph = glyph_of(letter);
        for (int row = 0; row < glyph_height; ++row)
            for (int column = 0; column < 5; ++column)
                if (glyph.rows[static_cast<size_t>(row)] >> (4 - column) & 1)
                    dot(x + column * scale, y + (glyph_height - 1 - row) * scale);
        x += glyph_advance * scale;
    }
}

} // namespace gnomon
