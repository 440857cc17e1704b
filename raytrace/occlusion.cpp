#include "raytrace/occlusion.h"

#include <algorithm>

#include "raytrace/shadow_rays.h"

namespace gnomon {
namespace {

// Proofs are given up where rays are cheaper. One unit of effort is a point tested against the triangles of a cluster;
// the other numbers are multiples of its time, as measured.
constexpr std::size_t project_effort = 16, shade_effort = 8, boxes_per_effort = 4, packet_effort = 8;
constexpr std::int64_t effort_per_ray = 8;
constexpr std::size_t clusters_of_block_per_sample = 1;
// What a block may lose on proofs: this part of what its rays cost.
constexpr std::int64_t rays_per_loss = 20;
// Clusters that are looked at before a packet's rays are cheaper.
constexpr std::size_t clusters_per_packet = 24;

bool same(const Receiver& a, const Receiver& b) {
    return a.position == b.position && a.geometric_normal == b.geometric_normal && a.triangle == b.triangle;
}

// The points of a packet above the receiver's horizon, as faces() has it.
unsigned facing_points(const Receiver& receiver, const Pyramid& pyramid, const SamplePoints& points, std::size_t first,
                       std::size_t count) {
    if (pyramid.all_face) return (1u << count) - 1u;
    unsigned facing = 0;
    for (std::size_t i = 0; i < count; ++i)
        facing |= (faces(receiver, vec3(points.x[first + i], points.y[first + i], points.z[first + i])) ? 1u : 0u) << i;
    return facing;
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
    const std::size_t boxes = nearby_->clusters.size();
    touched_.resize(boxes);
    group_of_.resize(boxes);
    balance_ = static_cast<std::int64_t>(block.size() * samples) * effort_per_ray / rays_per_loss;
    most_balance_ = balance_;
}

// False where the block's effort is used up; then rays answer for the rest of it.
bool Occlusion::spend(std::size_t effort) {
    balance_ -= static_cast<std::int64_t>(effort);
    if (balance_ > 0) return true;
    known_ = false;
    return false;
}

void Occlusion::save(std::size_t rays) {
    balance_ = std::min(most_balance_, balance_ + static_cast<std::int64_t>(rays) * effort_per_ray);
}

// What the triangles in a box may hide from the receiver.
const OccluderGroup& Occlusion::group(std::uint32_t box) {
    std::uint32_t& place = group_of_[box];
    if (place < groups_used_ && box_of_[place] == box) return groups_[place];
    place = static_cast<std::uint32_t>(groups_used_++);
    if (groups_.size() < groups_used_) groups_.resize(groups_used_ + 15), box_of_.resize(groups_used_ + 15);
    box_of_[place] = box;
    spend(project_effort);
    occluder_kernels().project(pyramid_, clusters_->clusters[nearby_->clusters[box]], proven_.triangle, groups_[place]);
    return groups_[place];
}

Occlusion::Proof Occlusion::prove(const Receiver& receiver) {
    if (!nearby_ || balance_ <= 0) return Proof::None;
    if (same(receiver, proven_)) return proof_;
    proven_ = receiver;
    proof_ = Proof::None;
    known_ = false;
    groups_used_ = 0;
    pyramid_ = pyramid_of(light_, receiver, scene_.shadow_origin(receiver), scene_.corners(receiver.triangle));
    if (pyramid_.none_faces) return proof_ = Proof::NoneSeen;
    if (!pyramid_.usable) return proof_;
    if (!spend(nearby_->clusters.size() / boxes_per_effort)) return proof_;
    occluder_kernels().touch(pyramid_, nearby_->boxes(), touched_);
    known_ = true;
    std::size_t clear = 0;
    for (; known_ && clear < touched_.count; ++clear) {
        const OccluderGroup& first = group(touched_.box[clear]);
        if (first.hides_all) proof_ = Proof::NoneSeen;
        if (first.hides_all || first.present) break;
    }
    if (known_ && clear == touched_.count && pyramid_.all_face) proof_ = Proof::AllSeen;
    if (proof_ != Proof::None) save(samples_);
    return proof_;
}

void Occlusion::Hints::add(std::uint32_t hint) {
    std::size_t place = static_cast<std::size_t>(std::find(box, box + count, hint) - box);
    if (place == count) place = count < most ? count++ : most - 1;
    std::copy_backward(box, box + place, box + place + 1);
    box[0] = hint;
}

Occlusion::Hints& Occlusion::hints_at(const PointRange& range) {
    const auto cell = [](float low, float high) {
        const float place = (0.5f * (low + high) + 1.0f) * (0.5f * static_cast<float>(cells_across));
        return static_cast<std::size_t>(std::clamp(place, 0.0f, static_cast<float>(cells_across - 1)));
    };
    return hints_[cell(range.b_low, range.b_high) * cells_across + cell(range.a_low, range.a_high)];
}

// Whether the packet's points that face are all hidden now.
bool Occlusion::shade(std::uint32_t box, const PointBlock& block, std::size_t packet, const PointRange& range,
                      unsigned facing, PacketVerdict& verdict) {
    const OccluderGroup& occluders = group(box);
    if (!occluders.present) return false;
    spend(shade_effort);
    point_kernels().shade(occluders, block, packet, range, facing & ~verdict.hidden, verdict);
    return (facing & ~verdict.hidden) == 0;
}

// Which points of a packet are seen, where that is certain: first beside what hid the same part of the light from other
// receivers, then beside all that can hide what is left.
std::optional<unsigned> Occlusion::settle(const PointBlock& block, std::size_t packet, unsigned facing,
                                          PointRange range, Hints& hints) {
    const PointKernels& kernels = point_kernels();
    PacketVerdict verdict;
    const Hints tried = hints;
    for (std::size_t i = 0; i < tried.count; ++i) {
        const unsigned before = verdict.hidden;
        const bool done = shade(tried.box[i], block, packet, range, facing, verdict);
        if (verdict.hidden != before && i > 0) hints.add(tried.box[i]);
        if (done) return 0u;
    }
    if (tried.count > 0 && verdict.hidden) range = kernels.range(block, packet, facing & ~verdict.hidden);
    std::uint32_t reached[clusters_per_packet];
    spend(touched_.count / 64);
    const std::size_t count = kernels.reach(touched_, range, clusters_per_packet, reached);
    if (count > clusters_per_packet) return std::nullopt;
    for (std::size_t i = 0; i < count; ++i) {
        if (std::find(tried.box, tried.box + tried.count, reached[i]) != tried.box + tried.count) continue;
        const unsigned before = verdict.hidden;
        const bool done = shade(reached[i], block, packet, range, facing, verdict);
        if (verdict.hidden != before) hints.add(reached[i]);
        if (done) return 0u;
    }
    const unsigned open = facing & ~verdict.hidden;
    if (open & verdict.possible) return std::nullopt;
    return open;
}

// The clusters that the rays have met become hints.
void Occlusion::learn(ShadowRays& rays, Hints& hints) const {
    std::array<std::uint32_t, ShadowRays::packet_size> met;
    const std::size_t count = rays.take_met(met);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t cluster = clusters_->cluster_of[met[i]];
        const auto found = std::lower_bound(nearby_->clusters.begin(), nearby_->clusters.end(), cluster);
        if (found != nearby_->clusters.end() && *found == cluster)
            hints.add(static_cast<std::uint32_t>(found - nearby_->clusters.begin()));
    }
}

EmbreeScene::SeenCount Occlusion::seen_by_occluders(const Receiver& receiver, const SamplePoints& points,
                                                    SeenBits seen) {
    EmbreeScene::SeenCount answer;
    ShadowRays rays = scene_.rays_from(receiver);
    PointBlock block;
    for (std::size_t first = 0; first < points.size(); first += PointBlock::points) {
        const std::size_t count = std::min(PointBlock::points, points.size() - first), packets = seen_words(count);
        if (known_) aim(pyramid_, points, first, count, block);
        for (std::size_t k = 0; k < packets; ++k) {
            const std::size_t start = first + 16 * k, present = std::min<std::size_t>(16, points.size() - start);
            std::uint16_t& word = seen[start / 16];
            const unsigned facing = facing_points(receiver, pyramid_, points, start, present);
            Hints* hints = nullptr;
            std::optional<unsigned> open;
            if (facing == 0) open = 0;
            if (facing != 0 && known_ && spend(packet_effort)) {
                const PointRange range = point_kernels().range(block, k, facing);
                hints = &hints_at(range);
                open = settle(block, k, facing, range, *hints);
                if (open) save(16);
            }
            if (!open) {
                // The whole packet, as it is traced without proofs: what Embree rounds may depend on a ray's company.
                const ShadowRays::Mask mask =
                    rays.to_targets(&points.x[start], &points.y[start], &points.z[start], present);
                answer.rays += __builtin_popcount(mask.traced);
                open = mask.seen;
                if (hints) learn(rays, *hints);
            }
            word = static_cast<std::uint16_t>(*open);
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
