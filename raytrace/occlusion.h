#pragma once
// Which of a light's sample points a receiver sees: the one question that visibility, radiance and error bars ask, and
// the one place where a proof may stand in for rays. A proof ("all seen", "none seen", "only these triangles can be in
// between") must give the very bits that the rays would.

#include <cstdint>
#include <span>

#include "core/light.h"
#include "core/receiver.h"
#include "raytrace/embree_scene.h"

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
// thread; whatever holds for the whole block is worked out once, in the constructor.
class Occlusion {
public:
    Occlusion(const EmbreeScene& scene, const Light& light, std::span<const Receiver> block);

    // Which of the points of the light `receiver`, one of the block, sees. A directional light has no points: it is
    // asked with one, whose coordinates do not matter. `seen` has seen_words(points.size()) words, all of which are
    // written. A proof saves rays, and the answer's count of them says so.
    EmbreeScene::SeenCount seen(const Receiver& receiver, const SamplePoints& points, SeenBits seen) const;

private:
    const EmbreeScene& scene_;
    const Light& light_;
};

} // namespace gnomon
