#include "raytrace/triangle_clusters.h"

#include <algorithm>
#include <memory>
#include <type_traits>

#include "core/error.h"
#include "raytrace/embree_api.h"
#include "raytrace/neighbours.h"
#include "raytrace/shadow_origin.h"

namespace gnomon {
namespace {

// What Embree's builder makes: two children, or a leaf's triangles.
struct BuildNode {
    BuildNode* child[2];
    Bounds box[2];
    std::uint32_t count; // 0 for an inner node
    std::uint32_t triangle[cluster_size];
};

BuildNode* new_node(RTCThreadLocalAllocator allocator) {
    return static_cast<BuildNode*>(rtcThreadLocalAlloc(allocator, sizeof(BuildNode), alignof(BuildNode)));
}

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
    BuildNode* node = new_node(allocator);
    node->count = 0;
    return node;
}

void set_children(void* node, void** children, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i) static_cast<BuildNode*>(node)->child[i] = static_cast<BuildNode*>(children[i]);
}

void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
    for (unsigned i = 0; i < count; ++i)
        static_cast<BuildNode*>(node)->box[i] = {{bounds[i]->lower_x, bounds[i]->lower_y, bounds[i]->lower_z},
                                                 {bounds[i]->upper_x, bounds[i]->upper_y, bounds[i]->upper_z}};
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, size_t count, void*) {
    BuildNode* node = new_node(allocator);
    node->count = static_cast<std::uint32_t>(count);
    for (size_t i = 0; i < count; ++i) node->triangle[i] = primitives[i].primID;
    return node;
}

std::vector<RTCBuildPrimitive> primitives_of(const Scene& scene, vec3 shift, Bounds& all) {
    std::vector<RTCBuildPrimitive> primitives;
    primitives.reserve(scene.triangles.size());
    for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
        if (scene.objects[scene.triangle_objects[t]].light_source) continue;
        Bounds box;
        for (int k = 0; k < 3; ++k) box.extend(scene.positions[scene.triangles[t][k]] - shift);
        const vec3 a = box.minimum, b = box.maximum;
        primitives.push_back({a.x, a.y, a.z, 0, b.x, b.y, b.z, t});
        all.extend(a), all.extend(b);
    }
    return primitives;
}

TriangleCluster cluster_from(const Scene& scene, vec3 shift, const BuildNode& leaf) {
    TriangleCluster cluster;
    cluster.count = leaf.count;
    for (std::uint32_t i = 0; i < cluster_size; ++i) {
        const std::uint32_t t = leaf.triangle[i < leaf.count ? i : 0];
        cluster.triangle[i] = t;
        for (int k = 0; k < 3; ++k)
            for (int axis = 0; axis < 3; ++axis)
                cluster.corner[k][axis][i] = scene.positions[scene.triangles[t][k]][axis] - shift[axis];
    }
    return cluster;
}

// Copies a subtree into node `place`; depth first, so that what a query visits lies together.
void flatten(const Scene& scene, const BuildNode& from, size_t place, TriangleClusters& to) {
    if (from.count > 0) {
        to.nodes[place].first = static_cast<std::uint32_t>(to.clusters.size());
        to.nodes[place].leaf = true;
        for (std::uint32_t i = 0; i < from.count; ++i) to.cluster_of[from.triangle[i]] = to.nodes[place].first;
        to.clusters.push_back(cluster_from(scene, to.shift, from));
        return;
    }
    const size_t first = to.nodes.size();
    to.nodes[place].first = static_cast<std::uint32_t>(first);
    for (const Bounds& box : from.box) to.nodes.push_back({box, 0, false});
    for (size_t i = 0; i < 2; ++i) flatten(scene, *from.child[i], first + i, to);
}

} // namespace

TriangleClusters build_clusters(const Scene& scene) {
    TriangleClusters built;
    built.shift = local_shift(scene.positions);
    Bounds all;
    std::vector<RTCBuildPrimitive> primitives = primitives_of(scene, built.shift, all);
    if (primitives.empty()) return built;
    const std::unique_ptr<std::remove_pointer_t<RTCDevice>, decltype(&rtcReleaseDevice)> device(rtcNewDevice(nullptr),
                                                                                                rtcReleaseDevice);
    const std::unique_ptr<std::remove_pointer_t<RTCBVH>, decltype(&rtcReleaseBVH)> bvh(
        device ? rtcNewBVH(device.get()) : nullptr, rtcReleaseBVH);
    if (!bvh) throw Error(ExitCode::Internal, "Embree could not be started.");
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.bvh = bvh.get();
    arguments.primitives = primitives.data();
    arguments.primitiveCount = primitives.size();
    arguments.primitiveArrayCapacity = primitives.size();
    arguments.maxDepth = 1024; // as deep as the scene asks for
    arguments.sahBlockSize = cluster_size;
    arguments.minLeafSize = 1;
    arguments.maxLeafSize = cluster_size;
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    const auto* root = static_cast<const BuildNode*>(rtcBuildBVH(&arguments));
    if (!root) throw Error(ExitCode::Internal, "The memory does not suffice to sort the shadow casters.");
    built.nodes.push_back({all, 0, false});
    built.cluster_of.resize(scene.triangles.size());
    flatten(scene, *root, 0, built);
    built.neighbours = find_neighbours(built.clusters);
    built.triangle_count = primitives.size();
    for (std::size_t c = 0; c < built.clusters.size(); ++c)
        for (std::uint32_t i = 0; i < built.clusters[c].count; ++i) {
            const auto& over = built.neighbours[c].over;
            built.open_triangles +=
                over[0][i] == no_neighbour || over[1][i] == no_neighbour || over[2][i] == no_neighbour;
        }
    return built;
}

} // namespace gnomon
