#include "tests/techniques/shading.h"

namespace gnomon_tests {

gnomon::Scene box_over_floor() {
    using namespace gnomon;
    Scene scene;
    scene.name = "box over floor";
    scene.materials.push_back({});
    MeshData floor;
    floor.positions = {{-5, 0, -5}, {5, 0, -5}, {5, 0, 5}, {-5, 0, 5}};
    floor.triangles = {{0, 2, 1}, {0, 3, 2}};
    add_object(scene, "floor", floor, dmat4(1.0), 0);
    MeshData box;
    for (int i = 0; i < 8; ++i)
        box.positions.push_back({i & 1 ? 0.5f : -0.5f, i & 2 ? 1.5f : 0.5f, i & 4 ? 0.5f : -0.5f});
    box.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 4, 6}, {0, 6, 2},
                     {1, 3, 7}, {1, 7, 5}, {2, 6, 7}, {2, 7, 3}, {0, 1, 5}, {0, 5, 4}};
    add_object(scene, "box", box, dmat4(1.0), 0);
    for (const vec3& p : scene.positions) scene.bounds.extend(p);
    Camera camera = look_at({0.0f, 7.0f, 6.0f}, {0.0f, 0.0f, 0.0f}, 0.8f);
    camera.near_plane = 1.0f;
    camera.far_plane = 30.0f;
    scene.cameras.push_back(camera);
    return scene;
}

} // namespace gnomon_tests
