#pragma once
// The comparison functions of depth, stencil and samplers, on whatever orders: depth keys, stencil values, floats.

#include "raster/state.h"

namespace gnomon {

// Whether `fresh test stored` holds.
template <class T> constexpr bool holds(Compare test, T fresh, T stored) {
    switch (test) {
    case Compare::Never:
        return false;
    case Compare::Less:
        return fresh < stored;
    case Compare::Equal:
        return fresh == stored;
    case Compare::LessEqual:
        return fresh <= stored;
    case Compare::Greater:
        return fresh > stored;
    case Compare::NotEqual:
        return fresh != stored;
    case Compare::GreaterEqual:
        return fresh >= stored;
    case Compare::Always:
        return true;
    }
    return true;
}

} // namespace gnomon
