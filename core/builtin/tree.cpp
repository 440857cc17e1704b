// A tree: branches of every thickness and thousands of leaves, which are sheets. Its shadow is all penumbra, occluders
// lie behind one another at many depths, and no closed silhouette exists.

#include <array>
#include <cmath>

#include "core/builtin/builtin.h"
#include "core/primitives.h"
#include "core/random.h"

namespace gnomon {
namespace {

struct TreeParams {
    int seed = 1;
    int levels = 5;
    int leaves = 6;
    float light_size = 1.2f;
};
constexpr auto tree_fields =
    fields(field("seed", &TreeParams::seed, 0, 1000000, "", "which tree"),
           field("levels", &TreeParams::levels, 1, 8, "", "how often branches fork"),
           field("leaves", &TreeParams::leaves, 0, 100, "", "leaves on every twig"),
           field("light_size", &TreeParams::light_size, 0.001, 10, "m", "side of the square light"));

// Random numbers of one branch: a hash of its path from the root, so that no branch depends on how its siblings grew.
struct Dice {
    std::uint32_t path;
    std::uint32_t throws = 0;
    float operator()(float low, float high) { return low + (high - low) * to_unit(hash(path, ++throws)); }
};

struct Tree {
    MeshData wood, leaves;
    int leaves_per_twig;
};

vec3 tilted(vec3 axis, float angle, float around) {
    const vec3 tangent = any_tangent(axis), other = glm::cross(axis, tangent);
    return glm::normalize(axis * std::cos(angle) +
                          (tangent * std::cos(around) + other * std::sin(around)) * std::sin(angle));
}

void add_leaf(MeshData& leaves, vec3 at, vec3 axis, Dice& dice) {
    const vec3 along = tilted(axis, dice(0.4f, 1.3f), dice(0.0f, 6.2831853f));
    const vec3 across = glm::cross(along, any_tangent(along));
    const float length = dice(0.07f, 0.12f), width = 0.32f * length;
    const auto first = static_cast<std::uint32_t>(leaves.positions.size());
    const vec3 middle = at + along * (0.45f * length);
    leaves.positions.insert(leaves.positions.end(),
                            {at, middle + across * width, at + along * length, middle - across * width});
    leaves.triangles.emplace_back(first, first + 1, first + 2);
    leaves.triangles.emplace_back(first, first + 2, first + 3);
}

void grow(Tree& tree, vec3 start, vec3 axis, float length, float radius, int level, std::uint32_t path) {
    Dice dice{path};
    constexpr size_t pieces = 4;
    std::array<vec3, pieces + 1> points;
    std::array<float, pieces + 1> radii;
    points[0] = start;
    const float taper = 0.62f;
    for (size_t i = 0; i <= pieces; ++i) {
        const float t = static_cast<float>(i) / pieces;
        radii[i] = radius * (1.0f + (taper - 1.0f) * t);
        if (i == 0) continue;
        // Branches wander a little and bend upwards.
        axis = glm::normalize(tilted(axis, dice(0.0f, 0.16f), dice(0.0f, 6.2831853f)) + vec3(0, 0.04f, 0));
        points[i] = points[i - 1] + axis * (length / pieces);
    }
    append_mesh(tree.wood, tube_mesh(points, radii, level > 2 ? 14 : level > 0 ? 8 : 5));
    if (level == 0) {
        for (int i = 0; i < tree.leaves_per_twig; ++i)
            add_leaf(tree.leaves, points[1 + static_cast<size_t>(dice(0.0f, 3.999f))], axis, dice);
        return;
    }
    const int forks = level > 3 ? 3 : 2 + (dice(0.0f, 1.0f) > 0.4f ? 1 : 0);
    const float first_angle = dice(0.0f, 6.2831853f);
    for (int i = 0; i < forks; ++i) {
        const float around =
            first_angle + 6.2831853f * (static_cast<float>(i) + dice(-0.2f, 0.2f)) / static_cast<float>(forks);
        const vec3 direction = tilted(axis, dice(0.45f, 0.85f), around);
        grow(tree, points[pieces], direction, length * dice(0.66f, 0.82f), radius * taper * dice(0.62f, 0.78f),
             level - 1, hash(path, static_cast<std::uint32_t>(i) + 1u));
    }
}

Scene build(const TreeParams& params) {
    Scene scene;
    const std::uint32_t meadow = add_material(scene, "meadow", {0.52f, 0.56f, 0.36f});
    const std::uint32_t bark = add_material(scene, "bark", {0.38f, 0.27f, 0.19f});
    const std::uint32_t leaf = add_material(scene, "leaf", {0.30f, 0.46f, 0.14f});
    add_object(scene, "ground", grid_mesh({12.0f, 12.0f}, 48, 0.12f, 1.8f, 7), translation({0, -0.06, 0}), meadow);
    Tree tree{{}, {}, params.leaves};
    grow(tree, {0, -0.05f, 0}, {0, 1, 0}, 1.0f, 0.13f, params.levels,
         hash(static_cast<std::uint32_t>(params.seed), 0x7ee5u));
    add_object(scene, "wood", tree.wood, dmat4(1.0), bark);
    if (!tree.leaves.triangles.empty()) add_object(scene, "leaves", tree.leaves, dmat4(1.0), leaf);
    Light light =
        light_for_irradiance(LightType::Rectangle, {-3.6f, 7.5f, 2.4f}, {0, 0, 0}, vec2(params.light_size), 3.6f);
    light.name = "lamp";
    scene.lights.push_back(light);
    scene.cameras.push_back(scene_camera({3.4f, 3.6f, 7.6f}, {0.2f, 1.35f, 0.0f}, 40.0f));
    return scene;
}

} // namespace

BuiltinScene tree_scene() {
    return builtin_scene<TreeParams>("tree", "A tree with leaves on a meadow", tree_fields, build);
}

} // namespace gnomon
