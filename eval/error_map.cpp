#include "eval/error_map.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "core/parallel.h"
#include "eval/bitmap_font.h"
#include "eval/color_map.h"
#include "eval/metric/classes.h"

namespace gnomon {
namespace {

constexpr vec3 paper{1.0f}, ink{0.1f};
constexpr vec3 outside_overlay{0.1f}; // darker than any grey of the reference

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

// How a kind looks and what its bar says.
struct Look {
    const char* name;
    ColorMap map;
    bool is_signed;
    const char* meaning;
};
const Look& look_of(ErrorMapKind kind) {
    static const Look looks[error_map_kinds] = {
        {"signed", blue_white_red(), true, "test - reference: blue under, red over"},
        {"magnitude", magma(), false, "|test - reference|"},
        {"flip", magma(), false, "visible difference"},
        {"overlay", shadow_and_light(), true, "blue false shadow, orange to red leak"},
        {"false-color", blue_green_red(), false, "|test - reference|"},
    };
    return looks[static_cast<size_t>(kind)];
}

vec3 color_of(const Look& look, float error, float range) {
    return map_color(look.map, look.is_signed ? 0.5f + 0.5f * error / range : std::abs(error) / range);
}

// What an overlay shows where nothing is wrong.
vec3 background(float visibility) {
    return vec3(std::isfinite(visibility) ? 0.25f + 0.6f * std::clamp(visibility, 0.0f, 1.0f) : 0.5f);
}

void fill(Image<vec3>& image, int left, int bottom, int width, int height, vec3 color) {
    for (int y = bottom; y < bottom + height; ++y) std::fill_n(image.row(y).begin() + left, width, color);
}

void draw_bar(Image<vec3>& image, const Layout& layout, const ErrorMapOptions& options, float range) {
    const Look& look = look_of(options.kind);
    const int s = layout.scale, bottom = 12 * s, thickness = 9 * s;
    fill(image, layout.bar_left - 1, bottom - 1, layout.bar_width + 2, thickness + 2, ink);
    for (int x = 0; x < layout.bar_width; ++x) {
        const float t = (static_cast<float>(x) + 0.5f) / static_cast<float>(layout.bar_width);
        fill(image, layout.bar_left + x, bottom, 1, thickness, map_color(look.map, t));
    }
    const std::string low = look.is_signed ? fmt::format("{:.6g}", -range) : "0",
                      middle = look.is_signed ? "0" : fmt::format("{:.6g}", range / 2),
                      high = look.is_signed ? fmt::format("{:+.6g}", range) : fmt::format("{:.6g}", range);
    const int y = 2 * s, right = layout.bar_left + layout.bar_width;
    draw_text(image, layout.bar_left, y, low, ink, s);
    draw_text(image, layout.bar_left + (layout.bar_width - text_width(middle, s)) / 2, y, middle, ink, s);
    draw_text(image, right - text_width(high, s), y, high, ink, s);

    fill(image, 0, layout.strip - 1, layout.width, 1, vec3(0.75f)); // parts a white picture from the strip
    // The title and, where both fit, what the colours mean.
    const std::string meaning = look.meaning;
    const int caption = 25 * s, title_width = options.title.empty() ? 0 : text_width(options.title + "  ", s);
    draw_text(image, layout.bar_left, caption, options.title, ink, s);
    if (title_width + text_width(meaning, s) <= layout.bar_width)
        draw_text(image, right - text_width(meaning, s), caption, meaning, ink, s);
}

template <class A, class B> void check_same_size(const Image<A>& a, const Image<B>& b) {
    if (a.width() != b.width() || a.height() != b.height())
        throw InputError(fmt::format("an error map needs images of one size, not {}x{} and {}x{}", a.width(),
                                     a.height(), b.width(), b.height()));
}

} // namespace

float nice_range(float largest) {
    if (!(largest > 0.0f) || !std::isfinite(largest)) return 1.0f;
    const double power = std::pow(10.0, std::floor(std::log10(double{largest})));
    for (const double step : {1.0, 2.0, 2.5, 5.0})
        if (static_cast<float>(step * power) >= largest) return static_cast<float>(step * power);
    return static_cast<float>(10.0 * power);
}

const char* error_map_kind_name(ErrorMapKind kind) { return look_of(kind).name; }

Image<float> error_values(ErrorMapKind kind, const Image<float>& test, const Image<float>& reference) {
    check_same_size(test, reference);
    Image<float> values(test.width(), test.height());
    parallel_for(values.size(), 1 << 14, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const float t = test.values()[i], r = reference.values()[i];
            float error = std::isfinite(t) && std::isfinite(r) ? t - r : std::numeric_limits<float>::quiet_NaN();
            if (kind == ErrorMapKind::Overlay && std::isfinite(error)) {
                const ShadowClass shadow = shadow_class(r);
                const bool wrong = (shadow == ShadowClass::Umbra && t > leak_above) ||
                                   (shadow == ShadowClass::Lit && t < false_shadow_below);
                error = wrong ? error : 0.0f;
            }
            values.values()[i] = look_of(kind).is_signed ? error : std::abs(error);
        }
    });
    return values;
}

Image<vec3> draw_error_values(const Image<float>& values, const Image<float>& reference,
                              const Image<std::uint8_t>& mask, const ErrorMapOptions& options) {
    check_same_size(values, reference);
    if (!mask.empty()) check_same_size(values, mask);
    const auto inside = [&](size_t pixel) { return mask.empty() || mask.values()[pixel] != 0; };
    float largest = 0.0f;
    for (size_t pixel = 0; pixel < values.size(); ++pixel)
        if (inside(pixel) && std::isfinite(values.values()[pixel]))
            largest = std::max(largest, std::abs(values.values()[pixel]));
    const float automatic = options.kind == ErrorMapKind::Flip ? 1.0f : nice_range(largest);
    const float range = options.range > 0.0f ? options.range : automatic;
    const Layout layout = layout_of(values.width(), values.height(), options);
    const Look& look = look_of(options.kind);
    Image<vec3> image(layout.width, layout.height, paper);
    parallel_for(static_cast<size_t>(values.height()), 16, [&](size_t begin, size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < values.width(); ++x) {
                const float error = values(x, y);
                vec3& color = image(x, y + layout.strip);
                if (!mask.empty() && mask(x, y) == 0)
                    color = options.kind == ErrorMapKind::Overlay ? outside_overlay : masked_out_color;
                else if (!std::isfinite(error))
                    color = missing_color;
                else if (options.kind == ErrorMapKind::Overlay && error == 0.0f)
                    color = background(reference(x, y));
                else
                    color = color_of(look, error, range);
            }
    });
    if (options.color_bar) draw_bar(image, layout, options, range);
    return image;
}

Image<vec3> draw_error_map(const Image<float>& test, const Image<float>& reference, const Image<std::uint8_t>& mask,
                           const ErrorMapOptions& options) {
    return draw_error_values(error_values(options.kind, test, reference), reference, mask, options);
}

} // namespace gnomon
