// Loads a scene, asks the ray tracer one question: core, raytrace and what they link are all needed.

#include <cstdio>

#include "core/scene.h"
#include "raytrace/embree_scene.h"

int main() {
    const gnomon::Scene scene = gnomon::load_scene("builtin:default");
    const gnomon::EmbreeScene rays(scene);
    const gnomon::vec3 above = scene.bounds.center() + gnomon::vec3(0, scene.bounds.diagonal(), 0);
    const auto hit = rays.first_hit(above, {0, -1, 0}, 0, gnomon::infinity);
    std::printf("%zu triangles, the ray meets %u\n", scene.triangles.size(), hit.triangle);
    return hit.triangle < scene.triangles.size() ? 0 : 1;
}
