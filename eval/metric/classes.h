#pragma once
// Lit, penumbra and umbra. A reference of 1024 rays counts as umbra with up to five of them unblocked.

#include <array>
#include <cstdint>

#include "eval/metrics.h"

namespace gnomon {

inline constexpr float umbra_up_to = 0.005f, lit_from = 0.995f;
// How far drawn visibility must be from the class of the reference to count as a leak or a false shadow.
inline constexpr float leak_above = 0.05f, false_shadow_below = 0.95f;

enum class ShadowClass { Umbra, Penumbra, Lit };

inline ShadowClass shadow_class(float visibility) {
    return visibility <= umbra_up_to ? ShadowClass::Umbra
           : visibility < lit_from   ? ShadowClass::Penumbra
                                     : ShadowClass::Lit;
}

// Pixels by class: [reference][test].
using ConfusionTable = std::array<std::array<std::int64_t, 3>, 3>;
ConfusionTable count_classes(const ImagePair& pair);

} // namespace gnomon
