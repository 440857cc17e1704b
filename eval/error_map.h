#pragma once
// Pictures of where a test image is wrong. The signed map is blue where the test is below the reference (too dark, a
// shadow that is not there), white where they agree and red where it is above (too light, a leak). The magnitude map
// runs through magma from black, no error; so does the FLIP map. The overlay shows leaks in orange to red and false
// shadows in blue on the reference in grey, the false colours run from blue, no error, over green to red. Below the
// picture stand a colour bar, its range and a title.

#include <cstdint>
#include <string>

#include "core/image.h"
#include "core/math.h"

namespace gnomon {

enum class ErrorMapKind { Signed, Magnitude, Flip, Overlay, FalseColor };

// What a kind is called on the command line: "signed", "magnitude", "flip", "overlay", "false-color".
const char* error_map_kind_name(ErrorMapKind kind);
inline constexpr int error_map_kinds = 5;

struct ErrorMapOptions {
    ErrorMapKind kind = ErrorMapKind::Signed;
    float range = 0.0f;    // the error at the end of the bar; 0: nice_range of the largest one, or 1 of FLIP. Errors
                           // beyond it take its colour
    bool color_bar = true; // false: the picture alone, of the images' size
    std::string title;     // left of the bar's caption; drawn in capitals
};

// The smallest of 1, 2, 2.5 and 5 times a power of ten that is at least `largest`; 1 where that is 0 or not finite.
float nice_range(float largest);

// The numbers that a map shows. Signed: test − reference; magnitude and false colour: its size; overlay: test −
// reference where the classes of eval/metric/classes.h make it a leak (above 0) or a false shadow (below 0), else 0.
// NaN where one image is not finite. Not of FLIP, whose map eval/compare.h makes.
Image<float> error_values(ErrorMapKind kind, const Image<float>& test, const Image<float>& reference);

// `values` under the colours of `options.kind`: pixels outside the mask (empty: all are inside) are grey, in an overlay
// nearly black; those that are not finite are green. `reference` is what an overlay lies on. Returns display-referred
// sRGB, wider than the images where the bar's labels need it. Throws InputError where sizes differ.
Image<vec3> draw_error_values(const Image<float>& values, const Image<float>& reference,
                              const Image<std::uint8_t>& mask, const ErrorMapOptions& options);

// Both, for every kind but FLIP.
Image<vec3> draw_error_map(const Image<float>& test, const Image<float>& reference, const Image<std::uint8_t>& mask,
                           const ErrorMapOptions& options = {});

inline constexpr vec3 masked_out_color{0.55f, 0.55f, 0.55f}, missing_color{0.0f, 0.7f, 0.3f};

} // namespace gnomon
