#pragma once
// Non-conservative revectorization as a step of other techniques: its parameters and its answer.

#include "techniques/revectorize/map_silhouette.h"

namespace gnomon {

// Of techniques with one look-up a receiver on both sides of the silhouette.
struct RbsmNoncParams : RevectorizeParams {
    bool flip_isolated = true;
};
constexpr auto rbsm_nonc_fields =
    join(revectorize_fields,
         fields(field("flip-isolated", &RbsmNoncParams::flip_isolated,
                      "a texel that differs from all four neighbours takes their state", "author's programs")));

// V* of every receiver. (3.9)
Visibility revectorize_hard(Frame& frame, const Light& light, const RbsmNoncParams& params);

} // namespace gnomon
