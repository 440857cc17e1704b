#include "raytrace/occlusion.h"

#include <algorithm>

namespace gnomon {
namespace {

// Proofs are given up where rays are cheaper. One unit of effort is a point tested against the triangles of a cluster;
// the other numbers are multiples of its time, as measured. A block is given up at the first of its receivers that
// exceeds its effort.
constexpr std::size_t cluster_effort = 16, boxes_per_effort = 2, effort_per_ray = 8;
constexpr std::size_t clusters_of_block_per_sample = 1;

// Above so many points for each triangle of a cluster they are shaded triangle by triangle.
constexpr std::size_t points_per_triangle = 4;

bool same(const Receiver& a, const Receiver& b) {
    return a.position == b.position && a.geometric_normal == b.geometric_normal && a.triangle == b.triangle;
}

// The packets' points above the receiver's horizon, as faces() has it.
void find_facing(const Receiver& receiver, const Pyramid& pyramid, const SamplePoints& points, std::size_t first,
                 std::size_t count, PointBlock& block) {
    for (std::size_t packet = 0; 16 * packet < count; ++packet) {
        const std::size_t present = std::min<std::size_t>(16, count - 16 * packet);
        unsigned facing = (1u << present) - 1u;
        if (!pyramid.all_face) {
            facing = 0;
            for (std::size_t i = 0; i < present; ++i) {
                const std::size_t k = first + 16 * packet + i;
                facing |= (faces(receiver, vec3(points.x[k], points.y[k], points.z[k])) ? 1u : 0u) << i;
            }
        }
        block.facing[packet] = static_cast<std::uint16_t>(facing);
    }
}

void aim(const Pyramid& pyramid, const SamplePoints& points, std::size_t first, std::size_t count, PointBlock& block) {
    const PointKernels& kernels = point_kernels();
    const std::size_t packets = seen_words(count);
    if (count % 16 == 0)
        return kernels.aim(pyramid, &points.x[first], &points.y[first], &points.z[first], packets, block);
    float padded[3][PointBlock::points];
    const std::span<const float> from[3] = {points.x, points.y, points.z};
    for (int i = 0; i < 3; ++i) {
        std::copy_n(from[i].begin() + static_cast<std::ptrdiff_t>(first), count, padded[i]);
        std::fill(padded[i] + count, padded[i] + 16 * packets, padded[i][count - 1]);
    }
    kernels.aim(pyramid, padded[0], padded[1], padded[2], packets, block);
}

} // namespace

Occlusion::Occlusion(const EmbreeScene& scene, const Light& light, std::span<const Receiver> block, std::size_t samples,
                     const TriangleClusters* clusters)
    : scene_(scene), light_(light), clusters_(clusters), samples_(samples) {
    // A mesh's points lie in no parallelogram.
    if (!clusters || !is_area(light) || light.type == LightType::Mesh) return;
    Bounds origins;
    for (const Receiver& receiver : block)
        if (receiver.valid()) origins.extend(scene.shadow_origin(receiver).position);
    if (origins.empty()) return;
    nearby_ =
        clusters_in(shaft_between(origins, light_bounds(light)), *clusters, clusters_of_block_per_sample * samples);
    if (!nearby_) return;
    touched_.resize(nearby_->minimum[0].size());
}

// False where the effort is used up; then rays answer for the rest of the block.
bool Occlusion::spend(std::size_t effort) {
    effort_ -= std::min(effort_, effort);
    if (effort_ > 0) return true;
    nearby_.reset();
    known_ = false;
    return false;
}

// Whether anything in the box may hide something.
bool Occlusion::project(const TouchedBox& box, bool ranges) {
    const TriangleCluster& cluster = clusters_->clusters[nearby_->clusters[box.box]];
    occluder_kernels().project(pyramid_, cluster, proven_.triangle, ranges, group_);
    return group_.present != 0 || group_.hides_all;
}

Occlusion::Proof Occlusion::prove(const Receiver& receiver) {
    if (!nearby_) return Proof::None;
    if (same(receiver, proven_)) return proof_;
    proven_ = receiver;
    proof_ = Proof::None;
    known_ = false;
    pyramid_ = pyramid_of(light_, receiver, scene_.shadow_origin(receiver), scene_.corners(receiver.triangle));
    if (pyramid_.none_faces) return proof_ = Proof::NoneSeen;
    if (!pyramid_.usable) return proof_;
    effort_ = effort_per_ray * samples_;
    if (!spend(nearby_->clusters.size() / boxes_per_effort)) return proof_;
    first_ = 0;
    end_ = occluder_kernels().touch(pyramid_, nearby_->boxes(), touched_.data());
    known_ = true;
    while (first_ < end_ && spend(cluster_effort) && !project(touched_[first_], true)) ++first_;
    if (!known_) return proof_;
    if (first_ == end_ && pyramid_.all_face) proof_ = Proof::AllSeen;
    if (first_ < end_ && group_.hides_all) proof_ = Proof::NoneSeen;
    return proof_;
}

void Occlusion::shade(const TouchedBox& box, PointBlock& block) {
    const PointKernels& kernels = point_kernels();
    ReachedPoints reached;
    const std::size_t count = kernels.reach(box, block, reached);
    if (count == 0) return;
    if (!spend(cluster_effort + count)) return;
    const bool large = count > points_per_triangle * clusters_->clusters[nearby_->clusters[box.box]].count;
    if (project(box, large)) (large ? kernels.shade_triangles : kernels.shade_points)(group_, reached, block);
}

EmbreeScene::SeenCount Occlusion::seen_by_occluders(const Receiver& receiver, const SamplePoints& points,
                                                    SeenBits seen) {
    EmbreeScene::SeenCount answer;
    PointBlock block;
    for (std::size_t first = 0; first < points.size(); first += PointBlock::points) {
        const std::size_t count = std::min(PointBlock::points, points.size() - first), packets = seen_words(count);
        find_facing(receiver, pyramid_, points, first, count, block);
        aim(pyramid_, points, first, count, block);
        effort_ = effort_per_ray * count;
        for (std::size_t i = first_; known_ && i < end_ && block.open; ++i) shade(touched_[i], block);
        for (std::size_t k = 0; k < packets; ++k) {
            const std::size_t start = first + 16 * k, present = std::min<std::size_t>(16, points.size() - start);
            std::uint16_t& word = seen[start / 16];
            const unsigned open = block.facing[k] & ~static_cast<unsigned>(block.hidden[k]);
            if (open & (known_ ? block.possible[k] : 0xffffu)) {
                // The whole packet, as it is traced without proofs: what Embree rounds may depend on a ray's company.
                const auto traced =
                    scene_.seen_samples(receiver, points.x.subspan(start, present), points.y.subspan(start, present),
                                        points.z.subspan(start, present), {&word, 1});
                answer.rays += traced.rays;
            } else {
                word = static_cast<std::uint16_t>(open);
            }
            answer.seen += static_cast<std::size_t>(__builtin_popcount(word));
        }
    }
    return answer;
}

EmbreeScene::SeenCount Occlusion::seen(const Receiver& receiver, const SamplePoints& points, SeenBits seen) {
    if (light_.type == LightType::Directional) {
        const bool lit = scene_.seen_direction(receiver, -light_.direction);
        seen[0] = lit;
        return {lit ? std::size_t{1} : std::size_t{0}, 1};
    }
    const Proof proof = prove(receiver);
    if (proof == Proof::None && !known_) return scene_.seen_samples(receiver, points.x, points.y, points.z, seen);
    if (proof == Proof::None) return seen_by_occluders(receiver, points, seen);
    std::fill(seen.begin(), seen.end(), proof == Proof::AllSeen ? std::uint16_t{0xffff} : std::uint16_t{0});
    if (proof == Proof::NoneSeen) return {};
    if (const std::size_t last = points.size() % 16) seen.back() = static_cast<std::uint16_t>((1u << last) - 1u);
    return {points.size(), 0};
}

} // namespace gnomon
