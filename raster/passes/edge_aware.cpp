#include "raster/passes/edge_aware.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "raster/full_screen.h"
#include "raster/passes/rows.h"

namespace gnomon {
namespace {

using vec1 = glm::vec<1, float>;

// The first C channels of layer 0 of a target, as floats.
template <int C> Image<glm::vec<C, float>> plane_of(const Target& target) {
    Image<glm::vec<C, float>> plane(target.width(), target.height());
    const auto channels = static_cast<size_t>(info(target.format()).channels);
    parallel_for(static_cast<size_t>(target.height()), detail::full_screen_rows, [&](size_t begin, size_t end) {
        std::vector<float> row;
        for (size_t y = begin; y < end; ++y) {
            detail::load_row(target, static_cast<int>(y), 0, 0, row);
            for (int x = 0; x < target.width(); ++x)
                for (int c = 0; c < C; ++c)
                    plane(x, static_cast<int>(y))[c] = row[static_cast<size_t>(x) * channels + static_cast<size_t>(c)];
        }
    });
    return plane;
}

// What a program sees around its pixel along one axis.
template <int C> struct Neighbourhood {
    using Value = glm::vec<C, float>;
    const Value* values; // of the pixel; neighbours are `stride` apart
    const vec1* guides;
    std::ptrdiff_t stride;
    int before, after;        // pixels of the image on either side
    std::int64_t fetches = 1; // taps inside the image, the pixel itself included

    Value value(int offset = 0) const { return values[offset * stride]; }
    float guide(int offset = 0) const { return guides[offset * stride].x; }
    // Inside the image and not background; counts what had to be fetched to know.
    bool valid(int offset) {
        if (offset == 0) return true;
        if (-offset > before || offset > after) return false;
        ++fetches;
        return std::isfinite(guide(offset));
    }
};

template <int C> glm::vec<C, float> mean(Neighbourhood<C>& at, float half_width, const MeanFilter& filter) {
    const auto side = static_cast<float>(at.before + at.after + 1);
    const float reach = half_width > 0.0f ? std::min(half_width, side) : 0.0f;
    const int whole = static_cast<int>(reach);
    const int taps = filter.from_edge ? 1 + static_cast<int>(2.0f * reach) : 1 + 2 * whole;
    const glm::vec<C, float> centre = at.value();
    const float own_guide = at.guide();
    glm::vec<C, float> sum(0.0f);
    for (int i = 0; i < taps; ++i) {
        const int k = filter.from_edge ? static_cast<int>(std::round(static_cast<float>(i) - reach)) : i - whole;
        const bool keeps = at.valid(k) && std::abs(at.guide(k) - own_guide) < filter.threshold;
        sum += keeps ? at.value(k) : centre;
    }
    return sum / static_cast<float>(taps);
}

std::vector<float> spatial_weights(const BilateralFilter& filter) {
    const int half = (filter.taps - 1) / 2;
    std::vector<float> weights;
    for (int k = -half; k <= half; ++k) {
        const double t = static_cast<double>(k) / half / static_cast<double>(filter.sigma_space);
        weights.push_back(static_cast<float>(std::exp(-0.5 * t * t)));
    }
    return weights;
}

template <int C>
glm::vec<C, float> bilateral(Neighbourhood<C>& at, float half_width, std::span<const float> weights,
                             float sigma_range) {
    if (!(half_width > 0.0f)) return at.value();
    const int half = static_cast<int>(weights.size()) / 2;
    const float spacing = std::min(half_width, static_cast<float>(max_image_side)) / static_cast<float>(half);
    const float own_guide = at.guide();
    glm::vec<C, float> sum(0.0f);
    float total = 0.0f;
    for (int k = -half; k <= half; ++k) {
        const int offset = static_cast<int>(std::round(spacing * static_cast<float>(k)));
        if (!at.valid(offset)) continue;
        const float difference = (at.guide(offset) - own_guide) / sigma_range;
        const float weight = weights[static_cast<size_t>(k + half)] * std::exp(-0.5f * (difference * difference));
        sum += weight * at.value(offset);
        total += weight;
    }
    return sum / total; // at least 1, the pixel's own weight
}

// program(neighbourhood, half width) -> value, at every valid pixel.
template <int C, class Program>
void filter_pixels(Pass& pass, const Target& source, const Target& guide, const Target& half_width, Target& destination,
                   Axis axis, const Program& program) {
    const int width = source.width(), height = source.height();
    const Image<glm::vec<C, float>> values = plane_of<C>(source);
    const Image<vec1> guides = plane_of<1>(guide), widths = plane_of<1>(half_width);
    const std::int64_t tap_bytes = info(source.format()).bytes + info(guide.format()).bytes;
    detail::for_each_row(pass, height, [&](int y, PassCounters& counters) {
        std::vector<float> row(static_cast<size_t>(width * C));
        std::int64_t taps = 0;
        for (int x = 0; x < width; ++x) {
            Neighbourhood<C> at{&values(x, y), &guides(x, y), axis == Axis::Rows ? 1 : width,
                                axis == Axis::Rows ? x : y, axis == Axis::Rows ? width - 1 - x : height - 1 - y};
            const glm::vec<C, float> value = std::isfinite(at.guide()) ? program(at, widths(x, y).x) : at.value();
            for (int c = 0; c < C; ++c) row[static_cast<size_t>(x * C + c)] = value[c];
            taps += at.fetches;
        }
        detail::store_row(destination, y, 0, row.data());
        detail::count_fragments(counters, width, taps, tap_bytes, info(destination.format()).bytes);
        counters.texels_fetched += taps + width; // the guides, and the pixel's half width
        counters.bytes_read += width * info(half_width.format()).bytes;
    });
}

// The same for however many channels the source has.
template <class Program>
void filter_image(Pass& pass, const Target& source, const Target& guide, const Target& half_width, Target& destination,
                  Axis axis, const Program& program) {
    for ([[maybe_unused]] const Target* other : {&guide, &half_width, static_cast<const Target*>(&destination)})
        assert(other->width() == source.width() && other->height() == source.height());
    assert(info(destination.format()).channels == info(source.format()).channels);
    switch (info(source.format()).channels) {
    case 1:
        return filter_pixels<1>(pass, source, guide, half_width, destination, axis, program);
    case 2:
        return filter_pixels<2>(pass, source, guide, half_width, destination, axis, program);
    default:
        return filter_pixels<4>(pass, source, guide, half_width, destination, axis, program);
    }
}

} // namespace

void mean_filter(Pass& pass, const Target& source, const Target& guide, const Target& half_width, Target& destination,
                 const MeanFilter& filter) {
    filter_image(pass, source, guide, half_width, destination, filter.axis,
                 [&](auto& at, float width) { return mean(at, width, filter); });
}

void bilateral_filter(Pass& pass, const Target& source, const Target& guide, const Target& half_width,
                      Target& destination, const BilateralFilter& filter) {
    assert(filter.taps >= 3 && filter.taps % 2 == 1);
    const std::vector<float> weights = spatial_weights(filter);
    filter_image(pass, source, guide, half_width, destination, filter.axis,
                 [&](auto& at, float width) { return bilateral(at, width, weights, filter.sigma_range); });
}

} // namespace gnomon
