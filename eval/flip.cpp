#include "eval/flip.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "core/vector_clones.h"
#include "eval/flip_filters.h"
#include "eval/metric/reduce.h"
#include "eval/vector_math.h"

namespace gnomon {
namespace {

// What becomes of a stored value before it is shown: linear light in [0, 1].
struct Display {
    bool srgb = false;
    bool tone_mapped = false;
    float exposure = 1.0f; // factor, of tone-mapped values
};

// ACES as fitted by Narkowicz, of 0.6 times the exposed value: (a x² + b x) / (c x² + d x + e).
constexpr float tone_a = 0.6f * 0.6f * 2.51f, tone_b = 0.6f * 0.03f, tone_c = 0.6f * 0.6f * 2.43f,
                tone_d = 0.6f * 0.59f, tone_e = 0.14f;

// From linear light to a luminance and two opponent colours that filters may average: CIELAB without its cube root.
// [2020, 4.1]
GNOMON_VECTOR_CLONES
void to_opponents(float* red, float* green, float* blue, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const FlipXyz c = xyz_from_rgb(red[i], green[i], blue[i]);
        red[i] = 116.0f * c.y - 16.0f;
        green[i] = 500.0f * (c.x - c.y);
        blue[i] = 200.0f * (c.y - c.z);
    }
}

GNOMON_VECTOR_CLONES
void linearize(float* values, size_t count) {
    for (size_t i = 0; i < count; ++i)
        values[i] = values[i] <= 0.04045f ? values[i] / 12.92f : vector_pow((values[i] + 0.055f) / 1.055f, 2.4f);
}

GNOMON_VECTOR_CLONES
void tone_map(float* values, float exposure, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const float x = values[i] * exposure;
        values[i] = std::clamp(((tone_a * x + tone_b) * x) / ((tone_c * x + tone_d) * x + tone_e), 0.0f, 1.0f);
    }
}

void show(const Display& display, std::vector<float>& values) {
    if (display.tone_mapped) {
        for (float& value : values) value = std::clamp(value, 0.0f, 1e15f); // infinite squares would give NaN
        return tone_map(values.data(), display.exposure, values.size());
    }
    for (float& value : values) value = std::clamp(value, 0.0f, 1.0f);
    if (display.srgb) linearize(values.data(), values.size());
}

bool takes_part(const ColorPair& pair, size_t pixel) {
    for (size_t c = 0; c < 3; ++c)
        if (!gnomon::takes_part({*pair.test[c], *pair.reference[c], pair.mask}, pixel)) return false;
    return true;
}

// 1 where a pixel does not take part; empty where all do.
Image<std::uint8_t> absent_pixels(const ColorPair& pair) {
    Image<std::uint8_t> absent(pair.test[0]->width(), pair.test[0]->height());
    const std::int64_t count = reduce_pixels(absent.size(), [&](size_t pixel, PixelSum& sum) {
                                   absent.values()[pixel] = !takes_part(pair, pixel);
                                   if (absent.values()[pixel]) sum.add(0.0);
                               }).count;
    return count > 0 ? absent : Image<std::uint8_t>();
}

// Columns [begin, end) of row y of one channel as they are shown.
void show_row(const Image<float>& channel, const Image<std::uint8_t>& absent, int y, int begin, int end,
              const Display& display, std::vector<float>& row) {
    row.assign(channel.row(y).begin() + begin, channel.row(y).begin() + end);
    for (size_t x = 0; x < row.size() && !absent.empty(); ++x)
        if (absent(begin + static_cast<int>(x), y)) row[x] = 0.0f;
    show(display, row);
}

// Part of a picture and what the filters see of it: some columns and rows more on every side.
struct Task {
    FlipArea area;
    int bottom, top; // rows [bottom, top)
    int radius;

    int left() const { return std::max(area.first_column - radius, 0); }
    int right() const { return std::min(area.first_column + area.columns + radius, area.width); }
};

// Whether both pictures are shown alike in all that a task's filters see; FLIP is then 0, to the bit. Where much of a
// picture is black, this is so of most tasks at most exposures: what is not black is white there.
bool shown_alike(const ColorPair& pair, const Image<std::uint8_t>& absent, const Display& display, const Task& task) {
    std::vector<float> test, reference;
    const int begin = task.left(), end = task.right(), last = std::min(task.top + task.radius, task.area.height);
    for (int y = std::max(task.bottom - task.radius, 0); y < last; ++y)
        for (size_t c = 0; c < 3; ++c) {
            const float *a = pair.test[c]->row(y).data(), *b = pair.reference[c]->row(y).data();
            if (std::equal(a + begin, a + end, b + begin)) continue;
            show_row(*pair.test[c], absent, y, begin, end, display, test);
            show_row(*pair.reference[c], absent, y, begin, end, display, reference);
            if (test != reference) return false;
        }
    return true;
}

// map = max(map, FLIP of the pictures as displayed).
void raise_map(const ColorPair& pair, const Image<std::uint8_t>& absent, const Display& display,
               float pixels_per_degree, Image<float>& map) {
    const FlipKernels kernels = flip_kernels(pixels_per_degree);
    // One task: its filtered rows stay in the second-level cache. Some 20 rows and columns around it are filtered too.
    constexpr int task_columns = 512, task_rows = 128;
    const int width = map.width(), height = map.height(), across = (width + task_columns - 1) / task_columns;
    const int tasks = across * ((height + task_rows - 1) / task_rows);
    parallel_for(static_cast<size_t>(tasks), 1, [&](size_t task, size_t) {
        const int left = static_cast<int>(task) % across * task_columns,
                  bottom = static_cast<int>(task) / across * task_rows;
        const FlipArea area{width, height, left, std::min(task_columns, width - left)};
        const int top = std::min(bottom + task_rows, height);
        if (shown_alike(pair, absent, display, {area, bottom, top, kernels.radius})) return;
        FlipRows test(kernels, area), reference(kernels, area);
        const auto load = [&](const std::array<const Image<float>*, 3>& picture) {
            return [&](int y, int begin, int end, std::array<std::vector<float>, 3>& row) {
                for (size_t c = 0; c < 3; ++c) show_row(*picture[c], absent, y, begin, end, display, row[c]);
                to_opponents(row[0].data(), row[1].data(), row[2].data(), row[0].size());
            };
        };
        std::vector<float> differences(static_cast<size_t>(area.columns));
        for (int y = bottom; y < top; ++y) {
            test.filter_row(y, load(pair.test));
            reference.filter_row(y, load(pair.reference));
            flip_differences(test.filtered(), reference.filtered(), differences.data(), differences.size());
            float* values = map.row(y).data() + left;
            for (size_t x = 0; x < differences.size(); ++x) values[x] = std::max(values[x], differences[x]);
        }
    });
}

void remove(const Image<std::uint8_t>& absent, Image<float>& map) {
    for (size_t pixel = 0; pixel < absent.size(); ++pixel)
        if (absent.values()[pixel]) map.values()[pixel] = std::numeric_limits<float>::quiet_NaN();
}

float luminance(const ColorPair& pair, size_t pixel) {
    return 0.2126f * pair.reference[0]->values()[pixel] + 0.7152f * pair.reference[1]->values()[pixel] +
           0.0722f * pair.reference[2]->values()[pixel];
}

} // namespace

Image<float> flip_map(const ColorPair& pair, float pixels_per_degree) {
    Image<float> map(pair.test[0]->width(), pair.test[0]->height(), 0.0f);
    const Image<std::uint8_t> absent = absent_pixels(pair);
    raise_map(pair, absent, {.srgb = pair.srgb}, pixels_per_degree, map);
    remove(absent, map);
    return map;
}

ExposureRange automatic_exposures(const ColorPair& pair) {
    std::vector<float> luminances;
    luminances.reserve(pair.test[0]->size());
    for (size_t pixel = 0; pixel < pair.test[0]->size(); ++pixel)
        if (takes_part(pair, pixel)) luminances.push_back(luminance(pair, pixel));
    if (luminances.empty()) return {};
    const auto middle = luminances.begin() + static_cast<std::ptrdiff_t>(luminances.size() / 2);
    std::nth_element(luminances.begin(), middle, luminances.end());
    const float smallest = std::numeric_limits<float>::epsilon(); // as in the authors' program
    const float median = std::max(*middle, smallest),
                largest = std::max(*std::max_element(middle, luminances.end()), smallest);
    // Where the tone curve reaches 0.85, its shoulder. [2021, 3]
    constexpr double shoulder = 0.85, a = tone_a - shoulder * tone_c, b = tone_b - shoulder * tone_d,
                     c = -shoulder * tone_e;
    const double x = (-b + std::sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
    ExposureRange range;
    range.start = static_cast<float>(std::log2(x / largest)), range.stop = static_cast<float>(std::log2(x / median));
    range.count = std::clamp(static_cast<int>(std::ceil(range.stop - range.start)), 2, most_exposures);
    return range;
}

Image<float> flip_hdr_map(const ColorPair& pair, float pixels_per_degree) {
    const ExposureRange range = automatic_exposures(pair);
    const Image<std::uint8_t> absent = absent_pixels(pair);
    Image<float> map(pair.test[0]->width(), pair.test[0]->height(), 0.0f);
    for (int i = 0; i < range.count; ++i) {
        const float stops =
            range.start + (range.stop - range.start) * static_cast<float>(i) / static_cast<float>(range.count - 1);
        raise_map(pair, absent, {.tone_mapped = true, .exposure = std::exp2(stops)}, pixels_per_degree, map);
    }
    remove(absent, map);
    return map;
}

double mean_of_map(const Image<float>& map) {
    return reduce_pixels(map.size(),
                         [&](size_t pixel, PixelSum& sum) {
                             if (!std::isnan(map.values()[pixel])) sum.add(map.values()[pixel]);
                         })
        .mean();
}

} // namespace gnomon
