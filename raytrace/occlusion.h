#pragma once
// Which of a light's sample points a receiver sees: the one question that visibility, radiance and error bars ask, and
// the one place where a proof may stand in for rays. A proof ("all seen", "none seen", "only these triangles can be in
// between") gives the very bits that the rays would.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/light.h"
#include "core/receiver.h"
#include "raytrace/embree_scene.h"
#include "raytrace/occluder_set.h"
#include "raytrace/point_block.h"
#include "raytrace/silhouette_proofs.h"

namespace gnomon {

// Points of a light as three arrays of coordinates in metres, all of one length. Neighbours in the arrays should be
// neighbours on the light: sixteen share a packet of rays.
struct SamplePoints {
    std::span<const float> x, y, z;
    std::size_t size() const { return x.size(); }
};

// One bit a sample: sample k is bit k % 16 of word k / 16; bits beyond the last sample are 0.
using SeenBits = std::span<std::uint16_t>;
constexpr std::size_t seen_words(std::size_t samples) { return (samples + 15) / 16; }

// What lies between one light and a block of receivers that are near each other (a tile of the image). Used by one
// thread; whatever holds for the whole block is worked out once, in the constructor. Receivers, light and points are in
// the local coordinates of the EmbreeScene.
class Occlusion {
public:
    // Without `clusters`, which are those of the scene, every question is answered by rays. `samples` is the number of
    // points that will be asked about: the more they are, the more effort a proof is worth.
    Occlusion(const EmbreeScene& scene, const Light& light, std::span<const Receiver> block, std::size_t samples,
              const TriangleClusters* clusters);

    // What is certain for every point of the light, before any are chosen. A directional light or a punctual one has
    // no such proofs.
    enum class Proof : std::uint8_t { None, AllSeen, NoneSeen };
    Proof prove(const Receiver& receiver);

    // Which of the points of the light `receiver`, one of the block, sees. A directional light has no points: it is
    // asked with one, whose coordinates do not matter. `seen` has seen_words(points.size()) words, all of which are
    // written. A proof saves rays, and the answer's count of them says so.
    EmbreeScene::SeenCount seen(const Receiver& receiver, const SamplePoints& points, SeenBits seen);

private:
    // Boxes of nearby_ whose triangles hid the light, or a part of it, from the last receivers.
    struct Hints {
        static constexpr std::size_t most = 16;
        std::uint32_t box[most];
        std::size_t count = 0;
        void add(std::uint32_t hint);
    };
    static constexpr std::size_t cells_across = 8;

    // What proofs of a kind may still cost in the block: they are given up where they turn out dearer than rays. And
    // what they have cost, for receivers about which nothing could be proven as a whole.
    struct Budget {
        std::int64_t left = 0, most = 0, spent = 0, receivers = 0;
        bool spend(std::size_t effort);
        void save(std::size_t rays);
        void learn(std::int64_t rays); // that a receiver has needed all the same
        std::int64_t mean() const { return spent / receivers; }
    };

    bool spend(std::size_t effort);
    BlockView view_of(std::span<const Receiver> block, const Bounds& origins) const;
    void make_silhouettes(std::span<const std::uint32_t> nearby);
    bool silhouettes_pay();
    Proof prove_by_occluders();
    Proof prove_by_silhouettes();
    const OccluderGroup& group(std::uint32_t box);
    Hints& hints_at(const PointRange& range);
    bool shade(std::uint32_t box, const PointBlock& block, std::size_t packet, const PointRange& range, unsigned facing,
               PacketVerdict& verdict);
    std::optional<unsigned> settle(const PointBlock& block, std::size_t packet, unsigned facing, PointRange range,
                                   Hints& hints);
    void learn(ShadowRays& rays, Hints& hints) const;
    EmbreeScene::SeenCount seen_by_packets(const Receiver& receiver, const SamplePoints& points, SeenBits seen);

    const EmbreeScene& scene_;
    const Light& light_;
    const TriangleClusters* clusters_;
    std::size_t samples_;
    OccluderSet nearby_; // of the block
    bool few_ = false;   // of them, so that each can be asked; otherwise there are none
    bool fine_ = false;  // they are small beside the light
    std::optional<SilhouetteProofs> silhouettes_;
    BlockView view_; // usable where silhouettes may be used
    Budget by_occluders_, by_silhouettes_;
    std::array<Hints, cells_across * cells_across> hints_; // by where on the light
    // Of the receiver that was asked about last.
    Receiver proven_;
    Proof proof_ = Proof::None;
    Pyramid pyramid_;
    bool known_ = false;           // nothing else can be in between
    bool outlined_ = false;        // silhouettes tell something
    std::int64_t rays_before_ = 0; // traced and not told yet
};

} // namespace gnomon
