#pragma once
// What every technique is judged by: hard visibility by one ray, area-light visibility and direct illumination by N.
//
// Visibility is 1 where the camera sees nothing, and 0 where the receiver's geometric normal does not face the light
// point.

#include <functional>
#include <optional>

#include "core/image.h"
#include "core/receiver.h"
#include "raytrace/embree_scene.h"
#include "raytrace/pattern.h"
#include "raytrace/radiance.h"

namespace gnomon {

class Progress;
class TruthState;
struct TriangleClusters;

// The image is traced in squares of this many pixels, row by row from the bottom left: what runs are saved and split
// by.
inline constexpr int truth_tile_side = 16;
constexpr int truth_tiles_across(int pixels) { return (pixels + truth_tile_side - 1) / truth_tile_side; }

// Part `part` of `parts` (from 1) has the tiles t with t mod parts = part − 1.
struct TileShare {
    int part = 1, parts = 1;
    bool has(std::size_t tile) const {
        return tile % static_cast<std::size_t>(parts) == static_cast<std::size_t>(part - 1);
    }
};

struct TruthSettings {
    Pattern pattern = Pattern::Sobol;
    int samples = 1024;
    std::uint32_t seed = 0;
    // Above 0, a pixel stops after 64, 256, 1024, … samples as soon as its error bar is not above it. Needs a pattern
    // that is a sequence.
    float target_error = 0;
    Brdf brdf = Brdf::Lambert;
    // Of a pixel with a receiver; where it is set, radiance is integrated as well.
    std::function<Surface(int x, int y)> surface;
};

// What a run leans on besides its settings; none of it changes the answer for the tiles of the share.
struct TruthRun {
    Progress* progress = nullptr;  // advances by one a pixel
    TruthState* state = nullptr;   // where finished tiles are kept
    std::uint32_t light_index = 0; // under which number
    TileShare share;
    const TriangleClusters* clusters = nullptr; // of the scene: proofs answer where they can; otherwise rays alone do
};

// All images are of the receivers' size. Tiles of others' shares have visibility 1.
struct TruthAnswer {
    Image<float> visibility;             // seen / samples
    Image<float> error;                  // see error_bar.h; 0 where there is no receiver, and for punctual lights
    Image<float> samples;                // taken; 0 where there is no receiver
    std::optional<Image<vec3>> radiance; // W/(m² sr), the light's part of what the surface sends to the viewer
    std::int64_t rays = 0;               // traced now: those of tiles that the state had are not among them
};

// The fraction of points of the light that each receiver sees. A punctual light has one point. Throws UsageError for a
// target error with a pattern that is no sequence, InputError where the state cannot be written, and Error
// (Interrupted, Terminated) once the state has been saved where an InterruptScope was asked to stop.
TruthAnswer area_truth(const EmbreeScene& scene, const Receivers& receivers, const Light& light,
                       const TruthSettings& settings, const TruthRun& run = {});

// Its visibility alone.
Image<float> area_visibility(const EmbreeScene& scene, const Receivers& receivers, const Light& light, Pattern pattern,
                             int samples, std::uint32_t seed, Progress* progress,
                             const TriangleClusters* clusters = nullptr);

// One ray from each receiver to the light's centre (or against its direction): 1 seen, 0 not.
TruthAnswer hard_truth(const EmbreeScene& scene, const Receivers& receivers, const Light& light);

} // namespace gnomon
