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
constexpr std::int64_t most_loss(std::size_t rays) {
    return static_cast<std::int64_t>(rays) * effort_per_ray / rays_per_loss;
}
// The same for silhouettes, which look at a cluster once a block; and of how many triangles a receiver
// may have to ask the states before its rays are cheaper.
constexpr std::size_t clusters_of_view_per_sample = 4, most_unknown = 128 * cluster_size;
// What a ray costs where silhouettes are near: there it goes through the most boxes.
constexpr std::int64_t effort_per_hard_ray = 16;
// Receivers, and what they cost on average, in effort, before silhouettes are tried.
constexpr std::int64_t enough_receivers = 8, cheap = 3000;
// Clusters smaller than this part of the light hide so little of it that many would have to be asked for a packet.
constexpr double fine_cluster = 1.0 / 24;
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

// Whether the clusters around the block are small beside the light, on average.
bool is_fine(const ClusterList& nearby, const Light& light) {
    double sum = 0;
    for (std::size_t i = 0; i < nearby.clusters.size(); ++i) {
        float extent = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            extent = larger(extent, nearby.maximum[axis][i] - nearby.minimum[axis][i]);
        sum += static_cast<double>(extent);
    }
    const double side = static_cast<double>(std::min(light.size.x, light.size.y));
    return sum < fine_cluster * side * static_cast<double>(nearby.clusters.size());
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
    const BlockView view = view_of(block, origins);
    Bounds around = light_bounds(light);
    const vec3 beyond = (0.5f * (light_growth - 1.0f)) * around.extent();
    around = {around.minimum - beyond, around.maximum + beyond};
    ClusterSearch search(shaft_between(origins, around), *clusters);
    few_ = search.find(samples * clusters_of_block_per_sample);
    if (!few_ && (!view.usable || too_many_unknown(view, *clusters, search.found(), most_unknown))) return;
    if (!few_ && !search.find(samples * clusters_of_view_per_sample)) return;
    for (Budget* budget : {&by_occluders_, &by_silhouettes_})
        budget->left = budget->most = most_loss(block.size() * samples);
    view_ = view;
    ClusterList nearby = search.take();
    fine_ = is_fine(nearby, light);
    if (few_)
        nearby_ = OccluderSet(clusters->clusters, std::move(nearby));
    else
        make_silhouettes(nearby.clusters);
}

void Occlusion::make_silhouettes(std::span<const std::uint32_t> nearby) {
    std::optional<Outline> outline = find_outline(view_, *clusters_, nearby, most_unknown);
    if (outline) silhouettes_.emplace(scene_, light_, std::move(*outline));
    view_.usable = outline.has_value();
}

// What silhouettes need to know of the block; nothing where most of the scene's triangles have open edges.
BlockView Occlusion::view_of(std::span<const Receiver> block, const Bounds& origins) const {
    if (2 * clusters_->open_triangles >= clusters_->triangle_count) return {};
    float rounding = 0;
    for (const Receiver& receiver : block)
        if (receiver.valid()) rounding = std::max(rounding, scene_.shadow_origin(receiver).world_rounding);
    return block_view(light_, origins, rounding);
}

bool Occlusion::Budget::spend(std::size_t effort) {
    left -= static_cast<std::int64_t>(effort);
    spent += static_cast<std::int64_t>(effort);
    return left > 0;
}

void Occlusion::Budget::learn(std::int64_t rays) {
    ++receivers;
    spent += rays * effort_per_hard_ray;
}

void Occlusion::Budget::save(std::size_t rays) {
    left = std::min(most, left + static_cast<std::int64_t>(rays) * effort_per_ray);
}

// False where the block's effort is used up; then rays answer for the rest of it.
bool Occlusion::spend(std::size_t effort) {
    if (by_occluders_.spend(effort)) return true;
    known_ = false;
    return false;
}

// Whether a receiver about which occluders have proven nothing as a whole is a case for silhouettes: where triangles
// are fine, or where occluders have turned out dearer in the block.
bool Occlusion::silhouettes_pay() {
    if (!view_.usable || by_silhouettes_.left <= 0) return false;
    if (few_ && !fine_ && by_occluders_.left > 0) {
        if (by_occluders_.receivers < enough_receivers || by_occluders_.mean() < cheap) return false;
        if (by_silhouettes_.receivers > 0) return by_silhouettes_.mean() < by_occluders_.mean();
    }
    if (!silhouettes_) make_silhouettes(nearby_.clusters());
    return silhouettes_.has_value();
}

// What the triangles in a box may hide from the receiver.
const OccluderGroup& Occlusion::group(std::uint32_t box) {
    bool made = false;
    const OccluderGroup& found = nearby_.group(pyramid_, proven_.triangle, box, made);
    if (made) spend(project_effort);
    return found;
}

Occlusion::Proof Occlusion::prove(const Receiver& receiver) {
    if (!(few_ && by_occluders_.left > 0) && !(view_.usable && by_silhouettes_.left > 0)) return Proof::None;
    if (same(receiver, proven_)) return proof_;
    proven_ = receiver;
    proof_ = Proof::None;
    known_ = false;
    nearby_.forget();
    outlined_ = false;
    pyramid_ = pyramid_of(light_, receiver, scene_.shadow_origin(receiver), scene_.corners(receiver.triangle));
    if (pyramid_.none_faces) return proof_ = Proof::NoneSeen;
    if (!pyramid_.usable) return proof_;
    const bool occluders_may = few_ && by_occluders_.left > 0;
    // Once silhouettes have been needed in the block they come first where triangles are fine.
    if (occluders_may && !(fine_ && silhouettes_ && silhouettes_pay())) proof_ = prove_by_occluders();
    if (proof_ == Proof::None && silhouettes_pay()) proof_ = prove_by_silhouettes();
    if (!outlined_ && occluders_may && !known_) proof_ = prove_by_occluders();
    return proof_;
}

Occlusion::Proof Occlusion::prove_by_occluders() {
    if (!spend(nearby_.size() / boxes_per_effort)) return Proof::None;
    const TouchedBoxes& touched = nearby_.touch(pyramid_);
    known_ = true;
    Proof proof = Proof::None;
    std::size_t clear = 0;
    for (; known_ && clear < touched.count; ++clear) {
        const OccluderGroup& first = group(touched.box[clear]);
        if (first.hides_all) proof = Proof::NoneSeen;
        if (first.hides_all || first.present) break;
    }
    if (known_ && clear == touched.count && pyramid_.all_face) proof = Proof::AllSeen;
    if (proof != Proof::None) by_occluders_.save(samples_);
    return proof;
}

Occlusion::Proof Occlusion::prove_by_silhouettes() {
    outlined_ = silhouettes_->aim(proven_, pyramid_);
    by_silhouettes_.spend(silhouettes_->effort());
    if (!outlined_) return Proof::None;
    known_ = false;
    const std::optional<bool> all = silhouettes_->all_alike(proven_, pyramid_);
    if (!all) return Proof::None;
    ++rays_before_;
    by_silhouettes_.save(samples_);
    return *all ? Proof::AllSeen : Proof::NoneSeen;
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
    spend(nearby_.touched().count / 64);
    const std::size_t count = kernels.reach(nearby_.touched(), range, clusters_per_packet, reached);
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
        const auto found = std::lower_bound(nearby_.clusters().begin(), nearby_.clusters().end(), cluster);
        if (found != nearby_.clusters().end() && *found == cluster)
            hints.add(static_cast<std::uint32_t>(found - nearby_.clusters().begin()));
    }
}

EmbreeScene::SeenCount Occlusion::seen_by_packets(const Receiver& receiver, const SamplePoints& points, SeenBits seen) {
    EmbreeScene::SeenCount answer;
    ShadowRays rays = scene_.rays_from(receiver);
    PointBlock block;
    for (std::size_t first = 0; first < points.size(); first += PointBlock::points) {
        const std::size_t count = std::min(PointBlock::points, points.size() - first), packets = seen_words(count);
        if (known_ || outlined_) aim(pyramid_, points, first, count, block);
        std::uint16_t facing[PointBlock::packets];
        for (std::size_t k = 0; k < packets; ++k)
            facing[k] = static_cast<std::uint16_t>(
                facing_points(receiver, pyramid_, points, first + 16 * k, std::min<std::size_t>(16, count - 16 * k)));
        // The whole packet, as it is traced without proofs: what Embree rounds may depend on a ray's company.
        const auto trace = [&](std::size_t k) {
            const std::size_t start = first + 16 * k, present = std::min<std::size_t>(16, count - 16 * k);
            const ShadowRays::Mask mask =
                rays.to_targets(&points.x[start], &points.y[start], &points.z[start], present);
            answer.rays += __builtin_popcount(mask.traced);
            return mask.seen;
        };
        SilhouetteProofs::Seen by_silhouettes{};
        if (outlined_) {
            silhouettes_->settle(receiver, pyramid_, block, {facing, packets}, trace, by_silhouettes);
            const auto settled = [](const std::optional<unsigned>& open) { return open.has_value(); };
            by_silhouettes_.save(
                16 * static_cast<std::size_t>(std::count_if(by_silhouettes.begin(), by_silhouettes.end(), settled)));
        }
        for (std::size_t k = 0; k < packets; ++k) {
            std::optional<unsigned> open = by_silhouettes[k];
            if (facing[k] == 0) open = 0;
            Hints* hints = nullptr;
            if (!open && known_ && spend(packet_effort)) {
                const PointRange range = point_kernels().range(block, k, facing[k]);
                hints = &hints_at(range);
                open = settle(block, k, facing[k], range, *hints);
                if (open) by_occluders_.save(16);
            }
            if (!open) {
                open = trace(k);
                if (hints) learn(rays, *hints);
            }
            seen[first / 16 + k] = static_cast<std::uint16_t>(*open);
            answer.seen += static_cast<std::size_t>(__builtin_popcount(*open));
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
    EmbreeScene::SeenCount answer;
    if (proof == Proof::None) {
        const bool asked = same(receiver, proven_), by_packets = asked && (known_ || outlined_);
        Budget& way = outlined_ ? by_silhouettes_ : by_occluders_;
        answer = by_packets ? seen_by_packets(receiver, points, seen)
                            : scene_.seen_samples(receiver, points.x, points.y, points.z, seen);
        if (asked) way.learn(answer.rays);
    } else {
        std::fill(seen.begin(), seen.end(), proof == Proof::AllSeen ? std::uint16_t{0xffff} : std::uint16_t{0});
        if (const std::size_t last = points.size() % 16) seen.back() &= static_cast<std::uint16_t>((1u << last) - 1u);
        answer.seen = proof == Proof::AllSeen ? points.size() : 0;
    }
    answer.rays += rays_before_;
    rays_before_ = 0;
    return answer;
}

} // namespace gnomon
