#pragma once
// Meshes and views for the checks.

#include <optional>
#include <string>
#include <vector>

#include "core/scene.h"
#include "tests/conformance/check.h"
#include "tests/conformance/duel.h"

namespace gnomon_conformance {

// The scene of this name: builtin:NAME, or a folder of the shared scenes; nothing where that is absent.
std::optional<Scene> find_scene(const std::string& name);

// World to clip space for a viewport of this aspect and vertical field of view (radians): the eye is outside the
// scene's bounding sphere and the whole of it inside the viewport, so that nothing is clipped. In a wide_viewport parts
// are off the target.
mat4 random_view(const Scene& scene, double aspect, float fov, Random& random);

} // namespace gnomon_conformance
