#include "techniques/map/shadow_map.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/parallel.h"
#include "raster/draw.h"

namespace gnomon {

ShadowMap draw_shadow_map(Frame& frame, const Light& light, const ShadowMapParams& params) {
    constexpr std::array<Format, 3> formats = {Format::D32F, Format::D24, Format::D16};
    std::vector<LightView> views = light_views(frame, light, {params.projection, params.near_plane, params.size});
    const int layers = static_cast<int>(views.size());
    ShadowMap map{{params, std::move(views)},
                  frame.target(formats[static_cast<size_t>(params.format)], params.size, params.size, layers)};

    Pass pass = frame.pass("shadow map");
    PipelineState state;
    state.depth = {.test = Compare::Less, .write = true};
    state.polygon_offset = {params.slope_bias, params.units_bias};
    const std::vector<vec3>& positions = frame.scene().positions;
    const Geometry geometry = {static_cast<std::uint32_t>(positions.size()), frame.casters()};
    for (int layer = 0; layer < layers; ++layer) {
        const mat4& to_clip = map.views[static_cast<size_t>(layer)].to_clip;
        draw(
            pass, geometry, state, [&](std::uint32_t i) { return transform(to_clip, positions[i]); }, depth_only,
            Targets{.depth = &map.depth, .layer = layer, .clear_depth = 1.0f});
    }
    return map;
}

namespace {

// How the window depth of the receiver's plane changes per texel. In a perspective view 1/distance is affine on the
// map, in an orthographic one the distance itself is.
vec2 plane_gradient(const LightView& view, int size, const Receiver& receiver) {
    const dvec3 n(receiver.geometric_normal);
    const dvec2 across(glm::dot(n, view.right), glm::dot(n, view.up));
    const double range = view.far_plane - view.near_plane;
    const double texel = 2.0 * view.half_extent / size; // metres, at distance 1 for a perspective view
    if (view.orthographic) return vec2(across * (-texel / (glm::dot(n, view.forward) * range)));
    const double offset = glm::dot(n, dvec3(receiver.position) - view.origin); // negative: the receiver faces the light
    return vec2(across * (-view.far_plane * view.near_plane / range * texel / offset));
}

} // namespace

MapPoint map_point(const LightMap& map, const Light& light, const Receiver& receiver, bool receiver_plane) {
    MapPoint point;
    if (map.params.facing_test && !faces_light(receiver, light)) {
        point.dark = true;
        return point;
    }
    vec3 p = receiver.position;
    point.layer = view_of(map.views, p);
    const LightView& view = map.views[static_cast<size_t>(point.layer)];
    if (map.params.normal_offset > 0) {
        const double texel = view.width_at(view.distance(p)) / map.params.size;
        const double cosine = static_cast<double>(glm::dot(receiver.geometric_normal, direction_to_light(light, p)));
        const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
        p += receiver.geometric_normal *
             static_cast<float>(static_cast<double>(map.params.normal_offset) * texel * sine);
    }
    point.position = p;
    const vec4 clip = transform(view.to_clip, p);
    if (!(clip.w > 0)) {
        point.lit = true;
        return point;
    }
    const float oow = 1.0f / clip.w;
    const float half = 0.5f * static_cast<float>(map.params.size);
    point.texel = vec2(clip.x * oow * half + half, clip.y * oow * half + half);
    point.depth = std::min(clip.z * oow * 0.5f + 0.5f, 1.0f) - map.params.constant_bias;
    if (receiver_plane) {
        point.gradient = plane_gradient(view, map.params.size, receiver);
        // A plane seen edge-on has no depth to follow.
        if (!(glm::abs(point.gradient.x) < 1.0f && glm::abs(point.gradient.y) < 1.0f)) point.gradient = vec2(0.0f);
    }
    return point;
}

MapTap tap_outside(const LightMap& map, int layer, int x, int y, float depth) {
    const int size = map.params.size;
    if (map.views.size() == 1) return {false, layer, x, y, depth};
    // The point at the tap's direction and depth, projected on the face that it belongs to.
    const LightView& view = map.views[static_cast<size_t>(layer)];
    const double n = view.near_plane, f = view.far_plane;
    const auto coordinate = [&](int i) { return ((i + 0.5) / size * 2.0 - 1.0) * view.half_extent; };
    const double distance = f * n / (f - std::clamp(static_cast<double>(depth), 0.0, 1.0) * (f - n));
    const dvec3 offset = (view.forward + view.right * coordinate(x) + view.up * coordinate(y)) * distance;
    const int other_layer = cube_face(offset);
    const LightView& other = map.views[static_cast<size_t>(other_layer)];
    const double other_distance = glm::dot(offset, other.forward);
    const auto texel = [&](const dvec3& axis) {
        const double ndc = glm::dot(offset, axis) / (other_distance * other.half_extent);
        return std::clamp(static_cast<int>(std::floor((ndc * 0.5 + 0.5) * size)), 0, size - 1);
    };
    return {true, other_layer, texel(other.right), texel(other.up),
            static_cast<float>(std::min(1.0, f / (f - n) * (1.0 - n / other_distance)))};
}

namespace {

int floor_of(float coordinate) { // without a call
    const int whole = static_cast<int>(coordinate);
    return whole - (coordinate < static_cast<float>(whole));
}

// The columns of a kernel's taps, and what the receiver's plane adds to the depth there.
struct TapColumns {
    static constexpr int most = 64;
    std::array<int, most> x;
    std::array<float, most> slope;
    int least = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min(); // of the columns
    bool consecutive = true;

    TapColumns(const MapPoint& point, int n, float reach) {
        for (int u = 0; u < n; ++u) {
            const auto i = static_cast<size_t>(u);
            x[i] = floor_of(point.texel.x + kernel_cell(u, n) * reach);
            slope[i] = point.gradient.x * (static_cast<float>(x[i]) + 0.5f - point.texel.x);
            least = std::min(least, x[i]), last = std::max(last, x[i]);
            consecutive &= x[i] == x[0] + u;
        }
    }
};

// How many of a row's taps are lit; all texels are there.
int lit_taps(const ShadowMap& map, const MapPoint& point, const TapColumns& columns, int n, int y) {
    const float up = point.gradient.y * (static_cast<float>(y) + 0.5f - point.texel.y);
    int lit = 0;
    const auto count = [&](const auto& stored) {
        for (int u = 0; u < n; ++u) {
            const float depth = std::min(1.0f, point.depth + (columns.slope[static_cast<size_t>(u)] + up));
            lit += depth <= stored(u) ? 1 : 0;
        }
    };
    if (columns.consecutive && map.depth.format() == Format::D32F) {
        const float* row = map.depth.row<float>(y, point.layer) + columns.x[0];
        count([row](int u) { return row[u]; });
    } else {
        count([&](int u) { return map.depth.depth(columns.x[static_cast<size_t>(u)], y, point.layer); });
    }
    return lit;
}

} // namespace

float percentage_closer(const ShadowMap& map, const MapPoint& point, int n, vec2 reach, PassCounters& counters) {
    assert(n >= 1 && n <= TapColumns::most);
    const TapColumns columns(point, n, reach.x);
    const int size = map.params.size;
    const bool inside = columns.least >= 0 && columns.last < size;
    int lit = 0;
    for (int v = 0; v < n; ++v) {
        const int y = floor_of(point.texel.y + kernel_cell(v, n) * reach.y);
        if (inside && y >= 0 && y < size) {
            lit += lit_taps(map, point, columns, n, y);
            count_texels(map.depth, n, counters);
            continue;
        }
        for (int u = 0; u < n; ++u) {
            const int x = columns.x[static_cast<size_t>(u)];
            lit += shadow_test(map, point.layer, x, y, point.depth_at(x, y), counters) > 0.0f;
        }
    }
    return static_cast<float>(lit) / static_cast<float>(n * n);
}

float mean_of_tests(const ShadowMap& map, const MapPoint& point, std::span<const vec2> offsets,
                    PassCounters& counters) {
    int lit = 0;
    for (const vec2 offset : offsets) {
        const ivec2 texel(glm::floor(point.texel + offset));
        lit += shadow_test(map, point.layer, texel.x, texel.y, point.depth_at(texel.x, texel.y), counters) > 0.0f;
    }
    return static_cast<float>(lit) / static_cast<float>(offsets.size());
}

float mean_of_bilinear_tests(const ShadowMap& map, const MapPoint& point, std::span<const vec2> offsets,
                             PassCounters& counters) {
    float sum = 0.0f;
    for (const vec2 offset : offsets) {
        const vec2 corner = point.texel + offset - 0.5f, low = glm::floor(corner), f = corner - low;
        const ivec2 texel(low);
        const float depth = std::min(1.0f, point.depth + (point.gradient.x * offset.x + point.gradient.y * offset.y));
        const auto test = [&](int x, int y) {
            const int i = texel.x + x, j = texel.y + y, size = map.params.size;
            // On another face of a cube the depth of this one's place would be another.
            const bool here = i >= 0 && j >= 0 && i < size && j < size;
            return shadow_test(map, point.layer, i, j, here ? depth : point.depth_at(i, j), counters);
        };
        const float lower = test(0, 0) * (1.0f - f.x) + test(1, 0) * f.x;
        const float upper = test(0, 1) * (1.0f - f.x) + test(1, 1) * f.x;
        sum += lower * (1.0f - f.y) + upper * f.y;
    }
    return sum / static_cast<float>(offsets.size());
}

Image<float> show_depth(const Target& depth, int layer) {
    Image<float> shown(depth.width(), depth.height());
    const auto height = static_cast<size_t>(depth.height());
    constexpr size_t grain = 64; // rows
    std::vector<float> least(chunk_count(height, grain), 1.0f);
    parallel_for(height, grain, [&](size_t begin, size_t end) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
            for (int x = 0; x < depth.width(); ++x) {
                shown(x, y) = depth.depth(x, y, layer);
                least[begin / grain] = std::min(least[begin / grain], shown(x, y));
            }
    });
    const float black = *std::min_element(least.begin(), least.end());
    if (!(black < 1.0f)) return shown;
    parallel_for(shown.size(), grain * 1024, [&](size_t begin, size_t end) {
        for (float& value : shown.values().subspan(begin, end - begin)) value = (value - black) / (1.0f - black);
    });
    return shown;
}

} // namespace gnomon
