// Crossings counted by edges, beside crossings of all triangles one by one.

#include <catch2/catch.hpp>

#include <memory>
#include <numeric>
#include <optional>
#include <set>

#include "raytrace/crossings.h"
#include "tests/raytrace/torus.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

// What a receiver's view of an outline gives for points of the light, in packets of sixteen.
struct Counted {
    std::vector<vec3> ways; // of the rays
    PointCounts counts;
    bool usable = false;
    std::set<std::size_t> left_out{}; // triangles that are not clear
};

std::unique_ptr<Counted> count_from(const Scene& scene, const Light& light, const Receiver& receiver,
                                    std::uint32_t seed) {
    auto counted = std::make_unique<Counted>();
    const EmbreeScene rays(scene);
    const TriangleClusters clusters = build_clusters(scene);
    const ShadowOrigin origin = rays.shadow_origin(receiver);
    const BlockView view = block_view(light, Bounds{origin.position, origin.position}, origin.world_rounding);
    std::vector<std::uint32_t> all(clusters.clusters.size());
    std::iota(all.begin(), all.end(), 0u);
    const std::optional<Outline> outline = find_outline(view, clusters, all, clusters.triangle_count);
    const Pyramid pyramid = pyramid_of(light, receiver, origin, rays.corners(receiver.triangle));
    if (!view.usable || !outline || !pyramid.usable) return counted;
    const auto constant = static_cast<std::size_t>(outline->first_constant());
    std::vector<std::int32_t> states(constant + 3);
    states[constant] = 1, states[constant + 1] = -1;
    for (std::size_t c = 0; c < outline->triangles.size(); ++c) {
        const TriangleCluster& cluster = outline->triangles[c];
        const ClusterSides sides = silhouette_kernels().sides(view, cluster, &states[cluster_size * c]);
        for (unsigned i = 0; i < cluster.count; ++i)
            if (((sides.clear & ~sides.absent) >> i & 1) == 0) counted->left_out.insert(cluster.triangle[i]);
    }
    EdgeImages images;
    images.resize(outline->edges);
    counted->usable = crossing_kernels().project(pyramid, *outline, states.data(), images);
    const PreparedPattern pattern = prepare_pattern(Pattern::Sobol, PointBlock::points, SampleOrder::Packed);
    std::vector<float> u(PointBlock::points), v(u), x(u), y(u), z(u);
    fill_pattern(pattern, seed, 0, u, v);
    light_points(light, receiver.position, u, v, x, y, z);
    PointBlock block;
    point_kernels().aim(pyramid, x.data(), y.data(), z.data(), PointBlock::packets, block);
    crossing_kernels().count(pyramid, images, block, PointBlock::packets, counted->counts);
    for (std::size_t i = 0; i < PointBlock::points; ++i)
        counted->ways.emplace_back(block.way[0][i], block.way[1][i], block.way[2][i]);
    return counted;
}

// In double, of the triangles that are not left out.
int crossings_of(const Scene& scene, const std::set<std::size_t>& left_out, dvec3 origin, dvec3 way) {
    int crossings = 0;
    for (std::size_t t = 0; t < scene.triangles.size(); ++t) {
        const uvec3 corners = scene.triangles[t];
        const dvec3 a = dvec3(scene.positions[corners.x]) - origin, b = dvec3(scene.positions[corners.y]) - origin,
                    c = dvec3(scene.positions[corners.z]) - origin;
        const double u = glm::dot(glm::cross(a, b), way), v = glm::dot(glm::cross(b, c), way),
                     w = glm::dot(glm::cross(c, a), way), sum = u + v + w;
        if (!((u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0)) || sum == 0) continue;
        const double at = glm::dot(glm::cross(a, b), c) / sum;
        crossings += at > 0 && at < 1 && !left_out.contains(t);
    }
    return crossings;
}

} // namespace

TEST_CASE("crossings are counted but for a constant, by edges alone", "[raytrace][silhouettes][crossings]") {
    Numbers numbers(21);
    int receivers = 0, sure = 0, unsure = 0, changes = 0;
    for (int round = 0; round < 24; ++round) {
        Scene scene = on_floor();
        TorusShape shape;
        shape.around = 20 + numbers.below(30), shape.across = 8 + numbers.below(20);
        if (round % 3 == 1) shape.end = shape.around / 2; // with a rim
        if (round % 3 == 2) shape.flipped = 37;           // sides that do not fit
        if (shape.end > shape.around) shape.end = shape.around;
        add_torus(scene, shape);
        const LightType type = round % 2 ? LightType::Rectangle : LightType::Disk;
        const Light light = lamp(numbers, type, 0.5f + 3 * numbers.unit());
        // Where the torus is in between.
        const vec3 way = shape.center + numbers.in_box(0.7f) - light.position;
        const vec3 at = light.position - way * (light.position.y / way.y);
        const Receiver receiver{{at.x, 0, at.z}, {0, 1, 0}, at.x > at.z ? 1u : 0u};
        const std::unique_ptr<Counted> counted = count_from(scene, light, receiver, numbers.below(1000));
        if (!counted->usable) continue;
        ++receivers;
        const vec3 origin = EmbreeScene(scene).shadow_origin(receiver).position;
        std::optional<int> constant;
        int highest = 0;
        for (std::size_t i = 0; i < counted->ways.size(); ++i) {
            const bool is_unsure = counted->counts.unsure[i / 16] >> (i % 16) & 1;
            (is_unsure ? unsure : sure) += 1;
            if (is_unsure) continue;
            const int crossings = crossings_of(scene, counted->left_out, origin, counted->ways[i]);
            const int difference = crossings - counted->counts.crossings[i];
            if (!constant) constant = difference;
            REQUIRE(difference == *constant);
            highest = std::max(highest, crossings);
        }
        changes += highest > 0;
    }
    INFO(receivers << " receivers, " << sure << " sure points, " << unsure << " unsure");
    CHECK(receivers >= 20);
    CHECK(changes >= 20);
    CHECK(1000 * unsure < sure);
}
