// Silhouettes let one ray answer for many; wherever a surface ends, folds or turns over, the answer is that of all
// rays.

#include <catch2/catch.hpp>

#include <cmath>
#include <memory>
#include <numeric>
#include <optional>
#include <set>

#include "raytrace/crossings.h"
#include "raytrace/neighbours.h"
#include "tests/raytrace/witness.h"

using namespace gnomon;
using namespace gnomon_tests;

namespace {

constexpr float turn = 6.2831853f;

// A closed bumpy torus, or a part of it: quads [0, end) of `around`, each two triangles. Counter-clockwise from outside
// but for every `flipped`-th quad.
struct TorusShape {
    vec3 center{0, 1.2f, 0};
    float radius = 0.7f, tube = 0.3f, bump = 0.02f;
    int around = 64, across = 32, end = 64, flipped = 0;
};

void add_torus(Scene& scene, const TorusShape& shape) {
    const auto point = [&](int i, int j) {
        const float a = turn * static_cast<float>(i % shape.around) / static_cast<float>(shape.around);
        const float b = turn * static_cast<float>(j % shape.across) / static_cast<float>(shape.across);
        const float tube = shape.tube + shape.bump * std::sin(5 * a) * std::cos(3 * b);
        const float out = shape.radius + tube * std::cos(b);
        return shape.center + vec3(out * std::cos(a), out * std::sin(a), tube * std::sin(b));
    };
    for (int i = 0; i < shape.end; ++i)
        for (int j = 0; j < shape.across; ++j) {
            const vec3 p[4] = {point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)};
            const bool flip = shape.flipped > 0 && (i * shape.across + j) % shape.flipped == 0;
            add_polygon(scene, flip ? std::vector<vec3>{p[0], p[2], p[1]} : std::vector<vec3>{p[0], p[1], p[2]});
            add_polygon(scene, flip ? std::vector<vec3>{p[0], p[3], p[2]} : std::vector<vec3>{p[0], p[2], p[3]});
        }
}

// A block of receivers that are near each other on the floor, which is the first two triangles of a scene.
std::vector<Receiver> floor_block(Numbers& numbers, float spread, int count) {
    std::vector<Receiver> block;
    const vec3 middle = numbers.in_box(3.0f);
    for (int i = 0; i < count; ++i) {
        const vec3 at = middle + numbers.in_box(spread);
        block.push_back({{at.x, 0, at.z}, {0, 1, 0}, at.x > at.z ? 1u : 0u});
    }
    return block;
}

// Near a point of a triangle and on triangles that follow it.
std::vector<Receiver> surface_block(const Scene& scene, Numbers& numbers, int count) {
    return random_receivers(scene, numbers, count);
}

Light lamp(Numbers& numbers, LightType type, float size) {
    Light light = light_at(type, vec3(2, 4, 1) + numbers.in_box(2.0f), vec2(size, size));
    light.direction = glm::normalize(vec3(0, 1, 0) - light.position);
    light.tangent = any_tangent(light.direction);
    return light;
}

Scene on_floor() {
    Scene scene;
    add_floor(scene, -9, 9, -9, 9, 0);
    return scene;
}

void place(Scene& scene, Light& light, float scale, vec3 shift) {
    for (vec3& p : scene.positions) p = p * scale + shift;
    light.position = light.position * scale + shift;
    light.size *= scale;
}

void place(std::vector<Receiver>& block, float scale, vec3 shift) {
    for (Receiver& receiver : block) receiver.position = receiver.position * scale + shift;
}

// Receivers on the floor and on the surface.
Comparison compare(const Scene& scene, const Light& light, Numbers& numbers, int blocks, int samples = 256) {
    Comparison comparison;
    const Witness witness(scene, light, Pattern::Sobol, samples);
    for (int i = 0; i < blocks; ++i) {
        witness.compare(floor_block(numbers, 0.1f, 16), comparison);
        witness.compare(surface_block(scene, numbers, 16), comparison);
    }
    return comparison;
}

std::size_t open_edges(const TriangleClusters& clusters) {
    std::size_t open = 0;
    for (std::size_t c = 0; c < clusters.clusters.size(); ++c)
        for (const auto& over : clusters.neighbours[c].over)
            for (std::uint32_t i = 0; i < clusters.clusters[c].count; ++i) open += over[i] == no_neighbour;
    return open;
}

} // namespace

TEST_CASE("neighbours are found by position and direction", "[raytrace][silhouettes]") {
    Scene closed, part, twice;
    add_torus(closed, {});
    TorusShape half;
    half.end = 32;
    add_torus(part, half);
    add_torus(twice, {});
    add_torus(twice, {});
    CHECK(open_edges(build_clusters(closed)) == 0);
    CHECK(open_edges(build_clusters(part)) == 2 * 32);
    // Four triangles at every edge.
    CHECK(open_edges(build_clusters(twice)) == 3 * twice.triangles.size());
    TorusShape flipped;
    flipped.flipped = 64 * 32; // one quad, whose four sides its neighbours have in the same direction
    Scene turned;
    add_torus(turned, flipped);
    CHECK(open_edges(build_clusters(turned)) == 8);
    const TriangleClusters clusters = build_clusters(closed);
    for (std::uint32_t c = 0; c < clusters.clusters.size(); ++c)
        for (const auto& over : clusters.neighbours[c].over)
            for (std::uint32_t i = 0; i < clusters.clusters[c].count; ++i) {
                const auto& back = clusters.neighbours[over[i] / cluster_size].over;
                const auto place = static_cast<std::uint32_t>(over[i] % cluster_size);
                const std::uint32_t self = c * std::uint32_t(cluster_size) + i;
                CHECK((back[0][place] == self || back[1][place] == self || back[2][place] == self));
            }
}

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

// A block that looks at a finely tessellated surface: of some 260'000 rays some tens of thousands are left.
TEST_CASE("rays are saved beside a fine closed surface", "[raytrace][silhouettes]") {
    Numbers numbers(31);
    Scene scene = on_floor();
    add_sphere(scene, {0, 1.5f, 0}, 0.8f, 64);
    Light light = light_at(LightType::Rectangle, {0.5f, 4, 0.25f}, {2, 2});
    const Comparison comparison = [&] {
        Comparison all;
        const Witness witness(scene, light, Pattern::Sobol, 1024);
        for (int i = 0; i < 24; ++i) witness.compare(floor_block(numbers, 0.05f, 16), all);
        return all;
    }();
    INFO(comparison.rays << " of " << comparison.rays_alone << " rays");
    CHECK(comparison.wrong == 0);
    CHECK(comparison.rays > 0);
    CHECK(5 * comparison.rays < comparison.rays_alone);
}

// A fine plate whose rim is straight above the receivers, and a grid of samples whose middle column is above the rim:
// those rays meet the rim exactly, from either side, or the corners and edges of the triangles at it.
TEST_CASE("samples exactly at an edge are as rays have them", "[raytrace][silhouettes]") {
    for (const float side : {1.0f, -1.0f}) {
        Scene scene = on_floor();
        constexpr int cells = 64;
        const auto corner = [&](int i, int j) {
            return vec3(0.5f + side * static_cast<float>(i) / 16, 2, static_cast<float>(j) / 16 - 2);
        };
        for (int i = 0; i < cells; ++i)
            for (int j = 0; j < cells; ++j) {
                add_polygon(scene, {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1)});
                add_polygon(scene, {corner(i, j), corner(i + 1, j + 1), corner(i, j + 1)});
            }
        Light light = light_at(LightType::Rectangle, {0.5f, 4, 0}, {6, 6});
        light.direction = {0, -1, 0}, light.tangent = {1, 0, 0};
        const Witness witness(scene, light, Pattern::Grid, 31 * 31);
        Comparison comparison;
        for (int k = -4; k < 4; ++k) {
            std::vector<Receiver> block;
            for (int i = 0; i < 8; ++i) {
                const float z = static_cast<float>(k) / 4 + static_cast<float>(i) / 64;
                block.push_back({{0.5f, 0, z}, {0, 1, 0}, 0.5f > z ? 1u : 0u});
            }
            witness.compare(block, comparison);
        }
        INFO("side " << side << ": " << comparison.rays << " of " << comparison.rays_alone << " rays");
        CHECK(comparison.wrong == 0);
        CHECK(3 * comparison.rays < comparison.rays_alone);
    }
}

TEST_CASE("silhouettes give the bits of rays alone for closed surfaces", "[raytrace][silhouettes]") {
    for (const LightType type : {LightType::Rectangle, LightType::Disk, LightType::Sphere}) {
        Numbers numbers(41u + static_cast<std::uint32_t>(type));
        Scene scene = on_floor();
        add_torus(scene, {});
        for (const float size : {0.3f, 1.5f, 5.0f}) {
            const Comparison comparison = compare(scene, lamp(numbers, type, size), numbers, 12);
            INFO(light_type_name(type) << ", size " << size);
            CHECK(comparison.wrong == 0);
            CHECK(comparison.rays < comparison.rays_alone);
        }
    }
}

TEST_CASE("silhouettes give the bits of rays alone where surfaces end or turn over", "[raytrace][silhouettes]") {
    TorusShape part, flipped, mixed, inside;
    part.end = 40;
    flipped.flipped = 97;
    mixed.flipped = 11, mixed.end = 60;
    inside.center = {0.4f, 1.1f, 0.1f}, inside.radius = 0.6f; // passes through another
    const std::vector<std::vector<TorusShape>> scenes = {{part},       {flipped}, {mixed},
                                                         {{}, inside}, {{}, {}},  {part, {}}};
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        Numbers numbers(51u + static_cast<std::uint32_t>(i));
        Scene scene = on_floor();
        for (const TorusShape& shape : scenes[i]) add_torus(scene, shape);
        INFO("scene " << i);
        CHECK(compare(scene, lamp(numbers, LightType::Rectangle, 2.0f), numbers, 16).wrong == 0);
    }
}

// Light falls through the hole only.
TEST_CASE("light through a hole in a sphere is found", "[raytrace][silhouettes]") {
    Scene scene;
    add_sphere(scene, {0, 0, 0}, 1, 48);
    scene.triangles.erase(scene.triangles.begin() + 2000, scene.triangles.begin() + 2024);
    scene.triangle_objects.pop_back();
    scene.triangle_objects.resize(scene.triangles.size());
    const vec3 hole = scene.positions[scene.triangles[1990].x];
    Light light = light_at(LightType::Rectangle, hole * 2.0f, {1, 1});
    light.direction = -glm::normalize(hole);
    light.tangent = any_tangent(light.direction);
    Numbers numbers(61);
    Comparison comparison;
    const Witness witness(scene, light, Pattern::Sobol, 256);
    for (int i = 0; i < 60; ++i) {
        std::vector<Receiver> block = random_receivers(scene, numbers, 16);
        for (Receiver& receiver : block)
            if (glm::dot(receiver.geometric_normal, receiver.position) > 0) receiver.geometric_normal *= -1.0f;
        witness.compare(block, comparison);
    }
    CHECK(comparison.wrong == 0);
    CHECK(comparison.rays < comparison.rays_alone);
}

TEST_CASE("silhouettes give the bits of rays alone at every scale and far away", "[raytrace][silhouettes]") {
    struct Placement {
        float scale;
        vec3 shift;
    };
    for (const Placement& placement :
         {Placement{1e-3f, vec3(0)}, Placement{1e6f, vec3(0)}, Placement{1, vec3(100, -30, 7)},
          Placement{100, vec3(1e5f)}, Placement{1, vec3(1e5f, 0, -1e5f)}}) {
        Numbers numbers(71);
        Scene scene = on_floor();
        add_torus(scene, {});
        Light light = lamp(numbers, LightType::Rectangle, 1.5f);
        place(scene, light, placement.scale, placement.shift);
        Comparison comparison;
        const Witness witness(scene, light, Pattern::Sobol, 256);
        for (int i = 0; i < 16; ++i) {
            std::vector<Receiver> block = floor_block(numbers, 0.1f, 16);
            place(block, placement.scale, placement.shift);
            witness.compare(block, comparison);
            witness.compare(surface_block(scene, numbers, 16), comparison);
        }
        INFO("scale " << placement.scale << ", shift " << placement.shift.x);
        CHECK(comparison.wrong == 0);
    }
}

namespace {

// Tori of any kind, sphere and soup, lights of any kind and place, receivers everywhere.
void check_everything(std::uint32_t seed, int rounds) {
    Numbers numbers(seed);
    Comparison comparison;
    for (int round = 0; round < rounds; ++round) {
        Scene scene = on_floor();
        const int objects = 1 + numbers.below(3);
        for (int i = 0; i < objects; ++i) {
            TorusShape shape;
            shape.center = vec3(0, 1.2f, 0) + numbers.in_box(1.5f);
            shape.radius = 0.3f + 0.6f * numbers.unit(), shape.tube = 0.05f + 0.4f * numbers.unit();
            shape.bump = numbers.unit() < 0.5f ? 0.0f : 0.1f * numbers.unit() * shape.tube;
            shape.around = 8 + numbers.below(70), shape.across = 6 + numbers.below(40);
            shape.end = numbers.unit() < 0.6f ? shape.around : 1 + numbers.below(shape.around);
            shape.flipped = numbers.unit() < 0.7f ? 0 : 1 + numbers.below(200);
            add_torus(scene, shape);
        }
        if (numbers.unit() < 0.3f)
            add_sphere(scene, numbers.in_box(2.0f), 0.1f + numbers.unit(), 10 + numbers.below(40));
        const LightType types[] = {LightType::Rectangle, LightType::Disk, LightType::Sphere, LightType::Rectangle};
        Light light = random_light(numbers, types[numbers.below(4)], 1.0f, vec3(0));
        if (numbers.unit() < 0.7f) light.position.y = 1.0f + 4.0f * numbers.unit();
        const Comparison found = compare(scene, light, numbers, 4, 16 + numbers.below(1100));
        comparison.wrong += found.wrong, comparison.receivers += found.receivers;
        comparison.rays += found.rays, comparison.rays_alone += found.rays_alone;
    }
    INFO("seed " << seed << ": " << comparison.rays << " of " << comparison.rays_alone << " rays");
    CHECK(comparison.wrong == 0);
    CHECK(comparison.rays < comparison.rays_alone);
}

} // namespace

TEST_CASE("silhouettes give the bits of rays alone for any surface, light and receiver", "[raytrace][silhouettes]") {
    for (const std::uint32_t seed : {101u, 102u}) check_everything(seed, 20);
}

TEST_CASE("a soak of silhouettes", "[raytrace][silhouettes][.long]") {
    for (std::uint32_t seed = 1001; seed < 1041; ++seed) check_everything(seed, 60);
}
