#include "tests/techniques/mask_scene.h"

#include <algorithm>

#include "core/primitives.h"

namespace gnomon_tests {

using namespace gnomon;

namespace {

constexpr double half_floor = 4.0, spot_height = 5.0, spot_tangent = 0.5;
constexpr double widened = 1.001; // of every view, see light_view.cpp

double half_view(const MaskScene& mask, double y) {
    return widened * (mask.light.type == LightType::Spot ? spot_tangent * (spot_height - y) : half_floor);
}

} // namespace

vec2 MaskScene::texels(vec3 p) const {
    const double scale = mask_side / (2.0 * half_view(*this, static_cast<double>(p.y)));
    return vec2(dvec2(p.x, -p.z) * scale);
}

dvec3 MaskScene::world(double u, double v, double y) const {
    const double scale = 2.0 * half_view(*this, y) / mask_side;
    return {u * scale, y, -v * scale};
}

double MaskScene::texel_width() const { return 2.0 * half_view(*this, 0.0) / mask_side; }

MaskScene mask_scene_of(LightType type, const std::vector<int>& tops) {
    MaskScene mask;
    mask.light.type = type;
    mask.light.position = {0.0f, static_cast<float>(spot_height), 0.0f};
    mask.light.outer_cone = static_cast<float>(std::atan(spot_tangent));

    Scene& scene = mask.scene;
    scene.name = "mask";
    scene.materials.emplace_back();
    add_object(scene, "floor", plane_mesh(vec2(2.0f * static_cast<float>(half_floor))), dmat4(1.0), 0);
    constexpr int middle = mask_side / 2;
    MeshData sheets; // inside the floor's outline, which a directional light's view fits
    for (int i = 0; i < mask_side; ++i) {
        const int left = i - middle, top = std::clamp(tops[static_cast<size_t>(i)], -middle, middle);
        if (top == -middle) continue;
        const auto first = static_cast<std::uint32_t>(sheets.positions.size());
        for (const dvec2 corner :
             {dvec2(left, -middle), dvec2(left + 1, -middle), dvec2(left + 1, top), dvec2(left, top)})
            sheets.positions.push_back(vec3(glm::clamp(mask.world(corner.x, corner.y, 1.0), -half_floor, half_floor)));
        sheets.triangles.push_back({first, first + 1, first + 2});
        sheets.triangles.push_back({first, first + 2, first + 3});
    }
    if (!sheets.triangles.empty()) add_object(scene, "sheets", sheets, dmat4(1.0), 0);
    for (const vec3& p : scene.positions) scene.bounds.extend(p);

    Camera camera = look_at({0.0f, 0.9f, 0.0f}, {0.0f, 0.0f, 0.0f}, 1.0f);
    camera.orthographic = true;
    camera.view_height = static_cast<float>(16.0 * mask.texel_width());
    camera.near_plane = 0.01f;
    camera.far_plane = 2.01f;
    scene.cameras.push_back(camera);
    return mask;
}

} // namespace gnomon_tests
