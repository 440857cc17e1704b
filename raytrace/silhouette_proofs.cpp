#include "raytrace/silhouette_proofs.h"

#include <algorithm>
#include <utility>

#include "raytrace/shadow_rays.h"

namespace gnomon {
namespace {

// Clusters of flat triangles that are looked at before a packet's rays are cheaper.
constexpr std::size_t flat_per_packet = 16;

} // namespace

SilhouetteProofs::SilhouetteProofs(const EmbreeScene& scene, const Light& light, Outline outline)
    : scene_(scene), light_(light), outline_(std::move(outline)), flat_(outline_.flat, std::move(outline_.flat_boxes)) {
    images_.resize(outline_.edges);
    const auto constant = static_cast<std::size_t>(outline_.first_constant());
    states_.resize(constant + 3);
    states_[constant] = 1, states_[constant + 1] = -1, states_[constant + 2] = 0;
}

// The states of the outline's triangles; those that are not clear, apart.
void SilhouetteProofs::ask_states(const Receiver& receiver, const Pyramid& pyramid, const BlockView& view) {
    unclear_.clear();
    for (std::size_t c = 0; c < outline_.triangles.size(); ++c) {
        const TriangleCluster& cluster = outline_.triangles[c];
        const ClusterSides sides = silhouette_kernels().sides(view, cluster, &states_[cluster_size * c]);
        const unsigned present = (1u << cluster.count) - 1u;
        add_triangles(cluster, present & ~static_cast<unsigned>(sides.clear | sides.absent), unclear_);
    }
    unclear_groups_.resize(unclear_.size());
    for (std::size_t i = 0; i < unclear_.size(); ++i)
        occluder_kernels().project(pyramid, unclear_[i], receiver.triangle, unclear_groups_[i]);
    std::erase_if(unclear_groups_, [](const OccluderGroup& group) { return !group.present; });
}

bool SilhouetteProofs::aim(const Receiver& receiver, const Pyramid& pyramid) {
    const float rounding = scene_.shadow_origin(receiver).world_rounding;
    const BlockView view = block_view(light_, Bounds{pyramid.origin, pyramid.origin}, rounding);
    if (!view.usable) return false;
    ask_states(receiver, pyramid, view);
    flat_.forget();
    flat_touched_ = false;
    return crossing_kernels().project(pyramid, outline_, states_.data(), images_);
}

// As measured: for clusters, edges, images, and a receiver whatever it sees.
std::size_t SilhouetteProofs::effort() const {
    return 22 * (outline_.triangles.size() + unclear_.size()) + outline_.edges / 4 + 6 * images_.count + 600;
}

std::optional<bool> SilhouetteProofs::all_alike(const Receiver& receiver, const Pyramid& pyramid) const {
    if (images_.count > 0 || !unclear_groups_.empty() || !pyramid.all_face) return std::nullopt;
    const vec3 middle = pyramid.origin + pyramid.center;
    return scene_.rays_from(receiver).to_targets(&middle.x, &middle.y, &middle.z, 1).seen != 0;
}

// Whether Embree may find a flat triangle where rays to some points of a packet go.
bool SilhouetteProofs::meets_flat(const Receiver& receiver, const Pyramid& pyramid, const PointBlock& block,
                                  std::size_t packet, unsigned points) {
    if (!flat_touched_) flat_.touch(pyramid);
    flat_touched_ = true;
    const PointKernels& kernels = point_kernels();
    const PointRange range = kernels.range(block, packet, points);
    std::uint32_t reached[flat_per_packet];
    const std::size_t count = kernels.reach(flat_.touched(), range, flat_per_packet, reached);
    if (count > flat_per_packet) return true;
    PacketVerdict verdict;
    for (std::size_t i = 0; i < count && !(verdict.possible & points); ++i) {
        bool made = false;
        const OccluderGroup& group = flat_.group(pyramid, receiver.triangle, reached[i], made);
        if (group.present) kernels.shade(group, block, packet, range, points, verdict);
    }
    return (verdict.possible & points) != 0;
}

void SilhouetteProofs::settle(const Receiver& receiver, const Pyramid& pyramid, const PointBlock& block,
                              std::span<const std::uint16_t> facing, const Trace& trace, Seen& seen) {
    const CrossingKernels& kernels = crossing_kernels();
    const std::size_t packets = facing.size();
    PointCounts counts;
    kernels.count(pyramid, images_, block, packets, counts);
    // Where there is nothing else near, rays meet something where they cross triangles that are counted, and only
    // there.
    std::uint16_t plain[PointBlock::packets];
    for (std::size_t k = 0; k < packets; ++k)
        plain[k] = static_cast<std::uint16_t>(facing[k] & ~static_cast<unsigned>(counts.near[k] | counts.unsure[k]));
    // What the triangles that are not clear hide is asked of the packets that it matters to: those with the least
    // count.
    PacketVerdict by_unclear[PointBlock::packets];
    unsigned equal[PointBlock::packets], above[PointBlock::packets];
    std::uint64_t shaded = 0;
    std::size_t chosen = packets;
    while (chosen == packets) {
        if (std::all_of(plain, plain + packets, [](std::uint16_t bits) { return bits == 0; })) return;
        const std::int32_t least = kernels.least(counts, plain, packets);
        std::uint64_t open = 0;
        for (std::size_t k = 0; k < packets; ++k) {
            above[k] = kernels.above(counts, k, least, equal[k]);
            open |= std::uint64_t{(facing[k] & ~above[k]) != 0} << k;
        }
        kernels.shade(unclear_groups_, block, counts, open & ~shaded, by_unclear);
        for (std::size_t k = 0; k < packets; ++k) {
            if (open & ~shaded & std::uint64_t{1} << k)
                plain[k] = static_cast<std::uint16_t>(plain[k] & ~(by_unclear[k].possible | by_unclear[k].hidden));
            // Rays of whole packets that see the same are traced fastest.
            const unsigned certain = plain[k] & equal[k];
            if (certain == 0xffffu || (certain && chosen == packets)) chosen = k;
        }
        shaded |= open;
    }
    seen[chosen] = trace(chosen);
    const bool lit = (*seen[chosen] >> __builtin_ctz(equal[chosen] & plain[chosen]) & 1u) != 0;
    for (std::size_t k = 0; k < packets; ++k) {
        if (seen[k] || !facing[k]) continue;
        // Hidden by what is counted, or by what is not clear.
        const unsigned counted = (lit ? above[k] : above[k] | equal[k]) & ~static_cast<unsigned>(counts.unsure[k]);
        const unsigned left = facing[k] & ~counted & ~by_unclear[k].hidden;
        if (left & (~equal[k] | counts.unsure[k] | counts.close[k] | by_unclear[k].possible)) continue;
        if ((left & counts.near[k]) && meets_flat(receiver, pyramid, block, k, left & counts.near[k])) continue;
        seen[k] = left;
    }
}

} // namespace gnomon
