#include "eval/error_map.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "eval/bitmap_font.h"
#include "eval/color_map.h"
#include "eval/metric/reduce.h"

namespace gnomon {
namespace {

constexpr vec3 paper{1.0f}, ink{0.1f};

// Where the strip below the picture has its parts, in pixels.
struct Layout {
    int scale;         // of letters: 1 up to 800 pixels of width, then 2, …
    int width, height; // of the whole picture
    int strip;         // height of the strip
    int bar_left, bar_width;
};

Layout layout_of(int width, int height, const ErrorMapOptions& options) {
    if (!options.color_bar) return {1, width, height, 0, 0, 0};
    const int scale = std::max(1, width / 800 + (width % 800 > 400 ? 1 : 0));
    const int margin = 6 * scale, needed = text_width("-0.0025   0   +0.0025", scale) + 2 * margin;
    const int whole = std::max(width, needed), strip = 36 * scale;
    return {scale, whole, height + strip, strip, margin, whole - 2 * margin};
}

ColorMap map_of(ErrorMapKind kind) { return kind == ErrorMapKind::Signed ? blue_white_red() : magma(); }

float position_of(ErrorMapKind kind, float error, float range) {
    return kind == ErrorMapKind::Signed ? 0.5f + 0.5f * error / range : std::abs(error) / range;
}

void fill(Image<vec3>& image, int left, int bottom, int width, int height, vec3 color) {
    for (int y = bottom; y < bottom + height; ++y) std::fill_n(image.row(y).begin() + left, width, color);
}

void draw_bar(Image<vec3>& image, const Layout& layout, const ErrorMapOptions& options, float range) {
    const int s = layout.scale, bottom = 12 * s, thickness = 9 * s;
    fill(image, layout.bar_left - 1, bottom - 1, layout.bar_width + 2, thickness + 2, ink);
    for (int x = 0; x < layout.bar_width; ++x) {
        const float t = (static_cast<float>(x) + 0.5f) / static_cast<float>(layout.bar_width);
        fill(image, layout.bar_left + x, bottom, 1, thickness, map_color(map_of(options.kind), t));
    }
    const bool is_signed = options.kind == ErrorMapKind::Signed;
    const std::string low = is_signed ? fmt::format("{:.6g}", -range) : "0",
                      middle = is_signed ? "0" : fmt::format("{:.6g}", range / 2),
                      high = is_signed ? fmt::format("{:+.6g}", range) : fmt::format("{:.6g}", range);
    const int y = 2 * s, right = layout.bar_left + layout.bar_width;
    draw_text(image, layout.bar_left, y, low, ink, s);
    draw_text(image, layout.bar_left + (layout.bar_width - text_width(middle, s)) / 2, y, middle, ink, s);
    draw_text(image, right - text_width(high, s), y, high, ink, s);

    fill(image, 0, layout.strip - 1, layout.width, 1, vec3(0.75f)); // parts a white picture from the strip
    // The title and, where both fit, what the colours mean.
    const std::string meaning = is_signed ? "test - reference: blue under, red over" : "|test - reference|";
    const int caption = 25 * s, title_width = options.title.empty() ? 0 : text_width(options.title + "  ", s);
    draw_text(image, layout.bar_left, caption, options.title, ink, s);
    if (title_width + text_width(meaning, s) <= layout.bar_width)
        draw_text(image, right - text_width(meaning, s), caption, meaning, ink, s);
}

} // namespace

float nice_range(float largest) {
    if (!(largest > 0.0f) || !std::isfinite(largest)) return 1.0f;
    const double power = std::pow(10.0, std::floor(std::log10(double{largest})));
    for (const double step : {1.0, 2.0, 2.5, 5.0})
        if (static_cast<float>(step * power) >= largest) return static_cast<float>(step * power);
    return static_cast<float>(10.0 * power);
}

Image<vec3> draw_error_map(const Image<float>& test, const Image<float>& reference, const Image<std::uint8_t>& mask,
                           const ErrorMapOptions& options) {
    if (test.width() != reference.width() || test.height() != reference.height() ||
        (!mask.empty() && (mask.width() != test.width() || mask.height() != test.height())))
        throw InputError(fmt::format("an error map needs images of one size, not {}x{} and {}x{}", test.width(),
                                     test.height(), reference.width(), reference.height()));
    const ImagePair pair{test, reference, mask};
    const double largest = reduce_differences(pair, [](double t, double r) { return std::abs(t - r); }).largest;
    const float range = options.range > 0.0f ? options.range : nice_range(static_cast<float>(largest));
    const Layout layout = layout_of(test.width(), test.height(), options);
    Image<vec3> image(layout.width, layout.height, paper);
    parallel_for(static_cast<size_t>(test.height()), 16, [&](size_t begin, size_t end) {
        for (size_t pixel = begin * static_cast<size_t>(test.width()); pixel < end * static_cast<size_t>(test.width());
             ++pixel) {
            const int x = static_cast<int>(pixel % static_cast<size_t>(test.width()));
            const int y = static_cast<int>(pixel / static_cast<size_t>(test.width())) + layout.strip;
            const float error = test.values()[pixel] - reference.values()[pixel];
            if (!mask.empty() && mask.values()[pixel] == 0)
                image(x, y) = masked_out_color;
            else if (!takes_part(pair, pixel))
                image(x, y) = missing_color;
            else
                image(x, y) = map_color(map_of(options.kind), position_of(options.kind, error, range));
        }
    });
    if (options.color_bar) draw_bar(image, layout, options, range);
    return image;
}

} // namespace gnomon
