#pragma once
// A built-in font of 5 x 7 pixels, for the numbers and titles inside pictures: capitals (small letters are drawn as
// capitals), digits and the punctuation of numbers and labels; anything else is a box.

#include <string_view>

#include "core/image.h"

namespace gnomon {

inline constexpr int glyph_height = 7, glyph_advance = 6;

// Width in pixels of a line of text, without the space after its last letter.
int text_width(std::string_view text, int scale);

// Draws with the lower left corner of the first letter at (x, y); what falls outside the image is cut off.
void draw_text(Image<vec3>& image, int x, int y, std::string_view text, vec3 color, int scale);

} // namespace gnomon
