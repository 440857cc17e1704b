#pragma once
// The entries of all techniques: each is defined at the end of its own file and named once more in registry.cpp.

#include "techniques/technique.h"

namespace gnomon {

Entry raytraced_entry();
Entry truth_entry();

} // namespace gnomon
