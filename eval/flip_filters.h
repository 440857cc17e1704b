#pragma once
// The inner parts of eval/flip.h: its filters, row by row, and the difference of two filtered rows. [2020] is the LDR
// paper.

#include <array>
#include <functional>
#include <vector>

namespace gnomon {

struct FlipXyz {
    float x, y, z; // 1 for the white of sRGB
};

// CIE XYZ of linear sRGB (IEC 61966-2-1), divided by that of white.
inline FlipXyz xyz_from_rgb(float red, float green, float blue) {
    return {0.433895389f * red + 0.376242373f * green + 0.189862239f * blue,
            0.212636822f * red + 0.715182982f * green + 0.072180196f * blue,
            0.017752423f * red + 0.109465629f * green + 0.872781948f * blue};
}

using FlipKernel = std::vector<float>; // 2·radius + 1 weights

// Every two-dimensional filter of the paper is a sum of products of these.
struct FlipKernels {
    int radius = 0;                           // of all: the wider ones decide
    FlipKernel lightness, red_green;          // contrast sensitivity of the eye [2020, eqs. 2, 3], sums of 1
    std::array<FlipKernel, 2> blue_yellow;    // two Gaussians along x; along y, they sum to 1 together
    std::array<FlipKernel, 2> blue_yellow_up; // the same along y, with their shares in the sum
    FlipKernel gauss, edge, point; // of the feature detectors [2020, 4.2]: also its first and second derivative
};
FlipKernels flip_kernels(float pixels_per_degree);

// What a viewer sees of a row: filtered opponent colours and the strengths of edges and points.
struct FlipFiltered {
    std::array<std::vector<float>, 3> colors;
    std::vector<float> edges, points;
};

// Some columns of a picture.
struct FlipArea {
    int width, height; // of the picture
    int first_column, columns;
};

// Filters an area row by row, from the bottom; beyond the picture's border the border's pixels go on.
class FlipRows {
public:
    // Row y of the columns [begin, end) in opponent colours.
    using Load = std::function<void(int y, int begin, int end, std::array<std::vector<float>, 3>& opponents)>;

    FlipRows(const FlipKernels& kernels, const FlipArea& area);
    void filter_row(int y, const Load& load); // y must not go down; rows that were skipped are fine
    const FlipFiltered& filtered() const { return filtered_; }

private:
    // Filtered along x: the colours (blue-yellow twice), then the lightness by the three feature kernels.
    enum Part : size_t { Lightness, RedGreen, BlueYellow, BlueYellow2, Gauss, Edge, Point, parts };
    using Row = std::array<std::vector<float>, parts>;

    void load_row(int y, const Load& load);
    void filter_along(int y, Part part, const FlipKernel& kernel);
    void add_up(int y, Part part, const FlipKernel& kernel,
                std::vector<float>& out); // out += the part filtered along y
    Row& slot(int y) { return ring_[static_cast<size_t>(y) % ring_.size()]; }

    const FlipKernels& kernels_;
    FlipArea area_;
    int next_ = 0;                     // the row to load
    std::vector<Row> ring_;            // the rows around the present one
    std::vector<const float*> window_; // what a kernel's weights meet
    std::array<std::vector<float>, 3> opponents_;
    std::vector<float> padded_, across_;
    FlipFiltered filtered_;
};

// Per pixel: the colour difference [2020, 4.1] to the power of one minus the feature difference [2020, eqs. 7, 8].
void flip_differences(const FlipFiltered& test, const FlipFiltered& reference, float* out, size_t count);

} // namespace gnomon
