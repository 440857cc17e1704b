#include "techniques/revectorize/edt_penumbra.h"

#include "raster/passes/edge_aware.h"
#include "raster/passes/jump_flooding.h"
#include "raster/passes/rows.h"

namespace gnomon {
ShadowImage shadow_image(Frame& frame, const Light& light, const EdtParams& params, const Image<float>& hard) {
    const int width = frame.width(), height = frame.height();
    ShadowImage image = {hard, frame.target(Format::R32F, width, height), Image<std::uint8_t>(width, height)};
    const float n = frame.camera().near_plane, f = frame.camera().far_plane;
    Pass pass = frame.pass("depths");
    detail::for_each_row(pass, height, [&](int y, PassCounters& counters) {
        for (int x = 0; x < width; ++x) {
            const Receiver& receiver = frame.receivers()(x, y);
            const float d = frame.gbuffer().depth(x, y);
            image.depth.row<float>(y)[x] = receiver.valid() ? scaled_depth(params.depth_scale, d, n, f) : infinity;
            image.looked_up(x, y) = receiver.valid() && !(params.facing_test && !faces_light(receiver, light));
        }
        constexpr std::int64_t gbuffer_bytes = 2 * sizeof(vec3) + sizeof(float);
        detail::count_fragments(counters, width, width, gbuffer_bytes, sizeof(float) + 1);
    });
    return image;
}

namespace {

// Whether pixel (x, y) is a seed; counts the neighbours that it reads.
bool is_seed(const EdtParams& params, const ShadowImage& image, int x, int y, std::int64_t& fetched) {
    const int width = image.hard.width(), height = image.hard.height();
    const float depth = image.depth.row<float>(y)[x], hard = image.hard(x, y);
    if (!std::isfinite(depth)) return false;
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height - 1); ++j)
        for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width - 1); ++i) {
            ++fetched;
            if (image.hard(i, j) == hard || !image.looked_up(i, j)) continue;
            if (!params.edge_tests || std::abs(image.depth.row<float>(j)[i] - depth) <= params.seed_threshold)
                return true;
        }
    return false;
}

// Where a pixel's distance is measured from.
vec3 place(const Frame& frame, DistanceSpace space, const mat4& to_clip, int x, int y) {
    const vec3 p = frame.receivers()(x, y).position;
    if (space == DistanceSpace::World) return p;
    if (space == DistanceSpace::Clip) return vec3(transform(to_clip, p));
    return {static_cast<float>(x), static_cast<float>(y), 0.0f};
}

// The seed nearest in the world, by trying all; ties go to the lower row, then the smaller column.
Image<Site> nearest_in_world(Pass& pass, const Frame& frame, const Image<std::uint8_t>& seeds) {
    std::vector<Site> all;
    for (int y = 0; y < seeds.height(); ++y)
        for (int x = 0; x < seeds.width(); ++x)
            if (seeds(x, y)) all.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)});
    Image<Site> sites(seeds.width(), seeds.height());
    detail::for_each_row(pass, seeds.height(), [&](int y, PassCounters& counters) {
        for (int x = 0; x < seeds.width(); ++x) {
            const Receiver& receiver = frame.receivers()(x, y);
            if (!receiver.valid()) continue;
            float least = infinity;
            for (const Site& site : all) {
                const vec3 away = frame.receivers()(site.x, site.y).position - receiver.position;
                if (glm::dot(away, away) < least) least = glm::dot(away, away), sites(x, y) = site;
            }
            counters.texels_fetched += static_cast<std::int64_t>(all.size());
        }
    });
    return sites;
}

} // namespace

Image<std::uint8_t> silhouette_seeds(Frame& frame, const EdtParams& params, const ShadowImage& image) {
    const int width = frame.width();
    Image<std::uint8_t> seeds(width, frame.height());
    Pass pass = frame.pass("seeds");
    detail::for_each_row(pass, frame.height(), [&](int y, PassCounters& counters) {
        std::int64_t fetched = 0;
        for (int x = 0; x < width; ++x) seeds(x, y) = is_seed(params, image, x, y, fetched);
        constexpr std::int64_t texel_bytes = 2 * sizeof(float); // hard shadow and depth
        detail::count_fragments(counters, width, fetched, texel_bytes, 1);
    });
    return seeds;
}

Image<Site> nearest_silhouette(Frame& frame, const EdtParams& params, const Image<std::uint8_t>& seeds) {
    Pass pass = frame.pass("distance transform");
    if (params.nearest == NearestSeed::World) return nearest_in_world(pass, frame, seeds);
    return params.transform == SeedTransform::Exact ? nearest_seeds(pass, seeds) : jump_flooding(pass, seeds);
}

Image<float> silhouette_distances(Frame& frame, const EdtParams& params, const ShadowImage& image,
                                  const Image<Site>& sites) {
    const Camera& camera = frame.camera();
    const mat4 to_clip(projection_matrix(camera, frame.aspect()) * view_matrix(camera));
    Image<float> distances(frame.width(), frame.height(), infinity);
    Pass pass = frame.pass("distances");
    full_screen(pass, distances, [&](Pixel& pixel) {
        const Site site = sites(pixel.x, pixel.y);
        const float depth = image.depth.row<float>(pixel.y)[pixel.x];
        pixel.counters.texels_fetched += 2;
        pixel.counters.bytes_read += std::int64_t{sizeof(Site) + sizeof(float)};
        if (!site.exists() || !std::isfinite(depth)) return infinity;
        pixel.counters.texels_fetched += 2;
        pixel.counters.bytes_read += std::int64_t{2 * sizeof(vec3) + sizeof(float)};
        if (!image.looked_up(site.x, site.y)) return infinity;
        if (params.edge_tests &&
            !(std::abs(image.depth.row<float>(site.y)[site.x] - depth) <= params.penumbra_threshold))
            return infinity;
        return glm::length(place(frame, params.distance, to_clip, pixel.x, pixel.y) -
                           place(frame, params.distance, to_clip, site.x, site.y));
    });
    return distances;
}

namespace {

// Half the mean's width in pixels. (4.4), (4.5)
Target mean_half_widths(Frame& frame, const EdtParams& params) {
    const Camera& camera = frame.camera();
    const double screen = z_screen(static_cast<double>(camera.vertical_fov), params.field_in_degrees);
    const float scale = params.mean_scale > 0 ? params.mean_scale : author_units(frame.scene(), 50.0f);
    const double resolution = params.mean_width == MeanWidth::Resolution ? frame.height() / 720.0 : 1.0;
    const auto half = static_cast<float>(0.5 * params.kernel * screen * static_cast<double>(scale) * resolution);
    Target widths = frame.target(Format::R32F, frame.width(), frame.height());
    Pass pass = frame.pass("mean width");
    const bool constant = params.mean_width == MeanWidth::Fixed || camera.orthographic;
    detail::for_each_row(pass, frame.height(), [&](int y, PassCounters& counters) {
        for (int x = 0; x < frame.width(); ++x)
            widths.row<float>(y)[x] =
                constant ? 0.5f * static_cast<float>(params.kernel) : half / frame.gbuffer().depth(x, y);
        detail::count_fragments(counters, frame.width(), frame.width(), sizeof(float), sizeof(float));
    });
    return widths;
}

} // namespace

void mean_over_surface(Frame& frame, const EdtParams& params, const ShadowImage& image, Image<float>& intensities) {
    if (params.kernel == 0) return;
    const int width = frame.width(), height = frame.height();
    const Target widths = mean_half_widths(frame, params);
    Target source = frame.target(Format::R32F, width, height), rows = frame.target(Format::R32F, width, height);
    for (int y = 0; y < height; ++y) std::copy_n(intensities.row(y).data(), width, source.row<float>(y));
    Pass pass = frame.pass("mean");
    MeanFilter filter = {.axis = Axis::Rows,
                         .threshold = params.edge_tests ? params.mean_threshold : infinity,
                         .from_edge = params.mean_taps == MeanTaps::FromEdge};
    mean_filter(pass, source, image.depth, widths, rows, filter);
    filter.axis = Axis::Columns;
    mean_filter(pass, rows, image.depth, widths, source, filter);
    for (int y = 0; y < height; ++y) std::copy_n(source.row<float>(y), width, intensities.row(y).data());
}

} // namespace gnomon
