#include "techniques/moments/moment_map.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/error.h"
#include "raster/passes/filter.h"
#include "raster/passes/mip.h"

namespace gnomon {
namespace {

float blur_sigma(const MomentMapParams& params) {
    return params.sigma > 0 ? params.sigma : static_cast<float>(params.kernel) / 6.0f;
}

std::vector<float> blur_weights(const MomentMapParams& params) {
    switch (params.blur) {
    case BlurShape::Box:
        return box_weights(params.kernel);
    case BlurShape::Gaussian:
        return gaussian_weights(params.kernel, static_cast<double>(blur_sigma(params)));
    default:
        return binomial_weights(params.kernel);
    }
}

// Largest standard deviation in texels of a look-up of that width along an axis: w²/12 of a box, and f(1 − f) w² more
// between the centres of texels as wide.
float deviation_of(const MomentMapParams& params, float width) {
    const auto kernel = static_cast<float>(params.kernel);
    float variance = width * width / (params.prefilter == Prefilter::Sat ? 12.0f : 3.0f);
    if (params.prefilter == Prefilter::Blur)
        variance += params.blur == BlurShape::Box        ? kernel * kernel / 12.0f
                    : params.blur == BlurShape::Gaussian ? blur_sigma(params) * blur_sigma(params)
                                                         : (kernel - 1.0f) / 4.0f;
    return std::sqrt(variance);
}

// Fraction bits with which a box of `widest` + 1 texels a side, border texels whole, stays below 2³².
int wrapping_bits(int widest) {
    const double side = widest + 1;
    return std::clamp(static_cast<int>(std::floor(32.0 - 2.0 * std::log2(side))), 0, 31);
}

template <class T>
std::vector<SummedArea<T>> summed_layers(Frame& frame, const Target& map, int fraction_bits, float offset = 0.0f) {
    Pass pass = frame.pass("summed area");
    std::vector<SummedArea<T>> tables;
    for (int layer = 0; layer < map.layers(); ++layer)
        tables.push_back(summed_area<T>(
            pass, map,
            {.offset = offset, .fraction_bits = fraction_bits, .layer = layer, .meter = frame.log().memory}));
    return tables;
}

// Side in texels of what the pixel covers on the map: the longer of the ways from the receiver to where its plane is
// seen by the pixels to the right and above. [Donnelly and Lauritzen 2006, 4.2; OpenGL 4.6, eq. 8.7]
float footprint_of(const Frame& frame, const LightView& view, int size, const Receiver& receiver, ivec2 pixel) {
    const dvec3 origin(receiver.position), normal(receiver.geometric_normal);
    const auto texel = [&](dvec3 p) {
        const vec4 clip = transform(view.to_clip, vec3(p));
        return dvec2(clip.x, clip.y) / static_cast<double>(clip.w) * (0.5 * size);
    };
    double longest = 0;
    for (const ivec2 step : {ivec2(1, 0), ivec2(0, 1)}) {
        const CameraRay ray =
            camera_ray(frame.camera(), pixel.x + step.x + 0.5, pixel.y + step.y + 0.5, frame.width(), frame.height());
        const double along = glm::dot(normal, ray.direction), distance = glm::dot(normal, origin - ray.origin);
        const double length = distance / along;
        if (!(length > 0) || !std::isfinite(length)) return static_cast<float>(size);
        const double way = glm::length(texel(ray.origin + ray.direction * length) - texel(origin));
        longest = std::max(longest, way == way ? way : size);
    }
    return static_cast<float>(std::min(longest, static_cast<double>(size)));
}

// Linear depth per texel along the receiver's plane, from window depth per texel.
vec2 linear_gradient(const LightView& view, const MapPoint& point) {
    if (view.orthographic) return point.gradient;
    const double distance = view.distance(point.position);
    return point.gradient * static_cast<float>(distance * distance / (view.near_plane * view.far_plane));
}

} // namespace

MomentMap moment_map(const Frame& frame, const Light& light, const MomentMapParams& params) {
    const int gutter = params.kernel / 2 + 1; // the filter, and the bilinear look-up
    MomentMap map{{params, light_views(frame, light, {params.projection, params.near_plane, params.size, gutter})},
                  params};
    if (map.views.size() > 1 && 2 * gutter >= params.size)
        throw UsageError(fmt::format("a filter of kernel={} does not fit on cube faces of size={}; use a size above {}",
                                     params.kernel, params.size, 2 * gutter));
    return map;
}

void blur_map(Frame& frame, Target& moments, const MomentMapParams& params, float log_warp) {
    if (params.kernel == 1) return;
    const std::vector<float> weights = blur_weights(params);
    Pass pass = frame.pass("blur");
    Target rows = frame.target(moments.format(), moments.width(), moments.height(), moments.layers());
    if (log_warp > 0) {
        convolve_rows_log(pass, moments, rows, weights, log_warp);
        convolve_columns_log(pass, rows, moments, weights, log_warp);
    } else {
        convolve_rows(pass, moments, rows, weights);
        convolve_columns(pass, rows, moments, weights);
    }
}

FilteredMap filter_map(Frame& frame, Target moments, const MomentMapParams& params, int widest) {
    FilteredMap map;
    if (params.prefilter == Prefilter::Sat) {
        const int bits = wrapping_bits(std::max(widest, params.kernel));
        switch (params.sums) {
        case SumKind::Float:
            map.sums = summed_layers<float>(frame, moments, 0, params.sum_offset);
            break;
        case SumKind::Double:
            map.sums = summed_layers<double>(frame, moments, 0);
            break;
        case SumKind::Uint32:
            map.sums = summed_layers<std::uint32_t>(frame, moments, bits);
            break;
        case SumKind::Int64:
            map.sums = summed_layers<std::int64_t>(frame, moments, 30);
            break;
        }
        map.levels.push_back(std::move(moments));
        return map;
    }
    if (params.prefilter == Prefilter::Blur) blur_map(frame, moments, params);
    if (params.prefilter == Prefilter::Blur && !params.footprint) {
        map.levels.push_back(std::move(moments));
        return map;
    }
    Pass pass = frame.pass("mip map");
    map.levels = mip_chain(pass, std::move(moments), frame.log().memory);
    return map;
}

vec4 filtered_mean(const FilteredMap& map, vec2 texel, float width, int layer, PassCounters& counters) {
    const Target& base = map.levels[0];
    if (!std::holds_alternative<std::monostate>(map.sums)) {
        const dvec2 center(texel), half(0.5 * static_cast<double>(width));
        return std::visit(
            [&](const auto& tables) {
                if constexpr (std::is_same_v<std::decay_t<decltype(tables)>, std::monostate>)
                    return vec4(0.0f);
                else
                    return vec4(box_mean(tables[static_cast<size_t>(layer)], center - half, center + half, counters));
            },
            map.sums);
    }
    const Sampler bilinear = {.filter = Filter::Linear, .wrap = Wrap::Clamp};
    const vec2 uv = texel / vec2(static_cast<float>(base.width()), static_cast<float>(base.height()));
    const float level = std::min(std::log2(std::max(width, 1.0f)), static_cast<float>(map.levels.size() - 1));
    const auto below = static_cast<size_t>(level);
    const vec4 fine = sample(map.levels[below], bilinear, uv, counters, layer);
    const float between = level - static_cast<float>(below);
    if (between == 0.0f) return fine;
    return fine + (sample(map.levels[below + 1], bilinear, uv, counters, layer) - fine) * between;
}

std::variant<float, MomentPoint> moment_point(const Frame& frame, const Light& light, const MomentMap& map,
                                              const Receiver& receiver, ivec2 pixel) {
    const MomentMapParams& params = map.filter;
    const bool plane = params.plane_bias > 0;
    const MapPoint point = map_point(map, light, receiver, plane);
    if (point.lit || point.dark) return point.lit ? 1.0f : 0.0f;
    const auto size = static_cast<float>(params.size);
    if (!(point.texel.x >= 0 && point.texel.y >= 0 && point.texel.x <= size && point.texel.y <= size))
        return params.border == Border::Lit ? 1.0f : 0.0f;
    const LightView& view = map.views[static_cast<size_t>(point.layer)];
    const auto kernel = static_cast<float>(params.kernel);
    MomentPoint at{point.texel, params.prefilter == Prefilter::Blur ? 1.0f : kernel, point.layer,
                   std::min(view.linear_depth(point.position), 1.0f) - params.constant_bias};
    if (params.footprint) at.width = std::max(at.width, footprint_of(frame, view, params.size, receiver, pixel));
    if (plane) {
        const vec2 slope = glm::abs(linear_gradient(view, point));
        at.t -= params.plane_bias * (slope.x + slope.y) * deviation_of(params, at.width);
    }
    return at;
}

void show_channels(Visibility& visibility, const std::string& name, const Target& map) {
    const int channels = info(map.format()).channels;
    std::vector<Image<float>> shown;
    for (int c = 0; c < channels; ++c) shown.emplace_back(map.width(), map.height());
    parallel_for(static_cast<size_t>(map.height()), 16, [&](size_t begin, size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < map.width(); ++x) {
                const vec4 texel = map.load(x, y);
                for (int c = 0; c < channels; ++c) shown[static_cast<size_t>(c)](x, y) = texel[c];
            }
    });
    for (int c = 0; c < channels; ++c)
        visibility.debug.push_back({fmt::format("{}-{}", name, c + 1), std::move(shown[static_cast<size_t>(c)])});
}

void show_filtered(Visibility& visibility, const FilteredMap& map, const MomentMapParams& params) {
    if (std::holds_alternative<std::monostate>(map.sums)) {
        const auto level = params.prefilter == Prefilter::Mip ? std::log2(static_cast<float>(params.kernel)) : 0.0f;
        show_channels(visibility, "filtered", map.levels[std::min(static_cast<size_t>(level), map.levels.size() - 1)]);
        return;
    }
    const auto show = [&](const auto& table) {
        for (int c = 0; c < table.channels; ++c) {
            Image<float> shown(table.width, table.height);
            for (int y = 0; y < table.height; ++y)
                for (int x = 0; x < table.width; ++x)
                    shown(x, y) = static_cast<float>(static_cast<double>(table.sum(x, y, c)) * table.unit);
            visibility.debug.push_back({fmt::format("sums-{}", c + 1), std::move(shown)});
        }
    };
    std::visit(
        [&](const auto& tables) {
            if constexpr (!std::is_same_v<std::decay_t<decltype(tables)>, std::monostate>) show(tables[0]);
        },
        map.sums);
}

void require_float_sums(const MomentMapParams& params, const char* technique) {
    if (params.prefilter == Prefilter::Sat && (params.sums == SumKind::Uint32 || params.sums == SumKind::Int64))
        throw UsageError(
            fmt::format("technique '{}' sums exponentials, which fixed point cannot hold; use sums=float or "
                        "sums=double",
                        technique));
}

} // namespace gnomon
