#pragma once
// A two-dimensional array of values. Row 0 is the bottom row (window coordinates); image files are flipped once, at the
// file boundary (core/image_file.h).

#include <cassert>
#include <cstddef>
#include <span>
#include <vector>

#include "core/error.h"
#include "core/math.h"

namespace gnomon {

inline constexpr int max_image_side = 32768;

// Throws UsageError unless 1 ≤ width, height ≤ max_image_side; `what` names the image in the message.
void check_image_size(int width, int height, const char* what);

template <class T> class Image {
public:
    Image() = default;
    Image(int width, int height, T value = T{}) : width_(width), height_(height) {
        check_image_size(width, height, "image");
        values_.assign(static_cast<size_t>(width) * static_cast<size_t>(height), value);
    }

    int width() const { return width_; }
    int height() const { return height_; }
    size_t size() const { return values_.size(); }
    bool empty() const { return values_.empty(); }

    T& operator()(int x, int y) { return values_[index(x, y)]; }
    const T& operator()(int x, int y) const { return values_[index(x, y)]; }
    std::span<T> row(int y) { return {values_.data() + index(0, y), static_cast<size_t>(width_)}; }
    std::span<const T> row(int y) const { return {values_.data() + index(0, y), static_cast<size_t>(width_)}; }
    std::span<T> values() { return values_; }
    std::span<const T> values() const { return values_; }
    T* data() { return values_.data(); }
    const T* data() const { return values_.data(); }

private:
    size_t index(int x, int y) const {
        assert(x >= 0 && x < width_ && y >= 0 && y < height_);
        return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
    }

    int width_ = 0;
    int height_ = 0;
    std::vector<T> values_;
};

} // namespace gnomon
